//! The vertebra slice in a water bath (the paper's Fig. 4 to 9 and Table I).

use serde::Serialize;

use crate::Result;
use crate::drive::image::grid_of_lines;
use crate::simulate::{Outline, Phantom, Summation, channel_data};
use crate::validate::Check;

use super::frame::beamform_all;
use super::parameters::{Parameters, Vertebra};
use super::picture::{Pair, Studio};
use super::view::View;

/// What came out of the vertebra.
#[derive(Clone, Debug, Serialize)]
pub struct VertebraResult {
    /// What an image of one grey level scores, B-mode and phase symmetry.
    pub uniform: ByImage<Surface>,
    /// One entry a beamformer.
    pub beamformers: Vec<VertebraMeasure>,
    /// Depths of the axial line's pixels.
    pub axial_depth_mm: Vec<f64>,
    /// Lateral position of the axial line.
    pub axial_x_mm: f64,
    /// Lateral positions of the lateral line's pixels.
    pub lateral_x_mm: Vec<f64>,
    /// Depth of the lateral line.
    pub lateral_depth_mm: f64,
    /// Where the true surface crosses the axial line, shallowest first.
    pub axial_surface_mm: Vec<f64>,
    /// Where the true surface crosses the lateral line, from the left.
    pub lateral_surface_mm: Vec<f64>,
    /// Centres of the bins of signed distance, inside the bone positive.
    pub distance_mm: Vec<f64>,
    /// The pictures.
    pub pictures: Vec<Pair>,
    /// The true outer surface: closed loops of points (x, depth).
    #[serde(skip)]
    pub outline_mm: Vec<Vec<(f64, f64)>>,
}

/// A value of the B-mode image and one of its phase symmetry.
#[derive(Clone, Debug, Serialize)]
pub struct ByImage<T> {
    /// Of the B-mode image ("US" in the paper).
    pub b_mode: T,
    /// Of the phase symmetry image ("PS").
    pub phase_symmetry: T,
}

/// The signed-distance measures of one image (Table I).
#[derive(Clone, Debug, Serialize)]
pub struct Surface {
    /// Localization error: mean signed distance in region A, weighted by intensity.
    pub mean_mm: Option<f64>,
    /// Its weighted standard deviation.
    pub std_mm: Option<f64>,
    /// The same mean within 1 mm of the surface, on either side.
    pub near_mean_mm: Option<f64>,
    /// Its standard deviation.
    pub near_std_mm: Option<f64>,
    /// Mean intensity 0..255 at the surface (A).
    pub intensity_a: Option<f64>,
    /// Outside the bone (B).
    pub intensity_b: Option<f64>,
    /// Inside it (C).
    pub intensity_c: Option<f64>,
}

/// The measures of one beamformer.
#[derive(Clone, Debug, Serialize)]
pub struct VertebraMeasure {
    /// The beamformer's key.
    pub beamformer: &'static str,
    /// Table I.
    pub surface: ByImage<Surface>,
    /// The line down through the tip of the spinous process (Fig. 8a, c).
    pub axial: ByImage<ImageLine>,
    /// The line across the laminae (Fig. 8b, d).
    pub lateral: ByImage<ImageLine>,
    /// Mean intensity by signed distance (Fig. 6, 7).
    pub intensity_by_distance: ByImage<Vec<Option<f64>>>,
}

/// One line of an image.
#[derive(Clone, Debug, Serialize)]
pub struct ImageLine {
    /// Grey levels.
    pub intensity: Vec<f32>,
    /// The peak's distance from the true surface, deeper or farther right positive.
    pub peak_bias_mm: Option<f64>,
    /// Width of the peak at the paper's grey level.
    pub width_mm: Option<f64>,
    /// That level.
    pub width_level: f64,
    /// Width of the peak at half its own grey level.
    pub half_width_mm: Option<f64>,
    /// Mean grey level between depths of 30 and 40 mm, on the axial line.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<f64>,
}

/// The slice of the vertebra in its water bath.
///
/// # Errors
/// A mesh that cannot be read, a slice that does not cut it, or one outside the record.
pub fn phantom(vertebra: &Vertebra) -> Result<Phantom> {
    let phantom = Phantom::slice(vertebra.mesh.as_deref(), vertebra.slice, vertebra.depth)?;
    phantom.check_within(&vertebra.simulation)?;
    Ok(phantom)
}

/// Simulates, beamforms, pictures and measures the vertebra.
///
/// # Errors
/// Parameters that do not fit together.
pub fn run(
    parameters: &Parameters,
    phantom: &Phantom,
    progress: &(dyn Fn(&str, f64) + Sync),
) -> Result<(VertebraResult, Vec<Check>)> {
    let vertebra = &parameters.vertebra;
    let settings = &vertebra.simulation;
    let data = channel_data(settings, phantom, Summation::Gridded, &|done| {
        progress("vertebra: simulate", done);
    })?;
    let (lines, mut checks) = beamform_all(
        "vertebra",
        &data,
        &vertebra.receive,
        Some(&parameters.checks),
        progress,
    )?;
    drop(data);

    progress("vertebra: pictures", 0.0);
    let grid = grid_of_lines(&lines[0], vertebra.image.rows, vertebra.image.columns)?;
    let studio = Studio {
        what: "vertebra",
        grid,
        image: &vertebra.image,
        phase_symmetry: &parameters.phase_symmetry,
        rows: 0..grid.rows,
        centre: 0.0,
        check: true,
    };
    let (pictures, found) = studio.pictures(&lines)?;
    checks.extend(found);

    progress("vertebra: measures", 0.0);
    let bone = phantom.bone.as_ref().map(Outline::without_holes);
    let bone = bone.expect("a vertebra has a bone")?;
    let view = View::new(&bone, grid, vertebra.lateral_line);
    Ok((view.result(pictures), checks))
}
