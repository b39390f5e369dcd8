//! Every kernel of the core: refused, or finite and the same bits in every way that the catalogue knows.
//!
//! The first byte chooses the kernel, the second the instruction set.

#![no_main]

use bonebeam::simd::InstructionSet;
use bonebeam_tests::draw::{Bytes, Draw};
use bonebeam_tests::for_each_kernel;
use bonebeam_tests::kernel::{Kernel, judge};
use libfuzzer_sys::fuzz_target;

type Check = fn(&mut Bytes<'_>, Option<InstructionSet>);

fn check<K: Kernel>(draw: &mut Bytes<'_>, set: Option<InstructionSet>) {
    if let Ok(kernel) = K::draw(draw) {
        // An error is the same for all instruction sets.
        let _ = judge(&kernel, set);
    }
}

macro_rules! checks {
    ($($kernel:ty),*;) => {
        [$(check::<$kernel>),*]
    };
}

fuzz_target!(|bytes: &[u8]| {
    let mut draw = Bytes(bytes);
    let checks: &[Check] = &for_each_kernel!(checks);
    let check = draw.one_of(checks);
    let count = InstructionSet::available().count();
    let set = InstructionSet::available().nth(draw.below(count));
    check(&mut draw, set);
});
