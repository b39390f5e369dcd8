//! Fast memory, external memory and fixed workspaces.

use super::*;
use crate::common::changed;
use bonebeam::memory::Scratch;

/// Fast memory.
struct Strips {
    sizes: core::Sizes,
    real: Vec<f32>,
    complex: Vec<Complex<f32>>,
}

impl Strips {
    fn new(sizes: core::Sizes) -> Self {
        let need = sizes.need();
        Strips {
            sizes,
            real: vec![f32::NAN; need.real],
            complex: vec![Complex::new(f32::NAN, f32::NAN); need.complex],
        }
    }

    fn slices(&mut self) -> core::StripSlices<'_, f32> {
        let scratch = Scratch::new(&mut self.real, &mut self.complex);
        core::StripSlices::new(self.sizes, scratch).unwrap()
    }
}

/// External memory that counts its accesses, and fails at a given one.
struct Counting {
    data: Vec<f32>,
    largest: usize,
    left: usize,
}

impl Counting {
    /// Memory full of NaN: the former contents have no effect.
    fn new(length: usize, left: usize) -> Self {
        Counting {
            data: vec![f32::NAN; length],
            largest: 0,
            left,
        }
    }

    fn count(&mut self, length: usize) -> Result<(), bonebeam::Error> {
        self.largest = self.largest.max(length);
        self.left = self.left.checked_sub(1).ok_or(bonebeam::Error::Memory)?;
        Ok(())
    }
}

impl core::ReadAt for Counting {
    fn read_at(&mut self, first: usize, into: &mut [f32]) -> Result<(), bonebeam::Error> {
        self.count(into.len())?;
        self.data.as_slice().read_at(first, into)
    }
}

impl core::WriteAt for Counting {
    fn write_at(&mut self, first: usize, from: &[f32]) -> Result<(), bonebeam::Error> {
        self.count(from.len())?;
        self.data.as_mut_slice().write_at(first, from)
    }
}

/// Memory as fast as the buffers; counts the numbers still copied from it.
struct Fast {
    data: Vec<f32>,
    copied: usize,
}

impl Fast {
    fn new(length: usize) -> Self {
        Fast {
            data: vec![f32::NAN; length],
            copied: 0,
        }
    }
}

impl core::ReadAt for Fast {
    fn read_at(&mut self, first: usize, into: &mut [f32]) -> Result<(), bonebeam::Error> {
        self.copied += into.len();
        self.data.as_slice().read_at(first, into)
    }

    fn view(&self, first: usize, length: usize) -> Option<&[f32]> {
        self.data.get(first..)?.get(..length)
    }
}

impl core::WriteAt for Fast {
    fn write_at(&mut self, first: usize, from: &[f32]) -> Result<(), bonebeam::Error> {
        self.data.as_mut_slice().write_at(first, from)
    }

    fn view_mut(&mut self, first: usize, length: usize) -> Option<&mut [f32]> {
        self.data.get_mut(first..)?.get_mut(..length)
    }
}

#[test]
fn fast_memory_is_worked_on_where_it_lies_and_gives_the_same_bits() {
    let image = test_image(128, 64, 7);
    let bank = bank(128, 64, &THREE, 3.0, 5).unwrap();
    let mut memory = Strips::new(bank.sizes());
    let mut tables = core::LogGaborTables::new();
    let kernels = core::Kernels {
        fft: &core::Microfft,
        gains: &core::LogGabor::new(&mut tables),
    };
    let sizes = bank.sizes();
    let mut spectrum = Fast::new(sizes.spectrum_len());
    let mut filtered = Fast::new(sizes.filtered_len());
    let mut amplitude = Fast::new(sizes.amplitude_len());
    let mut symmetry = Fast::new(sizes.symmetry_len());
    let mut external = core::External {
        image: &mut image.as_slice().expect("row-major"),
        spectrum: &mut spectrum,
        filtered: &mut filtered,
        amplitude: &mut amplitude,
        symmetry: &mut symmetry,
    };
    bank.run(&kernels, &mut external, &mut memory.slices(), &mut |_| {})
        .unwrap();
    let map = Array2::from_shape_vec((128, 64), symmetry.data).expect("the image's size");
    assert!(bits(&map) == bits(&in_core(&image, &THREE, 3.0)));
    // Copied: the columns that are transformed in place, and the sums before the division.
    assert_eq!(spectrum.copied, sizes.spectrum_len());
    assert_eq!(filtered.copied, 0);
    assert_eq!([amplitude.copied, symmetry.copied], [128 * 64; 2]);
}

#[test]
fn a_map_in_one_memory_refuses_what_does_not_fit_it_and_stays() {
    let bank = bank(64, 128, &[0.1], 3.0, 16).unwrap();
    let need = bank.sizes().map_need();
    let filters = core::LogGabor::fixed();
    let run = |image: &[f32], real: usize, complex: usize, map: &mut [f32]| {
        let scratch = Scratch {
            real: &mut vec![0.0; real],
            complex: &mut vec![Complex::ZERO; complex],
        };
        bank.map(&filters, image, scratch, map, &mut |_| {})
    };
    let (image, mut map) = (vec![1.0; 64 * 128], vec![7.0; 64 * 128]);
    let length = |name, actual, expected| {
        Err(bonebeam::Error::Length {
            name,
            actual,
            expected,
        })
    };
    let (real, complex, pixels) = (need.real, need.complex, 64 * 128);
    assert_eq!(
        run(&image[1..], real, complex, &mut map),
        length("image", pixels - 1, pixels)
    );
    assert_eq!(
        run(&image, real, complex, &mut map[1..]),
        length("map", pixels - 1, pixels)
    );
    assert!(run(&image, real - 1, complex, &mut map).is_err());
    assert!(run(&image, real, complex - 1, &mut map).is_err());
    let mut bad = image.clone();
    bad[5000] = f32::NAN;
    let refused = bonebeam::Error::NonFinite {
        name: "image",
        index: 5000,
    };
    assert_eq!(run(&bad, real, complex, &mut map), Err(refused));
    let strips = vec![0.0; bank.gain_tables_len()];
    let strips = core::GainTables::new(&filters, &bank, strips).unwrap();
    let scratch = Scratch {
        real: &mut vec![0.0; real],
        complex: &mut vec![Complex::ZERO; complex],
    };
    assert!(
        bank.map(&strips, &image, scratch, &mut map, &mut |_| {})
            .is_err()
    );
    assert!(map.iter().all(|&ps| ps == 7.0));
    assert_eq!(run(&image, real, complex, &mut map), Ok(()));
    assert!(map.iter().all(|&ps| ps == 0.0));
}

