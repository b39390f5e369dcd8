//! Selection of an instruction set at run time.

use super::Vector;
use core::fmt;
use core::str::FromStr;

/// An instruction set that kernels are compiled for; it changes no bit.
///
/// With the feature `std`, the processor is asked at run time. Without it, an instruction set counts as available
/// if the compiler's target promises it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum InstructionSet {
    /// x86-64's baseline; 4 lanes.
    #[cfg(target_arch = "x86_64")]
    Sse2,
    /// AVX2; 8 lanes.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// AVX-512; 16 lanes.
    #[cfg(target_arch = "x86_64")]
    Avx512,
    /// AArch64's baseline; 4 lanes.
    #[cfg(target_arch = "aarch64")]
    Neon,
    /// No vectors; one lane, as on a microcontroller.
    Scalar,
}

/// A generic function over [`Vector`] with its arguments, for run-time dispatch.
///
/// [`InstructionSet::dispatch`] calls it with vectors of the chosen instruction set.
pub trait Task {
    /// Return type.
    type Output;

    /// Runs the task with vectors of the type of `zero`, a vector of zeros.
    fn run<V: Vector>(self, zero: V) -> Self::Output;
}

impl InstructionSet {
    /// All instruction sets of this processor architecture, the fastest first.
    pub const ALL: &[Self] = &[
        #[cfg(target_arch = "x86_64")]
        InstructionSet::Avx512,
        #[cfg(target_arch = "x86_64")]
        InstructionSet::Avx2,
        #[cfg(target_arch = "x86_64")]
        InstructionSet::Sse2,
        #[cfg(target_arch = "aarch64")]
        InstructionSet::Neon,
        InstructionSet::Scalar,
    ];

    /// Instruction sets that this processor has, the fastest first.
    pub fn available() -> impl Iterator<Item = Self> {
        Self::ALL.iter().copied().filter(|set| set.is_available())
    }

    /// The fastest instruction set that this processor has.
    pub fn detect() -> Self {
        Self::available().next().unwrap_or(InstructionSet::Scalar)
    }

    /// Whether this processor has the instruction set.
    pub fn is_available(self) -> bool {
        match self {
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512 => level().as_avx512().is_some(),
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => level().as_avx2().is_some(),
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Sse2 => level().as_sse2().is_some(),
            #[cfg(target_arch = "aarch64")]
            InstructionSet::Neon => level().as_neon().is_some(),
            InstructionSet::Scalar => true,
        }
    }

    /// Name for people.
    pub const fn name(self) -> &'static str {
        match self {
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Sse2 => "SSE2",
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => "AVX2",
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512 => "AVX-512",
            #[cfg(target_arch = "aarch64")]
            InstructionSet::Neon => "NEON",
            InstructionSet::Scalar => "one lane",
        }
    }

    /// Name for command lines and configurations; [`str::parse`] accepts it.
    pub const fn key(self) -> &'static str {
        match self {
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Sse2 => "sse2",
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512 => "avx512",
            #[cfg(target_arch = "aarch64")]
            InstructionSet::Neon => "neon",
            InstructionSet::Scalar => "scalar",
        }
    }

    /// Runs `task` with this instruction set's vectors.
    ///
    /// On a processor without it, the task runs with one lane.
    ///
    /// ```
    /// use bonebeam::Error;
    /// use bonebeam::image::median;
    /// use bonebeam::simd::{InstructionSet, Task, Vector};
    ///
    /// struct Median<'a> {
    ///     image: &'a [f32],
    ///     out: &'a mut [f32],
    /// }
    ///
    /// impl Task for Median<'_> {
    ///     type Output = Result<(), Error>;
    ///
    ///     fn run<V: Vector>(self, zero: V) -> Self::Output {
    ///         median(zero, self.image, 8, self.out)
    ///     }
    /// }
    ///
    /// let mut image = [1.0; 64];
    /// image[27] = 255.0;
    /// let mut out = [0.0; 64];
    /// let task = Median { image: &image, out: &mut out };
    /// InstructionSet::detect().dispatch(task)?;
    /// assert_eq!(out, [1.0; 64]);
    /// # Ok::<(), Error>(())
    /// ```
    pub fn dispatch<T: Task>(self, task: T) -> T::Output {
        match self {
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512 => {
                if let Some(simd) = level().as_avx512() {
                    return task.run(super::Lanes::new(simd));
                }
            }
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => {
                if let Some(simd) = level().as_avx2() {
                    return task.run(super::Lanes::new(simd));
                }
            }
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Sse2 => {
                if let Some(simd) = level().as_sse2() {
                    return task.run(super::Lanes::new(simd));
                }
            }
            #[cfg(target_arch = "aarch64")]
            InstructionSet::Neon => {
                if let Some(simd) = level().as_neon() {
                    return task.run(super::Lanes::new(simd));
                }
            }
            InstructionSet::Scalar => {}
        }
        task.run(0.0f32)
    }
}

/// The processor's level, or, if it cannot be asked, the target's.
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
fn level() -> fearless_simd::Level {
    use fearless_simd::Level;
    Level::try_detect().unwrap_or(Level::baseline())
}

/// Error for a name that is no instruction set of this processor architecture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct UnknownInstructionSet;

impl fmt::Display for UnknownInstructionSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("no instruction set of this processor architecture; expected one of")?;
        for (k, set) in InstructionSet::ALL.iter().enumerate() {
            write!(f, "{} {}", if k == 0 { "" } else { "," }, set.key())?;
        }
        Ok(())
    }
}

impl core::error::Error for UnknownInstructionSet {}

impl FromStr for InstructionSet {
    type Err = UnknownInstructionSet;

    fn from_str(key: &str) -> Result<Self, Self::Err> {
        let mut sets = Self::ALL.iter().copied();
        sets.find(|set| set.key() == key)
            .ok_or(UnknownInstructionSet)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;
    use std::vec::Vec;

    #[test]
    fn every_key_is_parsed_and_nothing_else() {
        for &set in InstructionSet::ALL {
            assert_eq!(set.key().parse(), Ok(set));
        }
        for other in ["", "AVX2", "one lane", "sse"] {
            assert_eq!(other.parse::<InstructionSet>(), Err(UnknownInstructionSet));
        }
        assert!(UnknownInstructionSet.to_string().ends_with("scalar"));
    }

    /// A name differs from the key by capitals, a hyphen or a space only; that of one lane is its own.
    #[test]
    fn a_name_is_its_key_as_people_write_it() {
        for &set in InstructionSet::ALL {
            let name = set.name().to_lowercase().replace('-', "");
            let key = match set {
                InstructionSet::Scalar => "one lane",
                _ => set.key(),
            };
            assert_eq!(name, key);
        }
    }

    struct Lanes;

    impl Task for Lanes {
        type Output = usize;

        fn run<V: Vector>(self, _: V) -> usize {
            V::LANES
        }
    }

    #[test]
    fn what_is_there_is_dispatched_to_and_the_widest_comes_first() {
        let lanes: Vec<usize> = InstructionSet::available()
            .map(|set| set.dispatch(Lanes))
            .collect();
        assert!(lanes.is_sorted_by(|a, b| a > b), "{lanes:?}");
        assert_eq!(lanes.last(), Some(&1));
        assert_eq!(InstructionSet::detect().dispatch(Lanes), lanes[0]);
        for set in InstructionSet::ALL.iter().filter(|set| !set.is_available()) {
            assert_eq!(set.dispatch(Lanes), 1);
        }
    }
}
