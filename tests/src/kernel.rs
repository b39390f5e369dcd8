//! A kernel stated once, and the judge of its bits.

use core::fmt::Debug;
use core::marker::PhantomData;
use std::vec::Vec;
use std::{eprintln, format, vec};

use bonebeam::dispatch;
use bonebeam::prelude::stages::*;

use crate::draw::{Draw, Seed};

/// Something that the core computes, with its parameters and data.
pub trait Kernel: Sized + Debug {
    /// A number of the result.
    type Number: Number;

    /// Whether a number less than the need is refused.
    const EXACT: bool = true;

    /// A plan from any numbers.
    ///
    /// # Errors
    /// The core's, for parameters and data that it refuses.
    fn draw(draw: &mut impl Draw) -> Result<Self, Error>;

    /// Memory of numbers, and memory of vectors.
    ///
    /// `way` is one of [`Kernel::ways`].
    fn need(&self, lanes: usize, way: usize) -> [Need; 2];

    /// Numbers of the result.
    fn numbers(&self) -> usize;

    /// Computes the result in memory of exactly [`Kernel::need`].
    fn run<V: Vector>(
        &self,
        zero: V,
        way: usize,
        memory: (Scratch<'_>, Scratch<'_, V>),
        out: &mut [Self::Number],
    ) -> Result<(), Error>;

    /// Whether a refusal leaves the result as it was, which several calls need not do.
    fn is_one_call(&self, _way: usize) -> bool {
        false
    }

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
/// another run. One number less is refused, and what is refused in one call writes nothing.
///
/// # Errors
/// Those of the core, which are the same for all instruction sets.
pub fn judge<K: Kernel>(
    kernel: &K,
    sets: impl IntoIterator<Item = InstructionSet>,
) -> Result<Vec<K::Number>, Error> {
    let of =
        |set: InstructionSet, way, short| dispatch!(set, zero => run(zero, kernel, way, short));
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
                let found = of(set, way, Some(short));
                let refused = !K::EXACT
                    || one.is_err()
                    || matches!(found, Err(Error::Length { .. } | Error::Capacity { .. }));
                assert!(refused, "{}: memory {short} may be shorter", what());
            }
        }
    }
    one.map(|(_, numbers)| numbers)
}

/// The kernel's result over one lane.
pub fn over_one_lane<K: Kernel>(kernel: &K) -> Result<Vec<K::Number>, Error> {
    run(0.0f32, kernel, 0, None)
}

/// Two runs in memory of exactly the need, or with one number less in one of its four slices.
fn run<K: Kernel, V: Vector>(
    zero: V,
    kernel: &K,
    way: usize,
    short: Option<usize>,
) -> Result<Vec<K::Number>, Error> {
    let [numbers, vectors] = kernel.need(V::LANES, way);
    let mut lengths = [numbers.real, numbers.complex, vectors.real, vectors.complex];
    if let Some(length) = short.map(|short| &mut lengths[short]) {
        // Nothing is less than nothing.
        let (name, actual, expected) = ("memory", 0, 0);
        let none = Error::Length {
            name,
            actual,
            expected,
        };
        *length = length.checked_sub(1).ok_or(none)?;
    }
    let nan = zero.splat(f32::NAN);
    let (mut real, mut complex) = (vec![f32::NAN; lengths[0]], vec![Complex::DIRT; lengths[1]]);
    let mut reals = vec![nan; lengths[2]];
    let mut pairs = vec![Complex::new(nan, nan); lengths[3]];
    let mut out = vec![K::Number::DIRT; kernel.numbers()];
    let mut once = |out: &mut [K::Number]| {
        let numbers = Scratch::new(&mut real, &mut complex);
        let vectors = Scratch::new(&mut reals, &mut pairs);
        kernel.run(zero, way, (numbers, vectors), out)
    };
    if let Err(error) = once(&mut out) {
        let written = out.iter().any(|number| number.bits().is_some());
        assert!(
            !kernel.is_one_call(way) || !written,
            "written, then {error}"
        );
        return Err(error);
    }
    let first = bits(&out);
    out.fill(K::Number::DIRT);
    once(&mut out)?;
    assert!(first == bits(&out), "used memory changes bits");
    Ok(out)
}

/// Judges the plans of some seeds.
///
/// `check` compares a result with a reference. Most plans must be computed, and give more than zeros.
pub fn judge_seeds<K: Kernel>(seeds: u64, check: impl Fn(&K, &[K::Number])) {
    let sets = || InstructionSet::available().filter(|set| *set != InstructionSet::Scalar);
    let [mut computed, mut silent] = [0; 2];
    for seed in 0..seeds {
        let _guard = Named::<K>(seed, PhantomData);
        let Ok(kernel) = K::draw(&mut Seed(seed << 32)) else {
            continue;
        };
        if let Ok(numbers) = judge(&kernel, sets()) {
            check(&kernel, &numbers);
            computed += 1;
            silent += u64::from(bits(&numbers).iter().all(|bits| *bits == [0; 2]));
        }
    }
    std::println!("{computed} of {seeds} computed, {silent} silent");
    assert!(computed > seeds / 2 && silent < computed * 2 / 3);
}

/// Shows the plan that fails.
struct Named<K: Kernel>(u64, PhantomData<K>);

impl<K: Kernel> Drop for Named<K> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            let plan = format!("{:?}", K::draw(&mut Seed(self.0 << 32)));
            eprintln!("seed {}: {plan:.3000}", self.0);
        }
    }
}
