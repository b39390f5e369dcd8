//! Prints the hashes of the golden cases, a line each, as the firmware image does: bits in any build
//! profile, without building the references.

use std::process::ExitCode;

use bonebeam_tests::{Workspaces, run};

fn main() -> ExitCode {
    let mut workspaces = Box::new(Workspaces::new());
    let outcome = run(&mut workspaces, &mut |name, hash| {
        println!("{name} {hash:016x}");
    });
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
