//! Prints the hashes of the golden cases, a line each, as the firmware image does.
//!
//! Checks the bits of any build profile on any processor, without the references. Vectors must give the bits of one
//! lane, for some plans of every kernel.

use std::process::ExitCode;

use bonebeam::simd::InstructionSet;
use bonebeam_tests::draw::Seed;
use bonebeam_tests::kernel::{Kernel, judge};
use bonebeam_tests::{Workspaces, for_each_kernel, run};

/// Plans of each kernel.
const PLANS: u64 = 20;

fn check<K: Kernel>() {
    for seed in 0..PLANS {
        if let Ok(kernel) = K::draw(&mut Seed(seed << 32)) {
            // An error is the same for all instruction sets.
            let _ = judge(&kernel, InstructionSet::available());
        }
    }
}

macro_rules! checks {
    ($($kernel:ty),*;) => {
        [$(check::<$kernel>),*]
    };
}

fn main() -> ExitCode {
    let print = &mut |name: &str, hash: u64| println!("{name} {hash:016x}");
    if let Err(error) = run(&mut Box::new(Workspaces::new()), print) {
        eprintln!("error: {error}");
        return ExitCode::FAILURE;
    }
    for check in for_each_kernel!(checks) {
        check();
    }
    let sets: Vec<_> = InstructionSet::available()
        .map(InstructionSet::name)
        .collect();
    eprintln!("{}: the bits of one lane", sets.join(", "));
    ExitCode::SUCCESS
}
