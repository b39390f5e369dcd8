//! TI's TX7332, a pulser of 32 channels.
//!
//! A frame has 42 bits: 10 of the register, 32 of its value, highest bit first. Registers come from a public driver
//! of the part; the data sheet was not available. Not verified: the fields of the transmit/receive switch in
//! [`DELAY_SELECT`], and their unit.

use embedded_hal::spi::Operation;
use embedded_hal_async::spi::SpiDevice;

use crate::{Checked, Error, Pulser, Waveform};

/// Register 0: reading and loading.
pub const CONTROL: u16 = 0x000;
/// Bits of [`CONTROL`] that enable reads of either half's registers.
pub const READ: [u32; 2] = [1 << 1, 1 << 2];
/// Bit 3 of [`CONTROL`]: the next trigger uses the selected profiles.
///
/// It clears itself.
pub const LOAD_PROFILE: u32 = 1 << 3;
/// Delay profile and delay of the transmit/receive switch, for each half.
///
/// Profile in bits 12 to 15 and 28 to 31, switch in bits 0 to 11 and 16 to 27.
pub const DELAY_SELECT: u16 = 0x016;
/// Clock and sign of patterns.
pub const PATTERN_MODE: u16 = 0x018;
/// Value of [`PATTERN_MODE`]: undivided clock.
pub const PATTERN_MODE_VALUE: u32 = 0x0200_0003;
/// Bits of [`PATTERN_MODE`] that read as they were written.
const PATTERN_MODE_READ: u32 = 0x0FFF_FFFF;
/// Repetitions of a pattern, and clock cycles to ground afterwards.
///
/// Bits 1 to 5 and bits 6 to 10.
pub const PATTERN_REPEAT: u16 = 0x019;
/// Silent channels, a bit each.
pub const SILENT: u16 = 0x01B;
/// Pattern of either half of the part.
pub const PATTERN_SELECT: [u16; 2] = [0x01E, 0x01F];
/// First register of delays: 16 a profile.
pub const DELAYS: u16 = 0x020;
/// First register of patterns: 4 a profile.
pub const PATTERNS: u16 = 0x120;
/// Number of the part's registers.
pub const REGISTERS: u16 = 0x1A0;

/// Bits of an SPI word: a frame is three of them.
const WORD: u32 = 14;
/// Entries of a pattern, its end included.
const ENTRIES: usize = 16;
/// Most clock cycles of an entry.
const LONGEST_ENTRY: u32 = 32;
/// Codes of an entry's level.
const POSITIVE: u8 = 0b010;
const NEGATIVE: u8 = 0b001;
const GROUND: u8 = 0b011;
const END: u8 = 0b111;
/// Maximum ratio of a supply to the requested voltage.
const SUPPLY_TOLERANCE: f64 = 1.05;

/// The board around the pulser: its rails and its trigger.
#[allow(async_fn_in_trait)]
pub trait TransmitBoard {
    /// Reason why a call failed.
    type Error;

    /// Sets both rails to ±`volts` V, and returns the larger of the voltages that it measures.
    ///
    /// # Errors
    /// The implementation's own.
    async fn supply(&mut self, volts: f64) -> Result<f64, Self::Error>;

    /// Triggers transmits `prf` times a second, or none.
    ///
    /// # Errors
    /// The implementation's own.
    async fn trigger(&mut self, prf: Option<f64>) -> Result<(), Self::Error>;
}

/// Reason why a [`Tx7332`] refused a call.
///
/// `B` is the board's error.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TxError<B> {
    /// Error of the part: bus, read-back, a number beyond its range.
    #[error("{0}")]
    Part(Error),
    /// There is no such profile.
    #[error("there is no profile {0}, expected 0 to 15")]
    Profile(u8),
    /// The profile was never loaded.
    #[error("profile {0} was never loaded")]
    NotLoaded(u8),
    /// The number of delays differs from the number of channels.
    #[error("there are {0} delays, expected 32")]
    Channels(usize),
    /// A channel's delay is too long.
    #[error("the delay of channel {channel} is {cycles} cycles, expected at most 8191")]
    Delay {
        /// The channel.
        channel: usize,
        /// The delay, clock cycles.
        cycles: u16,
    },
    /// Error of the board.
    #[error("the board: {0:?}")]
    Board(B),
    /// The rails are higher than the profile's voltage.
    ///
    /// Nothing fires, and the driver requests 0 V.
    #[error("the rails are at {measured} V, {asked} V were asked for")]
    Supply {
        /// The profile's voltage, V.
        asked: f64,
        /// The voltage that the board measured, V.
        measured: f64,
    },
}

