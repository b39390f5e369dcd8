//! Blocking use of the drivers.
//!
//! The drivers exist once, over `embedded-hal-async`. [`Blocking`] adapts a device of `embedded-hal` to
//! `embedded-hal-async` without waiting. [`block`] runs a call to completion.

use core::future::Future;
use core::pin::pin;
use core::task::{Context, Poll, Waker};

use embedded_hal::spi::{ErrorType, Operation};

/// An SPI device or a delay of `embedded-hal`, as one of `embedded-hal-async`.
///
/// A call returns when the device is done, and never suspends.
#[derive(Clone, Debug)]
pub struct Blocking<T>(pub T);

impl<T: ErrorType> ErrorType for Blocking<T> {
    type Error = T::Error;
}

impl<W: Copy + 'static, T: embedded_hal::spi::SpiDevice<W>> embedded_hal_async::spi::SpiDevice<W>
    for Blocking<T>
{
    async fn transaction(
        &mut self,
        operations: &mut [Operation<'_, W>],
    ) -> Result<(), Self::Error> {
        self.0.transaction(operations)
    }
}

impl<T: embedded_hal::delay::DelayNs> embedded_hal_async::delay::DelayNs for Blocking<T> {
    async fn delay_ns(&mut self, ns: u32) {
        self.0.delay_ns(ns);
    }
}

/// Runs `future` to completion and returns its output.
///
/// Over [`Blocking`] devices the first poll is the last. A future that waits for something else is polled
/// repeatedly, without sleep.
pub fn block<F: Future>(future: F) -> F::Output {
    let mut future = pin!(future);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        if let Poll::Ready(output) = future.as_mut().poll(&mut context) {
            return output;
        }
        core::hint::spin_loop();
    }
}
