//! A kernel stated once, and the judge of its bits.

use std::string::String;
use std::vec::Vec;
use std::{format, vec};

use bonebeam::memory::{Need, Scratch};
use bonebeam::simd::{InstructionSet, Task, Vector};
use bonebeam::{Complex, Error};

/// Something that the core computes, with its parameters and data.
pub trait Kernel {
    /// A number of the result.
    type Number: Number;

    /// Memory of numbers, and memory of vectors.
    ///
    /// `way` is one of [`Kernel::ways`].
    fn need(&self, lanes: usize, way: usize) -> [Need; 2];

    /// Numbers of the result.
    fn len(&self) -> usize;

    /// Computes the result in memory of exactly [`Kernel::need`].
    ///
    /// # Errors
    /// Those of the core.
    fn run<V: Vector>(
        &self,
        zero: V,
        way: usize,
        memory: (Scratch<'_>, Scratch<'_, V>),
        out: &mut [Self::Number],
    ) -> Result<(), Error>;

    /// Other ways to the same bits, as blocks of a length.
    ///
    /// The way 0 always exists.
    fn ways(&self) -> Vec<usize> {
        Vec::new()
    }
}

/// A number of a result.
pub trait Number: Copy {
    /// What a result must overwrite.
    const DIRT: Self;

    /// Its bits; `None` if it is not finite.
    fn bits(self) -> Option<[u32; 2]>;
}

impl Number for f32 {
    const DIRT: Self = f32::NAN;

    fn bits(self) -> Option<[u32; 2]> {
        self.is_finite().then_some([self.to_bits(), 0])
    }
}

impl Number for Complex<f32> {
    const DIRT: Self = Complex::new(f32::NAN, f32::NAN);

    fn bits(self) -> Option<[u32; 2]> {
        self.is_finite()
            .then_some([self.re.to_bits(), self.im.to_bits()])
    }
}

/// The bits of finite numbers.
pub fn bits<N: Number>(numbers: &[N]) -> Vec<[u32; 2]> {
    let bits = numbers.iter().map(|number| number.bits());
    bits.collect::<Option<_>>().expect("finite numbers")
}

/// The kernel's result, the same bits in every way that it can be computed.
///
/// One lane and the lanes of `sets`, whole and in parts, in memory of exactly its need that is full of NaN and then of
/// another run. One number less is refused.
///
/// # Errors
/// Those of the core, which are the same for all instruction sets.
pub fn judge<K: Kernel>(
    kernel: &K,
    sets: impl IntoIterator<Item = InstructionSet>,
) -> Result<Vec<K::Number>, Error> {
    let of = |set: InstructionSet, way, short| set.dispatch(Run { kernel, way, short });
    let text = |error: &Error| format!("{error:?}");
    let one = of(InstructionSet::Scalar, 0, None);
    let one = one.map(|number| (bits(&number), number));
    for set in [InstructionSet::Scalar].into_iter().chain(sets) {
        for way in [0].into_iter().chain(kernel.ways()) {
            let found = of(set, way, None);
            let what = || format!("{} by the way {way}", set.name());
            match (&one, &found) {
                (Ok((expected, _)), Ok(found)) => {
                    let found = bits(found);
                    let at = found.iter().zip(expected).position(|(a, b)| a != b);
                    assert!(at.is_none(), "{}: other bits at {at:?}", what());
                }
                // An error may hold a NaN, which differs from itself.
                (Err(expected), Err(found)) => {
                    assert_eq!(text(expected), text(found), "{}", what())
                }
                (one, found) => panic!(
                    "{}: {:?}, {:?}",
                    what(),
                    one.as_ref().err(),
                    found.as_ref().err()
                ),
            }
            for short in 0..4 {
                let refused = one.is_err() || set.dispatch(IsRefused { kernel, way, short });
                assert!(refused, "{}: memory {short} may be shorter", what());
            }
        }
    }
    one.map(|(_, numbers)| numbers)
}

/// A run in memory of exactly the need, or with one number less in one of its four slices.
struct Run<'a, K> {
    kernel: &'a K,
    way: usize,
    short: Option<usize>,
}

impl<K: Kernel> Task for Run<'_, K> {
    type Output = Result<Vec<K::Number>, Error>;

    fn run<V: Vector>(self, zero: V) -> Self::Output {
        let Run { kernel, way, short } = self;
        let mut needs = kernel.need(V::LANES, way);
        let [
            Need { real, complex },
            Need {
                real: vectors,
                complex: pairs,
            },
        ] = &mut needs;
        if let Some(short) = short {
            *[real, complex, vectors, pairs][short] -= 1;
        }
        let [numbers, vectors] = needs;
        let nan = zero.splat(f32::NAN);
        let (mut real, mut complex) = (
            vec![f32::NAN; numbers.real],
            vec![Complex::DIRT; numbers.complex],
        );
        let (mut reals, mut pairs) = (
            vec![nan; vectors.real],
            vec![Complex::new(nan, nan); vectors.complex],
        );
        let mut out = vec![K::Number::DIRT; kernel.len()];
        let mut once = |out: &mut [K::Number]| {
            let numbers = Scratch {
                real: &mut real,
                complex: &mut complex,
            };
            let vectors = Scratch {
                real: &mut reals,
                complex: &mut pairs,
            };
            kernel.run(zero, way, (numbers, vectors), out)
        };
        once(&mut out)?;
        let first = bits(&out);
        out.fill(K::Number::DIRT);
        once(&mut out)?;
        assert!(first == bits(&out), "used memory changes bits");
        Ok(out)
    }
}

/// Whether one number less is refused, where there is one.
struct IsRefused<'a, K> {
    kernel: &'a K,
    way: usize,
    short: usize,
}

impl<K: Kernel> Task for IsRefused<'_, K> {
    type Output = bool;

    fn run<V: Vector>(self, zero: V) -> bool {
        let IsRefused { kernel, way, short } = self;
        let [numbers, vectors] = kernel.need(V::LANES, way);
        let length = [numbers.real, numbers.complex, vectors.real, vectors.complex][short];
        let run = Run {
            kernel,
            way,
            short: Some(short),
        };
        length == 0
            || matches!(
                run.run(zero),
                Err(Error::Length { .. } | Error::Capacity { .. })
            )
    }
}

/// The judge's verdict on many plans: how many were computed, and how many refused.
///
/// `check` compares a result with a reference.
pub fn judge_seeds<K: Kernel>(
    seeds: core::ops::Range<u64>,
    draw: impl Fn(&mut crate::draw::Seed) -> Result<K, Error>,
    check: impl Fn(&K, &[K::Number], &str),
) -> [usize; 2] {
    let mut count = [0; 2];
    for seed in seeds {
        let result = draw(&mut crate::draw::Seed(seed << 32));
        let result =
            result.and_then(|kernel| Ok((judge(&kernel, InstructionSet::available())?, kernel)));
        count[usize::from(result.is_err())] += 1;
        if let Ok((numbers, kernel)) = &result {
            let what: String = format!("seed {seed}");
            check(kernel, numbers, &what);
        }
    }
    count
}
