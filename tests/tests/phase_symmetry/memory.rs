//! Fast memory, external memory and fixed workspaces.

use super::*;
use crate::common::changed;
use crate::common::refused::refused;
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
    /// As fast as the buffers: also worked on where it lies.
    fast: bool,
    left: usize,
    /// The numbers copied from it, and the most numbers copied at once.
    copied: usize,
    largest: usize,
}

impl Counting {
    /// Memory full of NaN: the former contents have no effect.
    fn new(length: usize, fast: bool, left: usize) -> Self {
        Counting {
            data: vec![f32::NAN; length],
            fast,
            left,
            copied: 0,
            largest: 0,
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
        self.copied += into.len();
        self.data.as_slice().read_at(first, into)
    }

    fn view(&self, first: usize, length: usize) -> Option<&[f32]> {
        let data = self.fast.then_some(&self.data)?;
        data.get(first..)?.get(..length)
    }
}

impl core::WriteAt for Counting {
    fn write_at(&mut self, first: usize, from: &[f32]) -> Result<(), bonebeam::Error> {
        self.count(from.len())?;
        self.data.as_mut_slice().write_at(first, from)
    }

    fn view_mut(&mut self, first: usize, length: usize) -> Option<&mut [f32]> {
        let data = self.fast.then_some(&mut self.data)?;
        data.get_mut(first..)?.get_mut(..length)
    }
}

/// As on a microcontroller: fixed workspace and tables, and the caller's memory: fast, or failing after `left` accesses.
///
/// Returns the map and the memory of the spectrum, what is filtered, the amplitude and the symmetry.
fn on_target(
    image: &Array2<f32>,
    strip: usize,
    (fast, left): (bool, usize),
) -> Result<(Array2<f32>, [Counting; 4]), bonebeam::Error> {
    let (rows, columns) = image.dim();
    let bank = bank(rows, columns, &THREE, 3.0, strip)?;
    let mut memory = Strips::new(changed(bank.sizes(), |s| s.strip = 5));
    let mut tables = core::LogGaborTables::new();
    let kernels = core::Kernels {
        fft: &core::Microfft,
        gains: &core::LogGabor::new(&mut tables),
    };
    let sizes = bank.sizes();
    let lengths = [
        sizes.spectrum_len(),
        sizes.filtered_len(),
        sizes.amplitude_len(),
        sizes.symmetry_len(),
    ];
    let mut counting = lengths.map(|length| Counting::new(length, fast, left));
    let [spectrum, filtered, amplitude, symmetry] = &mut counting;
    bank.run(
        &kernels,
        &mut core::External {
            image: &mut image.as_slice().expect("row-major"),
            spectrum,
            filtered,
            amplitude,
            symmetry,
        },
        &mut memory.slices(),
        &mut |_| {},
    )?;
    let map = counting[3].data.clone();
    let map = Array2::from_shape_vec((rows, columns), map).expect("the image's size");
    Ok((map, counting))
}

#[test]
fn any_memory_gives_the_same_bits_and_what_is_fast_is_worked_on_where_it_lies() {
    let image = test_image(128, 64, 7);
    let (map, slow) = on_target(&image, 5, (false, usize::MAX)).unwrap();
    assert!(bits(&map) == bits(&in_core(&image, &THREE, 3.0)));
    // Rows or columns of 128 complex numbers moved at once.
    let largest = slow[0].largest.max(slow[1].largest);
    assert_eq!(largest / (2 * 128), 5);
    let (map, fast) = on_target(&image, 5, (true, usize::MAX)).unwrap();
    assert!(bits(&map) == bits(&in_core(&image, &THREE, 3.0)));
    // Copied: the columns that are transformed in place, and the sums before the division.
    let copied = fast.each_ref().map(|memory| memory.copied);
    let spectrum = slow[0].data.len();
    assert_eq!(copied, [spectrum, 0, 128 * 64, 128 * 64]);
}

#[test]
fn failing_memory_and_small_buffers_are_errors() {
    let image = test_image(128, 64, 7);
    let of = |strip, left| refused(on_target(&image, strip, (false, left)));
    for accesses in [0, 1, 50, 500] {
        assert_eq!(of(5, accesses), "Memory");
    }
    let words = format!("capacity strip buffer {} over {}", 2 * 6 * 128, 2 * 5 * 128);
    assert_eq!(of(6, usize::MAX), words);
}

#[test]
fn a_map_in_one_memory_refuses_what_does_not_fit_it_and_stays() {
    let bank = bank(64, 128, &[0.1], 3.0, 16).unwrap();
    let need = bank.sizes().map_need();
    let filters = core::LogGabor::fixed();
    let run = |image: &[f32], real: usize, complex: usize, map: &mut [f32]| {
        let (real, complex) = (&mut vec![0.0; real], &mut vec![Complex::ZERO; complex]);
        bank.map(
            &filters,
            image,
            Scratch::new(real, complex),
            map,
            &mut |_| {},
        )
    };
    let (image, mut map) = (vec![1.0; 64 * 128], vec![7.0; 64 * 128]);
    let (real, complex) = (need.real, need.complex);
    let short = refused(run(&image[1..], real, complex, &mut map));
    assert_eq!(short, "length image 8191 for 8192");
    let short = refused(run(&image, real, complex, &mut map[1..]));
    assert_eq!(short, "length map 8191 for 8192");
    assert!(run(&image, real - 1, complex, &mut map).is_err());
    assert!(run(&image, real, complex - 1, &mut map).is_err());
    let bad = changed(image.clone(), |image| image[5000] = f32::NAN);
    let bad = refused(run(&bad, real, complex, &mut map));
    assert_eq!(bad, "non-finite image 5000");
    let strips = vec![0.0; bank.gain_tables_len()];
    let strips = core::GainTables::new(&filters, &bank, strips).unwrap();
    let scratch = (&mut vec![0.0; real], &mut vec![Complex::ZERO; complex]);
    let scratch = Scratch::new(scratch.0, scratch.1);
    assert!(
        bank.map(&strips, &image, scratch, &mut map, &mut |_| {})
            .is_err()
    );
    assert!(map.iter().all(|&ps| ps == 7.0));
    assert_eq!(run(&image, real, complex, &mut map), Ok(()));
    assert!(map.iter().all(|&ps| ps == 0.0));
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
        let sizes = core::Sizes::new(rows, columns, strip);
        4 * sizes.need().real + 8 * sizes.need().complex
    };
    assert_eq!(bytes(64, 1), 1_792);
    assert_eq!(bytes(64, 64), 66_304);
    assert_eq!(bytes(512, 16), 137_216);
    let map = core::Sizes::new(64, 64, 1).map_need();
    assert_eq!(4 * map.real + 8 * map.complex, 66_816);
    assert_eq!(core::LaneFft::BYTES, 4_096);
    let bank = bank(512, 512, &THREE, 15.0, 16).unwrap();
    assert_eq!(4 * bank.gain_tables_len(), 5_003_276);
}

#[test]
fn lengths_beyond_any_memory_are_said_to_be_so() {
    let sizes = core::Sizes::new(usize::MAX, usize::MAX, usize::MAX);
    let lengths = [
        sizes.strip_len(),
        sizes.image_len(),
        sizes.spectrum_len(),
        sizes.filtered_len(),
        sizes.gain_tables_len(8),
    ];
    assert_eq!(lengths, [usize::MAX; 5]);
}
