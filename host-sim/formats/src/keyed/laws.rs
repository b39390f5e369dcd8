//! The delay law of named arrays.

use super::Keyed;
use crate::variables::{Given, ORIGIN, TIMES};
use crate::waves::{Law, first_fires};
use bonebeam_files::{Error, Result, Transmits};

impl Keyed<'_> {
    /// The delay law, and the times of sample 0 from its origin, one for each transmit.
    pub(super) fn law_of(&self, transmits: usize, positions: &[[f64; 2]]) -> Result<Law> {
        let (law, mut t0) = match &self.law {
            Some(law) => law.clone(),
            None => (self.transmits(transmits)?, self.vector("t0")?),
        };
        self.check_count("the delay law", law.len(), transmits, "transmit")?;
        if let [one] = t0[..] {
            t0 = vec![one; transmits];
        }
        self.check_count("t0", t0.len(), transmits, "transmit")?;
        let is_first =
            matches!(self.variables.get(TIMES), Some(Given::Name(from)) if from != ORIGIN);
        if is_first && self.law.is_none() {
            let c = self.scalar("c")?;
            for (transmit, t0) in t0.iter_mut().enumerate() {
                *t0 += first_fires(&law, transmit, positions, c);
            }
        }
        Ok((law, t0))
    }

    /// Number of transmits of the delay law.
    ///
    /// # Errors
    /// No delay law, or an array that is not readable.
    pub fn transmits_given(&self) -> Result<usize> {
        self.check_that_all_is_given(None)?;
        self.transmits_of_law()?.ok_or_else(|| self.no_law())
    }

    /// Number of transmits of the delay law, if it does not depend on the samples.
    pub(super) fn transmits_of_law(&self) -> Result<Option<usize>> {
        if let Some((law, _)) = &self.law {
            return Ok(Some(law.len()));
        }
        for key in ["tx_x", "tx_angle", "tx_element", "tx_source_x"] {
            if self.variables.get(key).is_some_and(Given::is_spread) {
                return Ok(None);
            }
            if let Some(values) = self.optional(key)? {
                return Ok(Some(values.len()));
            }
        }
        let delays = self.optional_numbers("tx_delay")?;
        Ok(delays.and_then(|delays| delays.shape().first().copied()))
    }

    pub(super) fn no_law(&self) -> Error {
        self.source.error(
            "has no delay law; expected `tx_x` and `tx_focus`, `tx_angle`, `tx_element`, `tx_source_x` \
             and `tx_source_z`, or `tx_delay`, as arrays or in [variables]"
                .into(),
        )
    }

    fn transmits(&self, transmits: usize) -> Result<Transmits> {
        let given = |key: &str| self.name(key).is_some() || self.variables.get(key).is_some();
        let laws = [
            ("tx_x", given("tx_x") || given("tx_focus")),
            ("tx_angle", given("tx_angle")),
            ("tx_element", given("tx_element")),
            ("tx_source_x", given("tx_source_x") || given("tx_source_z")),
            ("tx_delay", given("tx_delay")),
        ];
        let mut given = laws.iter().filter(|(_, given)| *given).map(|(key, _)| *key);
        let law = given.next().ok_or_else(|| self.no_law())?;
        if let Some(other) = given.next() {
            return Err(self.source.error(format!(
                "has several delay laws (`{law}`, `{other}`); expected exactly one"
            )));
        }
        match law {
            "tx_x" => Ok(Transmits::Focused {
                x: self.vector("tx_x")?,
                focus: self.each("tx_focus", transmits)?,
                f_number: match self.optional("tx_fnumber")? {
                    Some(_) => Some(self.scalar("tx_fnumber")?),
                    None => None,
                },
            }),
            "tx_angle" => Ok(Transmits::Plane {
                angle: self.vector("tx_angle")?,
            }),
            "tx_element" => self.indices(),
            "tx_source_x" => Ok(Transmits::VirtualSource {
                x: self.each("tx_source_x", transmits)?,
                z: self.each("tx_source_z", transmits)?,
            }),
            _ => self.delays(),
        }
    }

    fn indices(&self) -> Result<Transmits> {
        let values = self.vector("tx_element")?;
        let index = |(transmit, &value): (usize, &f64)| {
            // The cast saturates; the comparison finds it out.
            let index = value as usize;
            match index as f64 == value {
                true => Ok(index),
                false => Err(self.source.error(format!(
                    "`tx_element` is {value} at transmit {transmit}; expected an index from 0"
                ))),
            }
        };
        let index = values
            .iter()
            .enumerate()
            .map(index)
            .collect::<Result<_>>()?;
        Ok(Transmits::Element { index })
    }

    fn delays(&self) -> Result<Transmits> {
        let delays = self
            .optional_numbers("tx_delay")?
            .ok_or_else(|| self.no_law())?;
        let shape = delays.shape().to_vec();
        let wrong = |_| {
            self.source.error(format!(
                "`tx_delay` has shape {shape:?}; expected [transmit, element]"
            ))
        };
        let mut delay: ndarray::Array2<f64> = delays.into_dimensionality().map_err(wrong)?;
        if let Some(active) = self.optional_numbers("tx_active")? {
            if active.shape() != delay.shape() {
                return Err(self.source.error(format!(
                    "`tx_active` has shape {:?}; expected that of `tx_delay`, {:?}",
                    active.shape(),
                    delay.shape()
                )));
            }
            for (delay, active) in delay.iter_mut().zip(&active) {
                if *active == 0.0 {
                    *delay = f64::NAN;
                }
            }
        }
        Ok(Transmits::Delays { delay })
    }
}
