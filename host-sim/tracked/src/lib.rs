//! Tracked sweeps and the bone surface over them; volumes of CT.
//!
//! [`Sequence`] reads what PLUS and 3D Slicer write, DICOM, and folders of PNGs with a table of poses. Poses are matrices in
//! millimetres that act on columns (x, y, z, 1), named by their frames: `ProbeToTracker` maps a point in the probe's
//! frame to the tracker's. A point of a picture is (column, row, 0, 1) in the frame `Image`, with pixel centres at
//! whole numbers and the picture in PLUS's orientation `MF`.

mod agreement;
mod calibration;
mod cloud;
mod cloud_files;
mod delay;
mod dicom;
mod finder;
mod folder;
mod header;
mod igtl;
mod kept;
mod live;
mod message;
mod metaimage;
mod nrrd;
mod open;
mod orientation;
mod pixels;
mod poses;
mod sequence;
mod sweep;
mod track;
mod transforms;
mod views;
mod volume;

pub use bonebeam_files::{Error, Result};
pub use calibration::Calibration;
pub use cloud::CloudPoint;
pub use cloud_files::{Space, add_cloud_to, check_name};
pub use delay::Delay;
pub use finder::Finder;
pub use folder::is_folder_of_pictures;
pub use igtl::{Image, image_content, point_content, polydata_content};
pub use live::Live;
pub use message::Message;
pub use orientation::Orientation;
pub use poses::{AngleUnit, Euler, LengthUnit, PoseTable};
pub use sequence::{Content, Encoded, Frame, Reader, Sequence, Tracked};
pub use sweep::{Cloud, Settings, sweep};
pub use track::Track;
pub use transforms::{Chain, IDENTITY, Matrix, apply, inverse, name_parts, product};
pub use views::views;
pub use volume::Voxels;
