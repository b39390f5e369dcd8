//! Selection of an instruction set at run time.

use core::fmt;
use core::str::FromStr;

/// The instruction sets with vectors, the fastest first.
///
/// A row has the targets, the documentation, the type of `fearless_simd`, the key, the name, and the proof that the
/// processor has the set.
macro_rules! sets {
    ($($target:meta, $about:literal $set:ident $key:literal $name:literal $proof:ident;)*) => {
        /// An instruction set that kernels are compiled for; it changes no bit.
        ///
        /// With the feature `std`, the processor is asked at run time. Without it, an instruction set counts as
        /// available if the compiler's target promises it.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        #[non_exhaustive]
        pub enum InstructionSet {
            $(
                #[doc = $about]
                #[cfg($target)]
                $set,
            )*
            /// No vectors; one lane, as on a microcontroller.
            Scalar,
        }

        impl InstructionSet {
            /// All instruction sets of this processor architecture, the fastest first.
            pub const ALL: &[Self] = &[
                $(#[cfg($target)] InstructionSet::$set,)*
                InstructionSet::Scalar,
            ];

            /// Proof that the processor has the instruction set; [`Token::Scalar`] if it has not.
            #[doc(hidden)]
            #[inline]
            pub fn token(self) -> Token {
                // `--cfg bonebeam_one_set` leaves out the kernels of all but the first, for a smaller program.
                let set = if cfg!(bonebeam_one_set) { Self::ALL[0] } else { self };
                let token = match set {
                    $(
                        #[cfg($target)]
                        InstructionSet::$set => level().$proof().map(Token::$set),
                    )*
                    InstructionSet::Scalar => None,
                };
                token.unwrap_or(Token::Scalar)
            }

            /// Name for people.
            pub const fn name(self) -> &'static str {
                match self {
                    $(#[cfg($target)] InstructionSet::$set => $name,)*
                    InstructionSet::Scalar => "one lane",
                }
            }

            /// Name for command lines and configurations; [`str::parse`] accepts it.
            pub const fn key(self) -> &'static str {
                match self {
                    $(#[cfg($target)] InstructionSet::$set => $key,)*
                    InstructionSet::Scalar => "scalar",
                }
            }
        }

        /// What an [`InstructionSet`] is chosen by in [`dispatch!`](crate::dispatch).
        #[doc(hidden)]
        pub enum Token {
            $(#[cfg($target)] $set(fearless_simd::$set),)*
            Scalar,
        }
    };
}

sets! {
    target_arch = "x86_64", "AVX-512; 16 lanes." Avx512 "avx512" "AVX-512" as_avx512;
    target_arch = "x86_64", "AVX2; 8 lanes." Avx2 "avx2" "AVX2" as_avx2;
    target_arch = "x86_64", "x86-64's baseline; 4 lanes." Sse2 "sse2" "SSE2" as_sse2;
    target_arch = "aarch64", "AArch64's baseline; 4 lanes." Neon "neon" "NEON" as_neon;
    all(target_arch = "wasm32", target_feature = "simd128"), "WebAssembly's vectors; 4 lanes."
        WasmSimd128 "simd128" "SIMD128" as_wasm_simd128;
}

impl InstructionSet {
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
        self == InstructionSet::Scalar || !matches!(self.token(), Token::Scalar)
    }
}

/// Evaluates an expression with a zero vector of an instruction set.
///
/// The expression is compiled for each instruction set of the processor architecture. On a processor without the
/// chosen one, it has one lane.
///
/// ```
/// use bonebeam::dispatch;
/// use bonebeam::image::median;
/// use bonebeam::simd::InstructionSet;
///
/// let mut image = [1.0; 64];
/// image[27] = 255.0;
/// let mut out = [0.0; 64];
/// dispatch!(InstructionSet::detect(), zero => median(zero, &image, 8, &mut out))?;
/// assert_eq!(out, [1.0; 64]);
/// # Ok::<(), bonebeam::Error>(())
/// ```
#[macro_export]
macro_rules! dispatch {
    (@of $zero:ident = $value:expr => $work:expr) => {{
        let $zero = $value;
        $work
    }};
    ($set:expr, $zero:ident => $work:expr) => {
        match $crate::simd::InstructionSet::token($set) {
            #[cfg(target_arch = "x86_64")]
            $crate::simd::Token::Avx512(simd) => $crate::dispatch!(@of $zero = $crate::simd::Lanes::new(simd) => $work),
            #[cfg(target_arch = "x86_64")]
            $crate::simd::Token::Avx2(simd) => $crate::dispatch!(@of $zero = $crate::simd::Lanes::new(simd) => $work),
            #[cfg(target_arch = "x86_64")]
            $crate::simd::Token::Sse2(simd) => $crate::dispatch!(@of $zero = $crate::simd::Lanes::new(simd) => $work),
            #[cfg(target_arch = "aarch64")]
            $crate::simd::Token::Neon(simd) => $crate::dispatch!(@of $zero = $crate::simd::Lanes::new(simd) => $work),
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            $crate::simd::Token::WasmSimd128(simd) => $crate::dispatch!(@of $zero = $crate::simd::Lanes::new(simd) => $work),
            $crate::simd::Token::Scalar => $crate::dispatch!(@of $zero = 0.0f32 => $work),
        }
    };
}

/// The processor's level, or, if it cannot be asked, the target's.
#[cfg(any(
    target_arch = "x86_64",
    target_arch = "aarch64",
    all(target_arch = "wasm32", target_feature = "simd128")
))]
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
    use crate::simd::Vector;
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

    fn lanes(set: InstructionSet) -> usize {
        crate::dispatch!(set, zero => zero.lanes().len())
    }

    #[test]
    fn what_is_there_is_dispatched_to_and_the_widest_comes_first() {
        let all: Vec<usize> = InstructionSet::available().map(lanes).collect();
        assert!(all.is_sorted_by(|a, b| a > b), "{all:?}");
        assert_eq!(all.last(), Some(&1));
        assert_eq!(lanes(InstructionSet::detect()), all[0]);
        for set in InstructionSet::ALL.iter().filter(|set| !set.is_available()) {
            assert_eq!(lanes(*set), 1);
        }
    }
}
