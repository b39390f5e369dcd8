//! The scanner's interrupt: an acquisition at every turn of the timer.

use core::cell::RefCell;

use cortex_m_rt::exception;
use critical_section::Mutex;
use firmware::Scanner;
use stream::Source;
use stream::scan::ScanBlock;

use crate::clock;

static SCANNER: Mutex<RefCell<Option<Scanner>>> = Mutex::new(RefCell::new(None));

/// The scanner runs from the next interrupt on.
pub fn start(source: Source<ScanBlock>) {
    let scanner = Scanner::new(source);
    critical_section::with(|cs| SCANNER.borrow(cs).replace(Some(scanner)));
}

/// The scanner stops.
pub fn stop() {
    critical_section::with(|cs| SCANNER.borrow(cs).replace(None));
}

#[exception]
fn SysTick() {
    clock::interrupt(|| {
        critical_section::with(|cs| {
            if let Some(scanner) = SCANNER.borrow(cs).borrow_mut().as_mut() {
                scanner.acquire(clock::turns());
            }
        });
    });
}
