//! Signals that end the program remove its temporary files first.
//!
//! A signal handler may do almost nothing, so a thread waits for signals instead. This thread and any code that
//! makes or renames a temporary file share one lock, so no file is missed, and outputs whose renaming has begun are
//! all renamed.

use std::fs;
use std::io::{self, Write};
use std::os::fd::{IntoRawFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::sync::{Arc, mpsc};
use std::thread;

use signal_hook::consts::{SIGABRT, SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGXCPU, SIGXFSZ};
use signal_hook::iterator::Signals;
use signal_hook::{flag, low_level::pipe};

use crate::temporary_files::{lock, lock_soon, remove_all};
use crate::{Error, Result};

/// Stack of the waiting thread, bytes.
const STACK: usize = 1 << 18;

/// Begins to handle signals.
///
/// From here on SIGHUP, SIGINT, SIGQUIT, SIGTERM and SIGXCPU end the program and remove its temporary files; the
/// status is 128 plus their number. A SIGHUP that the parent process ignores, as `nohup` does, is ignored. A failed
/// allocation (SIGABRT) ends it in the same way with status 1. A file that grows beyond a limit (SIGXFSZ) is an
/// error of the write.
///
/// # Errors
/// [`Error::Data`] if the system provides no handler or no thread.
pub fn handle() -> Result<()> {
    begin().map_err(|e| Error::Data(format!("cannot wait for signals: {e}")))
}

fn begin() -> io::Result<()> {
    let hangup = (!hangup_is_ignored()).then_some(SIGHUP);
    let always = [SIGABRT, SIGINT, SIGQUIT, SIGTERM, SIGXCPU];
    let mut signals = Signals::new(always.into_iter().chain(hangup))?;
    wait_at_abort()?;
    // A handler that does nothing: the write returns an error.
    flag::register(SIGXFSZ, Arc::default())?;
    let (begun, begin) = mpsc::channel();
    let thread = thread::Builder::new().stack_size(STACK);
    thread.spawn(move || {
        // Its memory is taken before other memory is asked for.
        let _ = begun.send(());
        let Some(signal) = signals.forever().next() else {
            return;
        };
        // In its turn, so that nothing new is made while the program ends. The thread that aborts may have it.
        let _turn = match signal {
            SIGABRT => lock_soon(),
            _ => Some(lock()),
        };
        remove_all();
        let status = if signal == SIGABRT { 1 } else { 128 + signal };
        std::process::exit(status);
    })?;
    let _ = begin.recv();
    Ok(())
}

/// Makes an aborting thread wait.
///
/// It would end the program at once. Instead it writes to a full pipe, until the thread that waits for signals has
/// ended the program.
fn wait_at_abort() -> io::Result<()> {
    let (reader, mut writer) = io::pipe()?;
    // Makes the pipe one that does not block.
    pipe::register(SIGABRT, writer.try_clone()?)?;
    while writer.write(&[0; 4096]).is_ok() {}
    // A pipe has no such method of its own.
    UnixStream::from(OwnedFd::from(writer)).set_nonblocking(false)?;
    // Open until the end.
    let _ = reader.into_raw_fd();
    Ok(())
}

/// Whether SIGHUP is ignored, if the system can tell.
fn hangup_is_ignored() -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let bits = ignored.and_then(|bits| u64::from_str_radix(bits.trim(), 16).ok());
    bits.is_some_and(|bits| bits >> (SIGHUP - 1) & 1 == 1)
}
