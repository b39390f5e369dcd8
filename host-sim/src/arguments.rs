//! The program's arguments.

use std::env;
use std::ffi::OsString;
use std::sync::OnceLock;

/// Those of a program within another process.
static OWN: OnceLock<Vec<OsString>> = OnceLock::new();

/// Sets the name and the arguments in place of the process's, once.
pub(crate) fn set(own: Vec<OsString>) {
    OWN.get_or_init(|| own);
}

/// The program's name and its arguments.
pub(crate) fn all() -> Vec<OsString> {
    let own = OWN.get().cloned();
    own.unwrap_or_else(|| env::args_os().collect())
}
