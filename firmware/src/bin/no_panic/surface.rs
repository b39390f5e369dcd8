//! The bone surface.

use crate::geometry::axis;
use crate::{opaque, take};
use bonebeam::prelude::stages::*;
use bonebeam::surface::{Levels, Parameters, Settings, Survey, Tracker, grey};

/// Calls it.
pub fn all() {
    let mut to = [0; 100];
    take(grey(opaque(&[0.0; 100][..]), opaque(&mut to[..])));
    take(Ramp::new(opaque(1.0), opaque(0.0), opaque(1.0)));
    take(detector());
}

fn detector() -> Result<(), Error> {
    let parameters = opaque(Parameters {
        samples: axis(),
        spacing: 1.0,
        settings: Settings::default(),
        latency: 1,
    });
    take(parameters.need());
    let detector = opaque(Detector::new(parameters)?);
    take((detector.parameters(), detector.need()));
    let (line, mut real) = ([0; 100], [0.0; 100]);
    let (line, real) = (opaque(&line[..]), opaque(&mut real[..]));
    fn scratch(real: &mut [f32]) -> Scratch<'_> {
        Scratch::new(real, opaque(&mut []))
    }
    let mut points = [None; 9];
    take(detector.frame(line, scratch(real), opaque(&mut points[..])));
    let coherence = opaque(line);
    take(detector.frame_with_coherence(line, coherence, scratch(real), opaque(&mut points[..])));
    let mut survey = Survey::new(&detector, scratch(real))?;
    take(survey.line(line));
    let levels: Levels = opaque(survey.levels());
    let mut tracker = Tracker::new(&detector, scratch(real))?;
    take(tracker.line(line, levels)?);
    take(tracker.line_with_coherence(line, coherence, levels)?);
    tracker.finish(take);
    detector.keep_sure_pieces(opaque(&mut points[..]));
    take(points);
    Ok(())
}
