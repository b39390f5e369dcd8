//! The scan of the image `stream` on a workstation, by the core alone. Prints what the image must come to.

#[path = "../tests/common/mod.rs"]
mod common;

fn main() -> Result<(), bonebeam::Error> {
    let (image, map) = common::by_the_core()?;
    println!("bone map {:016x}", stream::scan::hash(&map));
    println!("image {:016x}", stream::scan::hash(&image));
    Ok(())
}
