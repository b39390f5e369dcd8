//! The scanner's image, linked for real parts.

use std::fs;

use anyhow::{Context, Result, ensure};

use crate::here::{Here, printed, said};

/// A stack that overflows is a fault within a frame of its end. Then only linked: there is no emulator of these parts. A
/// map with half the RAM is refused.
pub(crate) fn boards(here: &Here) -> Result<()> {
    let (text, status) = printed(&mut here.image("--bin overflow"))?;
    print!("{text}");
    ensure!(!status.success(), "an overflow of the stack went unnoticed");
    let overflow = text.lines().find_map(|line| {
        let bytes = line
            .strip_prefix("error: the stack overflowed by ")?
            .strip_suffix(" bytes")?;
        bytes.parse::<u32>().ok()
    });
    ensure!(
        overflow.is_some_and(|bytes| bytes < 1000),
        "the overflow has no size below 1000 bytes"
    );
    let folder = here.root.join("firmware/boards");
    let mut maps: Vec<_> = fs::read_dir(&folder)?
        .map(|file| file.map(|file| file.path()))
        .collect::<Result<_, _>>()?;
    maps.retain(|map| map.extension().is_some_and(|extension| extension == "x"));
    maps.sort();
    for map in maps {
        let part = map
            .file_stem()
            .and_then(|name| name.to_str())
            .context("a name of a memory map")?;
        let (text, linked) = board(here, part)?;
        ensure!(linked, "{part}: {text}");
        let smaller = "  RAM : ORIGIN = 0x24000000, LENGTH = 256K";
        let text = fs::read_to_string(&map)?;
        let lines: Vec<&str> = text
            .lines()
            .map(|line| {
                if line.starts_with("  RAM ") {
                    smaller
                } else {
                    line
                }
            })
            .collect();
        let small = folder.join("too-small.tmp.x");
        fs::write(&small, lines.join("\n") + "\n")?;
        let refused = board(here, "too-small.tmp");
        fs::remove_file(small)?;
        let (refusal, linked) = refused?;
        ensure!(!linked, "{part}: the image was linked into half the RAM");
        let reason = refusal
            .lines()
            .find_map(|line| line.find("section '").map(|at| &line[at..]));
        println!(
            "{part}: links; in half the RAM: {}",
            reason.unwrap_or(&refusal)
        );
    }
    Ok(())
}

/// What linking with a memory map of firmware/boards says, and whether it succeeded.
fn board(here: &Here, map: &str) -> Result<(String, bool)> {
    let mut build = here.command(
        "firmware",
        "cargo build --release --locked --quiet --bin stream",
    );
    build
        .env("BOARD", map)
        .env("CARGO_TARGET_DIR", here.built("firmware").join("boards"));
    let (text, status) = said(&mut build)?;
    Ok((text, status.success()))
}
