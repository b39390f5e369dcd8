//! `defmt::Format` of memory types: their sizes, not their contents.

use crate::beamform::{SteeredSegments, Workspace};
use crate::delay::IqSamples;
use crate::geometry::{Steering, SteeringTable};
use crate::memory::{Memory, Scratch};
use crate::phase_symmetry::{
    External, GainTables, Kernels, LaneFft, LogGabor, LogGaborTables, StripSlices,
};
use crate::pipeline::Frame;
use crate::simd::{ComplexVector, Vector};
use crate::surface::{Survey, Tracker};
use defmt::{Format, Formatter};

/// `Type(N bytes)` for types with N bytes of memory.
macro_rules! bytes {
    ($([$($generics:tt)*] $type:ty: $name:literal, $memory:ident => $bytes:expr;)*) => {$(
        impl<$($generics)*> Format for $type {
            fn format(&self, f: Formatter<'_>) {
                let $memory = self;
                defmt::write!(f, "{=str}({=usize} bytes)", $name, $bytes);
            }
        }
    )*};
}

bytes! {
    [V] Scratch<'_, V>: "Scratch", memory => size_of_val(memory.real) + size_of_val(memory.complex);
    [V] StripSlices<'_, V>: "StripSlices", memory =>
        size_of_val(memory.strip)
            + size_of_val(memory.sums)
            + size_of_val(memory.line)
            + size_of_val(memory.gains);
    [M: AsRef<[f32]>] GainTables<M>: "GainTables", memory => size_of_val(memory.memory.as_ref());
    [] LogGaborTables: "LogGaborTables", memory => size_of_val(memory);
    [] LogGabor<'_>: "LogGabor", _memory => LogGaborTables::BYTES;
    [] LaneFft: "LaneFft", memory => size_of_val(memory);
    [const REAL: usize, const COMPLEX: usize] Memory<REAL, COMPLEX>: "Memory", memory =>
        size_of_val(memory);
    [] IqSamples<'_>: "IqSamples", memory => match memory {
        IqSamples::Float(samples) => size_of_val(*samples),
        IqSamples::Counts(samples, _) => size_of_val(*samples),
    };
}

impl<V: Vector> Format for Workspace<'_, V> {
    fn format(&self, f: Formatter<'_>) {
        defmt::write!(f, "Workspace({})", self.sizes());
    }
}

impl<D: crate::delay::Stage> Format for Frame<'_, '_, D> {
    fn format(&self, f: Formatter<'_>) {
        defmt::write!(f, "Frame({})", self.pipeline.need(1));
    }
}

impl Format for SteeredSegments<'_, '_> {
    fn format(&self, f: Formatter<'_>) {
        defmt::write!(f, "SteeredSegments({=usize})", self.segments.len());
    }
}

impl Format for Steering<'_> {
    fn format(&self, f: Formatter<'_>) {
        defmt::write!(f, "Steering({=usize} samples)", self.samples());
    }
}

impl Format for SteeringTable<'_> {
    fn format(&self, f: Formatter<'_>) {
        defmt::write!(f, "SteeringTable");
    }
}

impl Format for Survey<'_, '_> {
    fn format(&self, f: Formatter<'_>) {
        defmt::write!(f, "Survey({})", self.levels());
    }
}

impl Format for Tracker<'_, '_> {
    fn format(&self, f: Formatter<'_>) {
        defmt::write!(f, "Tracker");
    }
}

/// Memory behind a trait and kernels have nothing to print.
impl Format for External<'_> {
    fn format(&self, f: Formatter<'_>) {
        defmt::write!(f, "External");
    }
}

impl<F, G> Format for Kernels<'_, F, G> {
    fn format(&self, f: Formatter<'_>) {
        defmt::write!(f, "Kernels");
    }
}

/// Lane after lane.
impl<V: Vector> Format for ComplexVector<V> {
    fn format(&self, f: Formatter<'_>) {
        defmt::write!(f, "ComplexVector({}, {})", self.re.lanes(), self.im.lanes());
    }
}

#[cfg(feature = "simd")]
impl<S: fearless_simd::Simd> Format for crate::simd::Lanes<S> {
    fn format(&self, f: Formatter<'_>) {
        defmt::write!(f, "Lanes({})", Vector::lanes(self));
    }
}
