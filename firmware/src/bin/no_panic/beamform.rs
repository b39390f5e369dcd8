//! The beamformers.

use crate::{opaque, take};
use bonebeam::beamform::{
    AlignedLine, Beamformer, Method, Parameters, Segment, Sizes, Slices, Workspace, WorkspaceView,
    constant_segments, segments_within,
};
use bonebeam::covariance::{Averaging, Covariance, Forward, ForwardBackward};
use bonebeam::geometry::Active;
use bonebeam::simd::ComplexVector;
use bonebeam::{Complex, Error};

fn parameters(method: Method) -> Parameters {
    Parameters {
        method,
        ..opaque(Parameters::DEFAULT)
    }
}

fn active() -> Active {
    let [first, count] = opaque([0, 1]);
    Active { first, count }
}

/// Calls all of it.
pub fn all() {
    memory();
    // Which method, nobody knows.
    let method = opaque(Method::EsmvBeta(opaque(0.5)));
    take(one::<Forward>(method));
    take(one::<ForwardBackward>(method));
    take(weights_of::<Forward>(method));
    take(weights_of::<ForwardBackward>(method));
}

fn one<A: Averaging<f32>>(method: Method) -> Result<(), Error> {
    let x = [Complex::ZERO; 100];
    let line = AlignedLine::new(opaque(&x[..]), opaque(1))?;
    take((line.elements(), line.samples()));
    let beamformer = Beamformer::new(parameters(method))?;
    take((
        beamformer.sizes(opaque(1)),
        beamformer.subaperture(opaque(1)),
    ));
    take(beamformer.parameters());
    let mut memory = Memory::<A>::new();
    let mut view = memory.view()?;
    take(view.sizes());
    let (mut z, mut other) = ([Complex::ZERO; 100], [Complex::ZERO; 100]);
    beamformer.line(&mut view, line, |_| active(), opaque(&mut z[..]))?;
    let (adaptive, z_within) = (opaque(0)..opaque(1), opaque(&mut z[..]));
    beamformer.line_within(&mut view, line, |_| active(), adaptive, z_within)?;
    let segment = Segment {
        line,
        first_element: opaque(1),
        first_sample: opaque(1),
    };
    let segments = [segment; 2];
    let mut out = [opaque(&mut z[..]), opaque(&mut other[..])];
    beamformer.segments(
        &mut view,
        opaque(&segments[..]),
        opaque(1),
        opaque(&mut out[..]),
    )
}

fn weights_of<A: Averaging<f32>>(method: Method) -> Result<usize, Error> {
    let x = [Complex::ZERO; 100];
    let line = AlignedLine::new(opaque(&x[..]), opaque(1))?;
    let beamformer = Beamformer::new(parameters(method))?;
    let mut memory = Memory::<A>::new();
    let mut view = memory.view()?;
    let mut z = [Complex::ZERO; 100];
    beamformer.weights(&mut view, line, active(), opaque(1), opaque(&mut z[..]))
}

/// Workspaces, sizes, runs.
fn memory() {
    take(sizes().lengths(opaque(Covariance::Forward)));
    take(opaque(Workspace::<16, 8, 0>::new()).view().sizes());
    take(opaque(Workspace::<16, 8, 1, Forward>::new()).view().sizes());
    take(WorkspaceView::empty(0.0f32).sizes());
    constant_segments(opaque(1), |_| active()).for_each(take);
    let wanted = opaque(0)..opaque(1);
    segments_within(opaque(1), |_| active(), wanted, opaque(1)).for_each(take);
    let mut number = ComplexVector::from_real(opaque(0.0f32));
    number.set_lane(opaque(1), Complex::ZERO);
    take(number.lane(opaque(1)));
}

fn sizes() -> Sizes {
    let [elements, subaperture, temporal_half_window] = opaque([1; 3]);
    Sizes {
        elements,
        subaperture,
        temporal_half_window,
    }
}

struct Memory<A: Averaging<f32>> {
    complex: [ComplexVector<f32>; 100],
    scalars: [A::Scalar; 100],
    reals: [f32; 100],
}

impl<A: Averaging<f32>> Memory<A> {
    fn new() -> Self {
        Memory {
            complex: [ComplexVector::from_real(0.0); 100],
            scalars: [A::scalar(0.0); 100],
            reals: [0.0; 100],
        }
    }

    fn view(&mut self) -> Result<WorkspaceView<'_, A>, Error> {
        let slices = Slices {
            complex: opaque(&mut self.complex[..]),
            scalars: opaque(&mut self.scalars[..]),
            reals: opaque(&mut self.reals[..]),
        };
        Ok(opaque(WorkspaceView::new(0.0, sizes(), slices)?))
    }
}
