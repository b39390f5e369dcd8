//! Start-up of each processor, by the start-up crate of its architecture.
//!
//! It sets up the stack, the memory and the floating-point unit.

#[cfg(target_arch = "arm")]
#[cortex_m_rt::entry]
fn main() -> ! {
    // Links the crate for its critical sections, which guard the golden cases' memory.
    let _ = cortex_m::peripheral::SCB::vect_active();
    crate::run()
}

#[cfg(target_arch = "riscv32")]
#[riscv_rt::entry]
fn main() -> ! {
    crate::run()
}

#[cfg(target_arch = "aarch64")]
mod aarch64 {
    use aarch64_rt::{
        ExceptionHandlers, InitialPagetable, entry, exception_handlers, initial_pagetable,
    };

    /// One to one, a GiB a block: devices below, memory above. (Valid, accessed, never executed by a
    /// user; inner shareable and cached.)
    const DEVICES: usize = 1 | 1 << 10 | 1 << 54;
    const MEMORY: usize = 1 | 1 << 2 | 3 << 8 | 1 << 10;
    /// The memory kinds of indices 0 and 1 in the blocks: device, and cached.
    const KINDS: u64 = 0xff04;

    initial_pagetable!(
        {
            let mut blocks = [0; 512];
            blocks[0] = DEVICES;
            blocks[1] = MEMORY | 0x4000_0000;
            InitialPagetable(blocks)
        },
        KINDS
    );

    struct Exceptions;

    impl ExceptionHandlers for Exceptions {}

    exception_handlers!(Exceptions);

    entry!(main);
    fn main(_: u64, _: u64, _: u64, _: u64) -> ! {
        crate::run()
    }
}
