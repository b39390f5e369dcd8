//! The program `bonebeam-paper`: `host-sim paper` and `host-sim tune`.

use std::process::ExitCode;

fn main() -> ExitCode {
    bonebeam_paper::run()
}