/// As on a microcontroller: fixed workspace and tables, and the caller's memory.
///
/// Returns the map and the largest number of rows or columns of 128 complex numbers moved at once.
fn on_target(
    image: &Array2<f32>,
    strip: usize,
    accesses: usize,
) -> Result<(Array2<f32>, usize), bonebeam::Error> {
    let (rows, columns) = image.dim();
    let bank = bank(rows, columns, &THREE, 3.0, strip)?;
    let mut memory = Strips::new(changed(bank.sizes(), |s| s.strip = 5));
    let mut tables = core::LogGaborTables::new();
    let kernels = core::Kernels {
        fft: &core::Microfft,
        gains: &core::LogGabor::new(&mut tables),
    };
    let sizes = bank.sizes();
    let mut spectrum = Counting::new(sizes.spectrum_len(), usize::MAX);
    let mut filtered = Counting::new(sizes.filtered_len(), accesses);
    let mut amplitude = vec![f32::NAN; sizes.amplitude_len()];
    let mut symmetry = vec![f32::NAN; sizes.symmetry_len()];
    bank.run(
        &kernels,
        &mut core::External {
            image: &mut image.as_slice().expect("row-major"),
            spectrum: &mut spectrum,
            filtered: &mut filtered,
            amplitude: &mut amplitude.as_mut_slice(),
            symmetry: &mut symmetry.as_mut_slice(),
        },
        &mut memory.slices(),
        &mut |_| {},
    )?;
    let largest = filtered.largest.max(spectrum.largest);
    let map = Array2::from_shape_vec((rows, columns), symmetry).expect("the image's size");
    Ok((map, largest / (2 * 128)))
}

#[test]
fn a_fixed_workspace_and_own_memory_give_the_same_bits() {
    let image = test_image(128, 64, 7);
    let (map, largest) = on_target(&image, 5, usize::MAX).unwrap();
    assert!(bits(&map) == bits(&in_core(&image, &THREE, 3.0)));
    assert_eq!(largest, 5, "rows or columns moved at once");
}

#[test]
fn failing_memory_and_small_buffers_are_errors() {
    let image = test_image(128, 64, 7);
    for accesses in [0, 1, 50, 500] {
        let result = on_target(&image, 5, accesses);
        assert_eq!(result.unwrap_err(), bonebeam::Error::Memory);
    }
    let too_high = on_target(&image, 6, usize::MAX).unwrap_err();
    let expected = bonebeam::Error::Capacity {
        name: "strip buffer",
        actual: 2 * 6 * 128,
        capacity: 2 * 5 * 128,
    };
    assert_eq!(too_high, expected);
}

#[test]
fn a_slice_refuses_what_does_not_lie_in_it() {
    use super::core::{ReadAt, WriteAt};
    let mut data = [0.0, 1.0, 2.0, 3.0, 4.0];
    let mut two = [0.0; 2];
    data.as_slice().read_at(3, &mut two).unwrap();
    assert_eq!(two, [3.0, 4.0]);
    data.as_mut_slice().write_at(0, &two).unwrap();
    assert_eq!(data, [3.0, 4.0, 2.0, 3.0, 4.0]);
    for wrong in [4, 5, usize::MAX] {
        let mut slice = data.as_mut_slice();
        assert_eq!(slice.read_at(wrong, &mut two), Err(bonebeam::Error::Memory));
        assert_eq!(slice.write_at(wrong, &two), Err(bonebeam::Error::Memory));
    }
}

#[test]
fn memory_is_what_the_documentation_says() {
    assert_eq!(core::LogGaborTables::BYTES, 17_920);
    let bytes = |rows, strip| {
        let columns = 64;
        let sizes = core::Sizes {
            rows,
            columns,
            strip,
        };
        4 * sizes.need().real + 8 * sizes.need().complex
    };
    assert_eq!(bytes(64, 1), 1_792);
    assert_eq!(bytes(64, 64), 66_304);
    assert_eq!(bytes(512, 16), 137_216);
    let map = core::Sizes {
        rows: 64,
        columns: 64,
        strip: 1,
    }
    .map_need();
    assert_eq!(4 * map.real + 8 * map.complex, 66_816);
    assert_eq!(core::LaneFft::BYTES, 4_096);
    let bank = bank(512, 512, &THREE, 15.0, 16).unwrap();
    assert_eq!(4 * bank.gain_tables_len(), 5_003_276);
}

#[test]
fn lengths_beyond_any_memory_are_said_to_be_so() {
    let sizes = core::Sizes {
        rows: usize::MAX,
        columns: usize::MAX,
        strip: usize::MAX,
    };
    let lengths = [
        sizes.strip_len(),
        sizes.image_len(),
        sizes.spectrum_len(),
        sizes.filtered_len(),
        sizes.gain_tables_len(8),
    ];
    assert_eq!(lengths, [usize::MAX; 5]);
}