/// A profile's share of the registers that all profiles use.
#[derive(Clone, Copy, Debug)]
struct Loaded {
    repeat: u32,
    silent: u32,
    select: u32,
    volts: f64,
    prf: f64,
}

/// Driver of TI's TX7332.
///
/// After an error of bus or board the driver stops the trigger and requests 0 V.
///
/// `SPI` moves words of 14 bits, in mode 0, with its select line low for a whole transaction: a frame is three
/// words. Its controller must be set to 14 bits (STM32, i.MX RT, RP2040), or an adapter drives pins.
#[derive(Clone, Debug)]
pub struct Tx7332<SPI, BOARD> {
    spi: SPI,
    board: BOARD,
    clock: f64,
    profiles: [Option<Loaded>; 16],
    /// The profile that fires now.
    firing: Option<u8>,
}

impl<SPI: SpiDevice<u16>, BOARD: TransmitBoard> Tx7332<SPI, BOARD> {
    /// A driver of the part on `spi` and `board`, with a clock in Hz.
    ///
    /// Nothing is sent yet.
    pub fn new(spi: SPI, board: BOARD, clock: f64) -> Self {
        Tx7332 {
            spi,
            board,
            clock,
            profiles: [None; 16],
            firing: None,
        }
    }

    /// The frequency that the part generates for a waveform, Hz.
    ///
    /// A half cycle is a whole number of clock cycles.
    ///
    /// # Errors
    /// [`Error::Range`] for a waveform that the part does not have.
    pub fn frequency(&self, waveform: &Waveform) -> Result<f64, Error> {
        let (on, off) = half_cycle(waveform, self.clock)?;
        Ok(self.clock / 2.0 / f64::from(on + off))
    }

    /// Writes registers, then reads all of them back.
    async fn write_checked<const N: usize>(
        &mut self,
        registers: [(u16, u32); N],
    ) -> Result<(), Error> {
        for (register, value) in registers {
            self.write(register, value).await?;
        }
        let mut read = [0; N];
        let mut outcome = Ok(());
        for half in READ {
            if outcome.is_ok() {
                outcome = self.read_half(half, &registers, &mut read).await;
            }
        }
        let off = self.write(CONTROL, 0).await;
        outcome.and(off)?;
        for ((register, written), read) in registers.into_iter().zip(read) {
            let mask = match register {
                PATTERN_MODE => PATTERN_MODE_READ,
                _ => u32::MAX,
            };
            if read & mask != written & mask {
                return Err(Error::ReadBack {
                    register,
                    written,
                    read,
                });
            }
        }
        Ok(())
    }

    /// Reads one half of the part. A register of the other half reads 0.
    async fn read_half(
        &mut self,
        half: u32,
        registers: &[(u16, u32)],
        read: &mut [u32],
    ) -> Result<(), Error> {
        self.write(CONTROL, half).await?;
        for ((register, _), value) in registers.iter().zip(read) {
            let mut words = [0; 3];
            let frame = frame(*register, 0);
            self.spi
                .transaction(&mut [Operation::Transfer(&mut words, &frame)])
                .await
                .map_err(Error::spi)?;
            let [high, middle, low] = words.map(u64::from);
            *value |= (high << (2 * WORD) | middle << WORD | low) as u32;
        }
        Ok(())
    }

    async fn write(&mut self, register: u16, value: u32) -> Result<(), Error> {
        let frame = frame(register, value);
        self.spi.write(&frame).await.map_err(Error::spi)
    }
}

impl<SPI: SpiDevice<u16>, BOARD: TransmitBoard> Pulser for Tx7332<SPI, BOARD> {
    type Error = TxError<BOARD::Error>;
    const CHANNELS: usize = 32;
    const PROFILES: u8 = 16;
    const LONGEST: u16 = 8191;

    fn clock(&self) -> f64 {
        self.clock
    }

