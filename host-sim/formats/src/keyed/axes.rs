//! Axes of samples in a file, and conversion to those of channel data.

use ndarray::{Array4, ArrayD, Axis, IxDyn};

use crate::variables::{AXES, Given};
use bonebeam_files::{Error, Result};

/// The axes of samples, in the order of channel data.
pub(super) const ORDER: [&str; 4] = ["frame", "transmit", "element", "sample"];
const FRAME: usize = 0;
const TRANSMIT: usize = 1;
const ELEMENT: usize = 2;
const SAMPLE: usize = 3;

/// The axes of a file's samples.
pub(crate) struct Axes {
    /// Their indices in [`ORDER`]; `None` if they are those of channel data.
    roles: Option<Vec<usize>>,
    /// The axis along which transmits are concatenated, and the number of transmits.
    joined: Option<(usize, usize)>,
}

impl Axes {
    /// The given axes for an array of these sides.
    ///
    /// Transmits may be concatenated along the axis of the samples. A list of single records has no axis of elements.
    ///
    /// # Errors
    /// Names that are not axes, or missing axes.
    pub(crate) fn new(
        given: Option<&Given>,
        sides: Option<&[usize]>,
        transmits: Option<usize>,
        is_list: bool,
    ) -> Result<Self> {
        let Some(Given::Names(names)) = given else {
            return Ok(Self {
                roles: None,
                joined: None,
            });
        };
        let role = |name: &String| ORDER.iter().position(|known| known == name);
        let roles: Option<Vec<usize>> = names.iter().map(role).collect();
        let once = |roles: &Vec<usize>| {
            let needed = (is_list || roles.contains(&ELEMENT)) && roles.contains(&SAMPLE);
            needed && (0..4).all(|axis| roles.iter().filter(|&&p| p == axis).count() <= 1)
        };
        let roles = roles.filter(once).ok_or_else(|| {
            Error::Usage(format!(
                "`{AXES}` in [variables] is {}; expected element and sample once each, and transmit and \
                 frame if there are several",
                names.join(", ")
            ))
        })?;
        let joined = sides.and_then(|sides| joined(&roles, sides, transmits?));
        Ok(Self {
            roles: Some(roles),
            joined,
        })
    }

    /// The axis of the frames; `None` if there is one frame.
    pub(super) fn of_frames(&self, rank: usize) -> Option<usize> {
        let axis = match &self.roles {
            Some(roles) => {
                let axis = roles.iter().position(|&role| role == FRAME)?;
                let is_behind = self.joined.is_some_and(|(joined, _)| joined < axis);
                axis - usize::from(is_behind)
            }
            None if rank < ORDER.len() => return None,
            None => 0,
        };
        (axis < rank).then_some(axis)
    }

    /// Samples as [frame, transmit, element, sample], from the file's order of axes.
    ///
    /// # Errors
    /// A wrong number of axes.
    pub(crate) fn arranged<T: Clone>(
        &self,
        mut values: ArrayD<T>,
    ) -> std::result::Result<Array4<T>, String> {
        let shape = values.shape().to_vec();
        let mut roles = self.roles.clone();
        if let (Some((axis, transmits)), Some(roles)) = (self.joined, &mut roles) {
            let mut apart = shape.clone();
            apart[axis] /= transmits;
            apart.insert(axis, transmits);
            (roles[axis], roles[axis + 1]) = (TRANSMIT, SAMPLE);
            let values_in_order = values.as_standard_layout().into_owned();
            values = values_in_order
                .into_shape_with_order(IxDyn(&apart))
                .map_err(|e| format!("has shape {shape:?}: {e}"))?;
        }
        let count = roles.as_ref().map_or(shape.len().clamp(3, 4), Vec::len);
        // MATLAB drops axes of length 1 at the end; any file may have one too many there.
        while values.ndim() > count && values.shape().last() == Some(&1) {
            let last = Axis(values.ndim() - 1);
            values = values.index_axis_move(last, 0);
        }
        while roles.is_some() && values.ndim() < count {
            let end = Axis(values.ndim());
            values = values.insert_axis(end);
        }
        let mut roles = roles.unwrap_or_else(|| (4 - count..4).collect());
        if values.ndim() != roles.len() {
            return Err(format!(
                "has shape {shape:?}; expected [transmit, element, sample], or with a frame axis \
                 before them; give another order by --variable axes=sample,element,transmit"
            ));
        }
        for axis in [FRAME, TRANSMIT, ELEMENT] {
            if !roles.contains(&axis) {
                roles.push(axis);
                let end = Axis(values.ndim());
                values = values.insert_axis(end);
            }
        }
        let order: Vec<usize> = (0..4)
            .filter_map(|axis| roles.iter().position(|&role| role == axis))
            .collect();
        let values = values.permuted_axes(IxDyn(&order));
        let values = values.as_standard_layout().into_owned();
        values
            .into_dimensionality()
            .map_err(|e| format!("has shape {shape:?}: {e}"))
    }
}

/// The axis along which transmits are concatenated, if an axis is missing.
///
/// Transmit and sample must be neighbours, and the length a multiple of the transmits.
fn joined(roles: &[usize], sides: &[usize], transmits: usize) -> Option<(usize, usize)> {
    let axis_of = |axis: usize| roles.iter().position(|&role| role == axis);
    let (transmit, sample) = (axis_of(TRANSMIT)?, axis_of(SAMPLE)?);
    let axis = transmit.min(sample);
    let is_joined = transmits > 1
        && sides.len() + 1 == roles.len()
        && transmit.abs_diff(sample) == 1
        && sides.get(axis).is_some_and(|side| side % transmits == 0);
    is_joined.then_some((axis, transmits))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axes(names: &[&str], sides: &[usize], transmits: usize) -> Axes {
        let names = names.iter().map(|&name| name.to_owned()).collect();
        Axes::new(
            Some(&Given::Names(names)),
            Some(sides),
            Some(transmits),
            false,
        )
        .unwrap()
    }

    /// Two transmits of three elements and four samples, of which each tells its own place.
    #[test]
    fn transmits_that_follow_each_other_are_taken_apart() {
        let value = |t: usize, m: usize, n: usize| (100 * t + 10 * m + n) as f32;
        let all = Array4::from_shape_fn((1, 2, 3, 4), |(_, t, m, n)| value(t, m, n));
        let rows = ArrayD::from_shape_fn(IxDyn(&[3, 8]), |at| value(at[1] / 4, at[0], at[1] % 4));
        for names in [
            ["element", "transmit", "sample"],
            ["element", "sample", "transmit"],
        ] {
            let axes = axes(&names, &[3, 8], 2);
            assert_eq!(axes.arranged(rows.clone()).unwrap(), all);
        }
        let columns = rows.clone().reversed_axes().insert_axis(Axis(2));
        let names = ["sample", "transmit", "element", "frame"];
        let axes = axes(&names, &[8, 3, 1], 2);
        assert_eq!(axes.of_frames(3), Some(2));
        assert_eq!(axes.arranged(columns).unwrap(), all);
    }

    #[test]
    fn an_axis_that_is_left_out_is_one_transmit() {
        let axes = axes(&["sample", "element", "transmit"], &[8, 3], 1);
        let values = ArrayD::from_elem(IxDyn(&[8, 3]), 1.0f32);
        assert_eq!(axes.arranged(values).unwrap().dim(), (1, 1, 3, 8));
    }
}
