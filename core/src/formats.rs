//! `defmt::Format` of what is memory: how much there is of it, not what it holds.

use crate::beamform::{Slices, Storage, Workspace, WorkspaceView};
use crate::covariance::Averaging;
use crate::delay::IqSamples;
use crate::phase_symmetry::{
    External, GainTables, Kernels, LaneFft, LogGabor, LogGaborTables, StripMemory, StripSlices,
};
use crate::pipeline::{Frame, LineMemory, Memory, MemoryView};
use crate::simd::{ComplexVector, Vector};
use defmt::{Format, Formatter};

/// `Type(N bytes)` for types whose memory is so many bytes.
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
    [const M: usize, const L: usize, const K: usize, A: Storage<L, K>] Workspace<M, L, K, A>:
        "Workspace", memory => size_of_val(memory);
    [A: Averaging<V>, V: Vector] Slices<'_, A, V>: "Slices", memory =>
        size_of_val(memory.complex) + size_of_val(memory.scalars) + size_of_val(memory.reals);
    [const N: usize, const S: usize] StripMemory<N, S>: "StripMemory", memory => size_of_val(memory);
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
    [] MemoryView<'_>: "MemoryView", memory =>
        size_of_val(memory.real) + size_of_val(memory.complex);
    [] LineMemory<'_>: "LineMemory", memory =>
        size_of_val(memory.scratch) + size_of_val(memory.aligned);
    [] IqSamples<'_>: "IqSamples", memory => match memory {
        IqSamples::Float(samples) => size_of_val(*samples),
        IqSamples::Counts(samples, _) => size_of_val(*samples),
    };
}

impl<A: Averaging<V>, V: Vector> Format for WorkspaceView<'_, A, V> {
    fn format(&self, f: Formatter<'_>) {
        defmt::write!(f, "WorkspaceView({})", self.sizes());
    }
}

impl<D: crate::delay::Stage> Format for Frame<'_, '_, D> {
    fn format(&self, f: Formatter<'_>) {
        defmt::write!(f, "Frame({})", self.pipeline.sizes());
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
