//! The live page's WebAssembly: recordings and pictures → images, bone maps and surfaces.
//!
//! A caller writes the argument of a function into [`input`], calls the function with up to three numbers, and reads a
//! text, JSON or an error for people, and numbers as bytes from [`output`]. Settings are sections of the configuration,
//! so a result has the bits that the command gives with the same TOML.

mod describe;
mod state;

use std::cell::RefCell;
use std::panic;

use state::{Answer, State};

/// What a caller writes and reads.
struct Exchange {
    input: Vec<u8>,
    text: Vec<u8>,
    bytes: Vec<u8>,
}

thread_local! {
    static STATE: RefCell<State> = RefCell::default();
    static EXCHANGE: RefCell<Exchange> = const {
        RefCell::new(Exchange { input: Vec::new(), text: Vec::new(), bytes: Vec::new() })
    };
}

/// Memory for the next argument, of `length` bytes.
#[allow(unsafe_code)]
#[unsafe(no_mangle)]
pub extern "C" fn input(length: usize) -> *mut u8 {
    EXCHANGE.with_borrow_mut(|exchange| {
        exchange.input = vec![0; length];
        exchange.input.as_mut_ptr()
    })
}

/// The last answer: its text (0) or its bytes (1).
#[allow(unsafe_code)]
#[unsafe(no_mangle)]
pub extern "C" fn output(part: u32) -> *const u8 {
    EXCHANGE.with_borrow(|exchange| match part {
        0 => exchange.text.as_ptr(),
        _ => exchange.bytes.as_ptr(),
    })
}

/// The number of bytes of a part of [`output`].
#[allow(unsafe_code)]
#[unsafe(no_mangle)]
pub extern "C" fn output_length(part: u32) -> usize {
    EXCHANGE.with_borrow(|exchange| match part {
        0 => exchange.text.len(),
        _ => exchange.bytes.len(),
    })
}

/// Runs `work` on the state and the argument; returns 0, or 1 for an error.
fn answer(work: impl FnOnce(&mut State, Vec<u8>) -> bonebeam_drive::Result<Answer>) -> u32 {
    // A panic ends the module; its message stays.
    panic::set_hook(Box::new(|info| {
        EXCHANGE.with_borrow_mut(|exchange| exchange.text = info.to_string().into_bytes());
    }));
    let input = EXCHANGE.with_borrow_mut(|exchange| std::mem::take(&mut exchange.input));
    let answer = STATE.with_borrow_mut(|state| work(state, input));
    EXCHANGE.with_borrow_mut(|exchange| match answer {
        Ok((text, bytes)) => {
            (exchange.text, exchange.bytes) = (text.to_string().into_bytes(), bytes);
            0
        }
        Err(error) => {
            (exchange.text, exchange.bytes) = (error.to_string().into_bytes(), Vec::new());
            1
        }
    })
}

/// Exports functions of [`State`] with up to three numbers.
macro_rules! exports {
    ($($(#[doc = $doc:literal])* $name:ident($($number:ident),*);)*) => {$(
        $(#[doc = $doc])*
        #[allow(unsafe_code)]
        #[unsafe(no_mangle)]
        pub extern "C" fn $name($($number: usize),*) -> u32 {
            answer(|state, input| state.$name(input, $($number),*))
        }
    )*};
}

exports! {
    /// The keys of the configuration, and the default settings.
    describe();
    /// Opens an `.npz` archive: a recording, or lines.
    open();
    /// Opens a PNG picture.
    picture();
    /// Takes settings, flags' texts by key; `coarse` is 1 for a faster picture of them.
    settle(coarse);
    /// Takes settings from TOML; answers them.
    read_toml();
    /// The lines of the recording with the settings.
    shape();
    /// Beamforms part `k` of `n` of a frame.
    part(frame, k, n);
    /// The image of all lines, which are the argument.
    image();
    /// The bone map of the image.
    bone_map();
    /// The bone surface.
    surface(frame);
    /// Measures of a profile, or of two regions.
    measure();
}
