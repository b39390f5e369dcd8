//! The CT contour in the image plane for each combination of error sources.
//!
//! Table I is measured against it.

use crate::experiments::study::*;
use ndarray::{ArrayView2, Axis, Slice};

use crate::measure::registration::{Point, Rigid, fiducial_error};
use crate::measure::signed_distance::{SurfaceMeasure, uniform_baseline};
use bonebeam_simulate::Surface;

use super::sweep::Tip;

/// Registration of the CT volume to the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Registration {
    /// By the true position of the specimen.
    Exact,
    /// By the fiducials, picked in this way in the ultrasound volume.
    Picked(Tip),
    /// By the fiducials' brightest voxels, with a specimen that moves in the sweep.
    Moving,
}

impl Registration {
    pub const ALL: [Registration; 4] = [
        Registration::Exact,
        Registration::Picked(Tip::Brightest),
        Registration::Picked(Tip::Front),
        Registration::Moving,
    ];

    /// Name in the tables; `None` for the exact one.
    fn name(self) -> Option<&'static str> {
        match self {
            Registration::Exact => None,
            Registration::Picked(Tip::Brightest) => Some("registration"),
            Registration::Picked(Tip::Front) => Some("registration by the echoes' front"),
            Registration::Moving => Some("registration with motion in the sweep"),
        }
    }
}

/// Active sources of error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sources {
    pub registration: Registration,
    /// Whether the scanner assumes the speed of sound of tissue.
    pub sound_speed: bool,
    /// Whether the CT surface is at the paper's threshold.
    ///
    /// Otherwise it is at the middle of the step from air to bone.
    pub threshold: bool,
}

impl Sources {
    /// All sources; fiducials are picked at their brightest voxel.
    pub const ALL: Sources = Sources {
        registration: Registration::Picked(Tip::Brightest),
        sound_speed: true,
        threshold: true,
    };

    /// Every combination: first none, then each alone, then several together.
    pub fn every() -> Vec<Sources> {
        let mut all = Vec::new();
        for sound_speed in [false, true] {
            for threshold in [false, true] {
                for registration in Registration::ALL {
                    all.push(Sources {
                        registration,
                        sound_speed,
                        threshold,
                    });
                }
            }
        }
        all
    }

    /// Name in the tables.
    pub fn name(&self) -> String {
        let mut parts: Vec<&str> = self.registration.name().into_iter().collect();
        if self.sound_speed {
            parts.push("sound speed");
        }
        if self.threshold {
            parts.push("threshold");
        }
        match parts.is_empty() {
            true => "none".into(),
            false => parts.join(", "),
        }
    }
}

/// The outer outline of a surface in the image plane at an elevation.
///
/// # Errors
/// The plane does not cut the surface.
pub fn outline(surface: &Surface, way: impl Fn(Point) -> Point, elevation: f64) -> Result<Outline> {
    let placed = surface.clone().mapped(|p| {
        let [x, y, z] = way(p);
        [x, y - elevation, z]
    });
    let outline = placed.outline().map_err(Error::Data)?;
    let outline = outline.ok_or_else(|| {
        Error::Data(format!(
            "the CT surface has no outline at {} mm of elevation",
            1e3 * elevation
        ))
    })?;
    outline.without_holes()
}

/// A registration and its errors.
#[derive(Clone, Debug, Serialize)]
pub struct Registered {
    /// Transform from the CT scanner's coordinates to the image's.
    #[serde(skip)]
    pub transform: Rigid,
    /// Fiducial registration error: RMS distance at the fiducials, mm.
    pub fre_mm: f64,
    /// Target registration error: RMS distance at the bone in both slices, mm.
    pub tre_mm: f64,
    /// Mean displacement of the contour towards the array at those points, mm.
    pub towards_array_mm: f64,
}

impl Registered {
    /// Registers `ct` to `us`; `targets` are pairs of positions in the image and in CT.
    ///
    /// # Errors
    /// Picks that do not determine the transform.
    pub fn new(ct: &[Point], us: &[Point], targets: &[(Point, Point)]) -> Result<Self> {
        let transform = Rigid::of_landmarks(ct, us)?;
        let fre = fiducial_error(&transform, ct, us);
        Ok(Registered::with(transform, fre, targets))
    }

    /// Errors of a known transform.
    pub fn with(transform: Rigid, fre: f64, targets: &[(Point, Point)]) -> Self {
        let n = targets.len().max(1) as f64;
        let (mut square, mut shift) = (0.0, 0.0);
        for (image, ct) in targets {
            let found = transform.apply(*ct);
            square += (0..3).map(|k| (found[k] - image[k]).powi(2)).sum::<f64>() / n;
            shift += (image[2] - found[2]) / n;
        }
        Registered {
            transform,
            fre_mm: 1e3 * fre,
            tre_mm: 1e3 * square.sqrt(),
            towards_array_mm: 1e3 * shift,
        }
    }
}

/// A row of Table I.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Row {
    /// Localisation error, mm; positive inside the contour.
    pub error_mm: Option<f64>,
    /// Standard deviation, mm.
    pub std_mm: Option<f64>,
    /// Mean grey level in region B, outside.
    pub b: Option<f64>,
    /// Mean grey level in region C, inside.
    pub c: Option<f64>,
    /// Mean grey level of the pixels above 0 in region B.
    pub b_above_zero: Option<f64>,
    /// Mean grey level of the pixels above 0 in region C.
    pub c_above_zero: Option<f64>,
}

impl From<SurfaceMeasure> for Row {
    fn from(measured: SurfaceMeasure) -> Self {
        Row {
            error_mm: measured.mean.map(|v| 1e3 * v),
            std_mm: measured.std.map(|v| 1e3 * v),
            b: measured.outside,
            c: measured.inside,
            b_above_zero: measured.outside_above_zero,
            c_above_zero: measured.inside_above_zero,
        }
    }
}

/// Measures an image against the contour.
pub fn row(pixels: ArrayView2<f32>, distance: &Array2<f64>, region: Region) -> Row {
    measure(pixels, distance.view(), region).into()
}

/// The row of an image of uniform grey level.
pub fn uniform(distance: &Array2<f64>, region: Region) -> Row {
    Row {
        b: None,
        c: None,
        b_above_zero: None,
        c_above_zero: None,
        ..uniform_baseline(distance.view(), region).into()
    }
}

/// Every `every`-th pixel of an image along each axis.
pub fn every<T: Copy>(image: &Array2<T>, every: usize) -> Array2<T> {
    let every = Slice::new(0, None, every as isize);
    let rows = image.slice_axis(Axis(0), every);
    rows.slice_axis(Axis(1), every).to_owned()
}

/// Every `every`-th pixel of a grid.
pub fn thinned(grid: &PixelGrid, every: usize) -> PixelGrid {
    PixelGrid {
        pixel: grid.pixel * every as f64,
        rows: grid.rows.div_ceil(every),
        columns: grid.columns.div_ceil(every),
        ..*grid
    }
}
