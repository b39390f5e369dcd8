//! Prints the hashes of the golden cases, a line each, as the firmware image does.
//!
//! Checks the bits of any build profile on any processor, without the references. With vectors the processor must
//! give the same hashes.

use std::collections::HashMap;
use std::process::ExitCode;

use bonebeam::Error;
use bonebeam::simd::InstructionSet;
use bonebeam_tests::{Workspaces, lanes, run};

fn main() -> ExitCode {
    match golden() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Whether all instruction sets agree.
fn golden() -> Result<bool, Error> {
    let mut hashes = HashMap::new();
    let mut workspaces = Box::new(Workspaces::new());
    run(&mut workspaces, &mut |name, hash| {
        println!("{name} {hash:016x}");
        hashes.insert(name.to_owned(), hash);
    })?;
    let mut agree = true;
    for set in InstructionSet::available() {
        let mut cases = 0;
        lanes::run(set, &mut |name, hash| {
            cases += 1;
            if hashes.get(name) != Some(&hash) {
                eprintln!("{name} with {}: {hash:016x}", set.name());
                agree = false;
            }
        })?;
        eprintln!("{}: {cases} hashes compared", set.name());
    }
    Ok(agree)
}
