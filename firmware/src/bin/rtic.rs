//! The scanner's processor under RTIC: a hardware task acquires, `idle` makes bone maps.
//!
//! Prints a hash of the bone map of frames 0 and 2. Frame 1 loses a block.

#![no_std]
#![no_main]
// Of RTIC's macros.
#![allow(unsafe_code)]

use cortex_m_rt as _;

/// RTIC's requirement of a device: the bits of a priority.
///
/// Exceptions need no interrupts.
mod device {
    pub const NVIC_PRIO_BITS: u8 = 3;
}

#[rtic::app(device = crate::device, peripherals = false)]
mod app {
    use cortex_m::peripheral::syst::SystClkSource;
    use cortex_m_semihosting::debug::{EXIT_FAILURE, EXIT_SUCCESS};
    use cortex_m_semihosting::hprintln;
    use firmware::{Maps, Scanner, exit, process};
    use static_cell::{ConstStaticCell, StaticCell};
    use stream::scan::{BEAMS, Reference, ScanBlock, ScanMemory};
    use stream::{Chain, Plan, Pool, Probe, Sequence, Sink};

    const BLOCKS: usize = 12;
    /// Ticks from one transmit to the next, of 40 instructions each.
    const PERIOD: u32 = 80_000;
    /// The largest age of a block, transmits.
    const DEADLINE: u32 = 12;

    static POOL: ConstStaticCell<Pool<ScanBlock, BLOCKS, { BLOCKS + 1 }>> =
        ConstStaticCell::new(Pool::new([const { ScanBlock::filled([0; 2]) }; BLOCKS]));
    static MEMORY: ConstStaticCell<ScanMemory> = ConstStaticCell::new(ScanMemory::new());
    static PLAN: StaticCell<Plan<Reference>> = StaticCell::new();

    #[shared]
    struct Shared {
        /// Transmits since the start: the clock.
        time: u32,
    }

    #[local]
    struct Local {
        scanner: Scanner,
        sink: Sink<ScanBlock>,
        chain: Chain<'static, Reference, BEAMS>,
    }

    #[init]
    fn init(mut context: init::Context) -> (Shared, Local) {
        let Ok(plan) = Reference::plan() else {
            exit(EXIT_FAILURE)
        };
        let Ok(chain) = Chain::new(PLAN.init(plan), MEMORY.take().scratch()) else {
            exit(EXIT_FAILURE)
        };
        let (source, sink) = POOL.take().split();
        let timer = &mut context.core.SYST;
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(PERIOD - 1);
        timer.clear_current();
        timer.enable_interrupt();
        timer.enable_counter();
        let local = Local {
            scanner: Scanner::new(source),
            sink,
            chain,
        };
        (Shared { time: 0 }, local)
    }

    #[task(binds = SysTick, priority = 1, local = [scanner], shared = [time])]
    fn acquire(mut context: acquire::Context) {
        let time = context.shared.time.lock(|time| {
            *time = time.wrapping_add(1);
            *time
        });
        context.local.scanner.acquire(time);
    }

    #[idle(local = [sink, chain], shared = [time])]
    fn idle(mut context: idle::Context) -> ! {
        let idle::LocalResources { sink, chain, .. } = context.local;
        let mut sequence = Sequence::new(BEAMS as u16);
        loop {
            let now = context.shared.time.lock(|time| *time);
            let Some(block) = sink.receive_within(DEADLINE, || now) else {
                cortex_m::asm::wfi();
                continue;
            };
            let Ok(maps) = process(chain, &mut sequence, block) else {
                exit(EXIT_FAILURE)
            };
            if let Some(Maps {
                frame,
                missing,
                hash,
            }) = maps
            {
                hprintln!(
                    "frame {}: {} missing, bone map {:016x}",
                    frame,
                    missing,
                    hash
                );
                if frame == 2 {
                    exit(EXIT_SUCCESS);
                }
            }
        }
    }
}