    async fn load(&mut self, index: u8, profile: Checked<'_>) -> Result<(), Self::Error> {
        let profile = profile.profile();
        let waveform = &profile.waveform;
        if index >= Self::PROFILES {
            return Err(TxError::Profile(index));
        }
        let Ok(delays) = <&[Option<u16>; 32]>::try_from(profile.delays) else {
            return Err(TxError::Channels(profile.delays.len()));
        };
        for (channel, delay) in delays.iter().enumerate() {
            match *delay {
                Some(cycles) if cycles > Self::LONGEST => {
                    return Err(TxError::Delay { channel, cycles });
                }
                _ => {}
            }
        }
        let (pattern, repeat) = pattern(waveform, self.clock).map_err(TxError::Part)?;
        let tail = cycles("damping", waveform.damping * self.clock, 31).map_err(TxError::Part)?;
        let receive = profile.receive_after * self.clock;
        let receive = cycles("receive_after", receive, 4095).map_err(TxError::Part)?;

        let base = DELAYS + u16::from(index) * 16;
        let mut registers = [(0, 0); 20];
        for (row, register) in (0..16).zip(&mut registers) {
            *register = (base + row, 0);
        }
        let mut silent = 0;
        for (channel, delay) in delays.iter().enumerate() {
            let (row, shift) = delay_place(channel);
            match *delay {
                Some(cycles) => {
                    if let Some((_, value)) = registers.get_mut(row) {
                        *value |= u32::from(cycles) << shift;
                    }
                }
                None => silent |= 1 << silent_bit(channel),
            }
        }
        let base = PATTERNS + u16::from(index) * 4;
        let patterns = pattern.as_chunks::<4>().0.iter().enumerate();
        for ((row, entries), register) in patterns.zip(registers.iter_mut().skip(16)) {
            *register = (base + row as u16, u32::from_le_bytes(*entries));
        }
        // Until all registers are written, the profile is incomplete and must not fire.
        if self.firing == Some(index) {
            self.stop().await?;
        }
        self.profile(index, None);
        if let Err(error) = self.write_checked(registers).await {
            self.stop().await?;
            return Err(TxError::Part(error));
        }
        let select = u32::from(index) << 12 | receive;
        let loaded = Loaded {
            repeat: repeat << 1 | tail << 6,
            silent,
            select: select << 16 | select,
            volts: waveform.volts,
            prf: profile.prf,
        };
        self.profile(index, Some(loaded));
        Ok(())
    }

    async fn select(&mut self, index: u8) -> Result<(), Self::Error> {
        let loaded = match self.profiles.get(usize::from(index)) {
            None => return Err(TxError::Profile(index)),
            Some(None) => return Err(TxError::NotLoaded(index)),
            Some(Some(loaded)) => *loaded,
        };
        let firing = self
            .firing
            .and_then(|n| *self.profiles.get(usize::from(n))?);
        let changes = firing.is_none_or(|n| (n.volts, n.prf) != (loaded.volts, loaded.prf));
        if changes {
            self.stop().await?;
        }
        let registers = [
            (PATTERN_MODE, PATTERN_MODE_VALUE),
            (PATTERN_REPEAT, loaded.repeat),
            (PATTERN_SELECT[0], index.into()),
            (PATTERN_SELECT[1], index.into()),
            (DELAY_SELECT, loaded.select),
            (SILENT, loaded.silent),
        ];
        let mut written = self.write_checked(registers).await;
        if written.is_ok() {
            written = self.write(CONTROL, LOAD_PROFILE).await;
        }
        if let Err(error) = written {
            // The part is between two profiles, and must not fire.
            self.stop().await?;
            return Err(TxError::Part(error));
        }
        if changes {
            let started = self.start(&loaded).await;
            if started.is_err() {
                self.stop().await?;
                return started;
            }
        }
        self.firing = Some(index);
        Ok(())
    }

    async fn stop(&mut self) -> Result<(), Self::Error> {
        self.firing = None;
        let trigger = self.board.trigger(None).await;
        let supply = self.board.supply(0.0).await.map(drop);
        trigger.and(supply).map_err(TxError::Board)
    }
}

impl<SPI, BOARD: TransmitBoard> Tx7332<SPI, BOARD> {
    /// Brings up the rails, then the trigger.
    async fn start(&mut self, loaded: &Loaded) -> Result<(), TxError<BOARD::Error>> {
        let asked = loaded.volts;
        let measured = self.board.supply(asked).await.map_err(TxError::Board)?;
        // A measurement of NaN is beyond as well.
        let within = measured <= asked * SUPPLY_TOLERANCE;
        if !within {
            return Err(TxError::Supply { asked, measured });
        }
        let trigger = self.board.trigger(Some(loaded.prf)).await;
        trigger.map_err(TxError::Board)
    }
}

