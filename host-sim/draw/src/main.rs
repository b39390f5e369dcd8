//! `bonebeam-draw`: drawn pictures and their labels in a folder.

use std::error::Error;
use std::fs::{File, create_dir_all};
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use bonebeam_draw::{Picture, Subject};
use clap::Parser;
use rayon::prelude::*;

type Failure = Box<dyn Error + Send + Sync>;

/// Draws B-mode pictures as grey PNG, with `labels.json`
#[derive(Parser)]
struct Arguments {
    /// Number of pictures
    #[arg(long, default_value_t = 100)]
    count: u64,
    /// Seed; the same seed gives the same bytes
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Folder to write
    #[arg(long)]
    out: PathBuf,
    /// Subjects, separated by commas [default: all]
    #[arg(long, value_enum, value_delimiter = ',')]
    kind: Vec<Subject>,
}

fn main() -> Result<(), Failure> {
    let arguments = Arguments::parse();
    create_dir_all(&arguments.out)?;
    let subjects = if arguments.kind.is_empty() {
        Subject::MIX.to_vec()
    } else {
        arguments.kind
    };
    let pictures = (0..arguments.count).into_par_iter();
    let labels = pictures.map(|number| {
        let subject = subjects[number as usize % subjects.len()];
        let picture = Picture::of(subject, arguments.seed, number);
        write(&arguments.out.join(&picture.label.image), &picture)?;
        Ok(picture.label)
    });
    let labels = labels.collect::<Result<Vec<_>, Failure>>()?;
    let file = BufWriter::new(File::create(arguments.out.join("labels.json"))?);
    Ok(serde_json::to_writer(file, &labels)?)
}

fn write(path: &Path, picture: &Picture) -> Result<(), Failure> {
    let (rows, columns) = picture.pixels.dim();
    let file = BufWriter::new(File::create(path)?);
    let mut encoder = png::Encoder::new(file, columns as u32, rows as u32);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_compression(png::Compression::Fast);
    let pixels = picture.pixels.as_slice().expect("standard layout");
    Ok(encoder.write_header()?.write_image_data(pixels)?)
}