impl<SPI, BOARD> Tx7332<SPI, BOARD> {
    fn profile(&mut self, index: u8, loaded: Option<Loaded>) {
        if let Some(profile) = self.profiles.get_mut(usize::from(index)) {
            *profile = loaded;
        }
    }
}

/// A frame's words, the first 14 bits first.
fn frame(register: u16, value: u32) -> [u16; 3] {
    let bits = u64::from(register) << 32 | u64::from(value);
    let word = |shift: u32| (bits >> shift & ((1 << WORD) - 1)) as u16;
    [word(2 * WORD), word(WORD), word(0)]
}

/// Register and lowest bit of a channel's delay: odd channels of each half first, two a register.
pub(crate) fn delay_place(channel: usize) -> (usize, u32) {
    let (half, place) = (channel / 16, channel % 16);
    let (even, pair) = (place % 2, place / 2);
    let row = half * 8 + even * 4 + pair / 2;
    (row, if pair % 2 == 0 { 16 } else { 0 })
}

/// Bit of a channel in [`SILENT`].
pub(crate) fn silent_bit(channel: usize) -> usize {
    let (half, place) = (channel / 16, channel % 16);
    let (even, pair) = (place % 2, place / 2);
    half * 16 + if even == 1 { 7 - pair } else { 15 - pair }
}

/// A time in whole clock cycles, at most `most`.
fn cycles(name: &'static str, exact: f64, most: u32) -> Result<u32, Error> {
    let rounded = libm::round(exact);
    if rounded >= 0.0 && rounded <= f64::from(most) {
        return Ok(rounded as u32);
    }
    Err(Error::Range {
        name,
        value: rounded as i32,
        expected: match most {
            31 => "0 to 31 clock cycles",
            _ => "0 to 4095 clock cycles",
        },
    })
}

/// Clock cycles of a half cycle away from ground, and at ground.
///
/// The time away from ground is at most the waveform's.
fn half_cycle(waveform: &Waveform, clock: f64) -> Result<(u32, u32), Error> {
    let exact = clock / 2.0 / waveform.frequency;
    let (on, half) = (libm::floor(exact * waveform.driven), libm::round(exact));
    if !(on >= 2.0 && half < 1e6) {
        return Err(Error::Range {
            name: "half cycle",
            value: on as i32,
            expected: "at least 2 clock cycles driven, and less than 10⁶",
        });
    }
    let (on, half) = (on as u32, half as u32);
    // An entry has two clock cycles at least.
    match half.saturating_sub(on) {
        1 => Ok((on, 0)),
        off => Ok((on, off)),
    }
}

/// A pattern's entries, the lowest byte of the first register first, and its repetitions.
fn pattern(waveform: &Waveform, clock: f64) -> Result<([u8; ENTRIES], u32), Error> {
    let (on, off) = half_cycle(waveform, clock)?;
    let half_cycles = u32::from(waveform.half_cycles);
    let too_long = Error::Range {
        name: "half_cycles",
        value: waveform.half_cycles.into(),
        expected: "1 to 64 in a pattern of 15 entries of 32 clock cycles",
    };
    // Whole cycles are one cycle, repeated.
    let (listed, repeat) = match half_cycles {
        0 => return Err(too_long),
        n if n % 2 == 0 && n <= 64 => (2, n / 2 - 1),
        n => (n, 0),
    };
    let mut entries = [END; ENTRIES];
    let mut places = entries.iter_mut().take(ENTRIES - 1);
    for n in 0..listed {
        let level = match (n % 2 == 0) == waveform.positive_first {
            true => POSITIVE,
            false => NEGATIVE,
        };
        for (level, mut left) in [(level, on), (GROUND, off)] {
            while left > 0 {
                let take = match left {
                    0..=LONGEST_ENTRY => left,
                    // One cycle is no entry.
                    n if n == LONGEST_ENTRY + 1 => LONGEST_ENTRY - 1,
                    _ => LONGEST_ENTRY,
                };
                let Some(place) = places.next() else {
                    return Err(too_long);
                };
                *place = (take as u8 - 2) << 3 | level;
                left -= take;
            }
        }
    }
    Ok((entries, repeat))
}
