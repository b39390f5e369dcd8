//! Sequences in the layouts of their real writers, and files that lie.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use bonebeam_files::image;
use bonebeam_tracked::{Chain, PoseTable, Sequence};
use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};
use ndarray::{Array2, array};
use tempfile::{TempDir, tempdir};

/// A header as IGSIO 9caba69 writes it, padded with blanks; `more` replaces lines of the same name.
fn mha(sides: &str, frames: usize, more: &[&str]) -> String {
    let lines = [
        "ObjectType = Image",
        "NDims = 3",
        "AnatomicalOrientation = RAI",
        "BinaryData = True",
        "BinaryDataByteOrderMSB = False",
        "CenterOfRotation = 0 0 0",
        "CompressedData = False",
        &format!("DimSize = {sides}                      {frames} "),
        "ElementNumberOfChannels = 1",
        "ElementSpacing = 1 1 1",
        "ElementType = MET_UCHAR",
        "Kinds = domain domain               list",
        "Offset = 0 0 0",
        "TransformMatrix = 1 0 0 0 1 0 0 0 1",
        "UltrasoundImageOrientation = MFA",
        "UltrasoundImageType = BRIGHTNESS",
    ];
    with(&lines, " = ", more)
}

/// Lines, with some replaced by those of the same name, and others added.
fn with(lines: &[&str], separator: &str, more: &[&str]) -> String {
    fn name<'l>(line: &'l str, separator: &str) -> &'l str {
        line.split(separator).next().unwrap()
    }
    let replaced = |line: &&&str| {
        more.iter()
            .any(|own| name(own, separator) == name(line, separator))
    };
    let kept = lines.iter().filter(|line| !replaced(line));
    kept.chain(more).map(|line| format!("{line}\n")).collect()
}

/// A frame's fields as IGSIO writes them, with a blank behind each matrix.
fn frame(k: usize, digits: usize, x: f64, status: &str) -> String {
    format!(
        "Seq_Frame{k:0digits$}_ProbeToTrackerTransform = 0 -1 0 {x} 1 0 0 2.5e-003 0 0 1 7 0 0 0 1 \n\
         Seq_Frame{k:0digits$}_ProbeToTrackerTransformStatus = {status}\n\
         Seq_Frame{k:0digits$}_Timestamp = {:.6}\n\
         Seq_Frame{k:0digits$}_ImageStatus = OK\n",
        100.0 + 0.05 * k as f64
    )
}

/// A folder with a file of a header and bytes.
fn file(name: &str, header: &str, bytes: &[u8]) -> (TempDir, PathBuf) {
    let folder = tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, [header.as_bytes(), bytes].concat()).unwrap();
    (folder, path)
}

fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn pictures(path: &Path) -> (Sequence, Vec<Array2<f32>>) {
    let sequence = Sequence::open(path, &PoseTable::default()).unwrap();
    let mut reader = sequence.reader().unwrap();
    let frames = 0..sequence.frames.len();
    let pictures = frames
        .map(|k| sequence.picture(reader.frame(k).unwrap()).unwrap())
        .collect();
    drop(reader);
    (sequence, pictures)
}

const LOCAL: &str = "ElementDataFile = LOCAL\n";

#[test]
fn a_sweep_of_plus_is_read_with_poses_statuses_and_times() {
    let bytes: Vec<u8> = (0..36).collect();
    for compressed in [false, true] {
        let packed = if compressed {
            zlib(&bytes)
        } else {
            bytes.clone()
        };
        // Digits of both widths, a status that is not OK, a frame without a picture.
        let size = format!("CompressedDataSize = {}                ", packed.len());
        let more = ["CompressedData = True", &size];
        let fields = frame(0, 4, 10.0, "OK")
            + &frame(1, 4, 11.0, "OUT_OF_VIEW")
            + &frame(2, 5, 12.0, "OK").replace("ImageStatus = OK", "ImageStatus = INVALID");
        let header = mha("4 3", 3, if compressed { &more } else { &[] }) + &fields + LOCAL;
        let (_folder, path) = file("sweep.igs.mha", &header, &packed);
        let (sequence, pictures) = pictures(&path);
        assert_eq!((sequence.sides, sequence.format), ([4, 3], "MetaImage"));
        assert_eq!(
            pictures[2],
            Array2::from_shape_fn((3, 4), |(r, c)| (24 + 4 * r + c) as f32)
        );
        let frames = &sequence.frames;
        assert_eq!(
            [0, 1, 2].map(|k| frames[k].has_picture),
            [true, true, false]
        );
        let [first, second] = [0, 1].map(|k| &frames[k].transforms["ProbeToTracker"]);
        assert_eq!(
            (&first.status[..], &second.status[..]),
            ("OK", "OUT_OF_VIEW")
        );
        // A matrix is written with any status, row by row.
        assert_eq!(
            second.matrix.unwrap()[..2],
            [[0.0, -1.0, 0.0, 11.0], [1.0, 0.0, 0.0, 2.5e-3]]
        );
        assert!((sequence.rate().unwrap() - 20.0).abs() < 1e-6);
        // 1 1 1 is no size of a pixel.
        assert_eq!(sequence.pixel, None);
        let names = sequence.transform_names();
        assert!(Chain::of(names, "Tracker", "Probe").is_ok());

        // Frames can be skipped, not read again.
        let mut reader = sequence.reader().unwrap();
        let last = sequence.picture(reader.frame(2).unwrap()).unwrap();
        assert_eq!(last, pictures[2]);
    }
}

#[test]
fn pictures_of_every_orientation_become_mf() {
    // In the order of the file; columns to the marked side and rows away from the transducer are 0 to 2 and 0 to 1.
    for (code, sides, bytes) in [
        ("MF", "3 2", [0, 1, 2, 10, 11, 12]),
        ("UFA", "3 2", [2, 1, 0, 12, 11, 10]),
        ("MN", "3 2", [10, 11, 12, 0, 1, 2]),
        ("UND", "3 2", [12, 11, 10, 2, 1, 0]),
        ("FM", "2 3", [0, 10, 1, 11, 2, 12]),
        ("FU", "2 3", [2, 12, 1, 11, 0, 10]),
        ("NMA", "2 3", [10, 0, 11, 1, 12, 2]),
        ("NU", "2 3", [12, 2, 11, 1, 10, 0]),
    ] {
        let orientation = format!("UltrasoundImageOrientation = {code}");
        let header = mha(sides, 1, &[&orientation]) + LOCAL;
        // SimpleITK 2.5.7 keeps this key when it writes an .mha as NRRD, where PLUS has "ultrasound image orientation".
        let sizes = format!("sizes: {sides} 1");
        let nrrd = plus_nrrd(&["encoding: raw", "type: uint8", &sizes]);
        let own = format!("UltrasoundImageOrientation:={code}");
        let nrrd = nrrd.replace("ultrasound image orientation:=MFA", &own);
        let nrrd = nrrd.replace("Seq_Frame0001_Status:=INVALID\n", "");
        for header in [header, nrrd] {
            let (_folder, path) = file("picture", &header, &bytes);
            let (sequence, pictures) = pictures(&path);
            assert_eq!(sequence.sides, [3, 2], "{code}");
            let expected = array![[0.0, 1.0, 2.0], [10.0, 11.0, 12.0]];
            assert_eq!(pictures[0], expected, "{code}");
        }
    }
}

#[test]
fn numbers_of_every_type_and_colours_are_read() {
    let short: Vec<u8> = [-3i16, 500].iter().flat_map(|v| v.to_be_bytes()).collect();
    let float: Vec<u8> = [0.5f32, -2.0]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let big = ["ElementType = MET_SHORT", "BinaryDataByteOrderMSB = True"];
    let rgb = [
        "ElementNumberOfChannels = 3",
        "UltrasoundImageType = RGB_COLOR",
    ];
    let green = 0.7152 * 200.0;
    for (more, bytes, expected) in [
        (&big[..], short, [-3.0, 500.0]),
        (&["ElementType = MET_FLOAT"][..], float, [0.5, -2.0]),
        (&rgb[..], vec![0, 200, 0, 100, 100, 100], [green, 100.0]),
    ] {
        let header = mha("2 1", 1, more) + LOCAL;
        let (_folder, path) = file("picture.mha", &header, &bytes);
        let read = &pictures(&path).1[0];
        let near = read
            .iter()
            .zip(expected)
            .all(|(a, b): (&f32, f32)| (a - b).abs() < 1e-4);
        assert!(near, "{more:?}: {read}");
    }
}

/// A header as PLUS writes NRRD, with a colon alone behind free fields of the picture.
fn plus_nrrd(more: &[&str]) -> String {
    let lines = [
        "NRRD0004",
        "# Complete NRRD file format specification at:",
        "# http://teem.sourceforge.net/nrrd/format.html",
        "dimension: 3",
        "encoding: gz",
        "endian: little",
        "kinds: domain domain                     list",
        "sizes: 3 2                           2",
        "space dimension: 2",
        "space directions: (1,0) (0,1) none",
        "type: int16",
        "ElementSpacing: 1 1 1",
        "ultrasound image orientation:=MFA",
        "ultrasound image type:=BRIGHTNESS",
        "Seq_Frame0000_ProbeToTrackerTransform:=1 0 0 5 0 1 0 6 0 0 1 7 0 0 0 1 ",
        "Seq_Frame0000_ProbeToTrackerTransformStatus:=OK",
        "Seq_Frame0000_Status:=OK",
        "Seq_Frame0001_Status:=INVALID",
    ];
    with(&lines, ":", more) + "\n"
}

#[test]
fn nrrd_is_read_with_its_frames_along_any_axis() {
    let of = |order: [i16; 12]| -> Vec<u8> { order.iter().flat_map(|v| v.to_le_bytes()).collect() };
    let frames_last = of([0, 1, 2, 3, 4, 5, 100, 101, 102, 103, 104, 105]);
    let frames_first = of([0, 100, 1, 101, 2, 102, 3, 103, 4, 104, 5, 105]);
    let first = ["kinds: list domain domain", "sizes: 2 3 2"];
    // 3D Slicer writes a slice axis, too.
    let slices = [
        "kinds: list domain domain domain",
        "sizes: 2 3 2 1",
        "dimension: 4",
    ];
    let raw = ["encoding: raw"];
    for (more, bytes) in [
        (&[][..], gzip(&frames_last)),
        (&raw[..], frames_last.clone()),
        (&first[..], gzip(&frames_first)),
        (&slices[..], gzip(&frames_first)),
    ] {
        let (_folder, path) = file("sweep.seq.nrrd", &plus_nrrd(more), &bytes);
        let (sequence, pictures) = pictures(&path);
        assert_eq!(
            pictures[0],
            array![[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]],
            "{more:?}"
        );
        assert_eq!(pictures[1], &pictures[0] + 100.0, "{more:?}");
        let valid = [0, 1].map(|k| sequence.frames[k].has_picture);
        assert_eq!(valid, [true, false], "{more:?}");
        assert_eq!(
            sequence.frames[0].transforms["ProbeToTracker"]
                .matrix
                .unwrap()[0][3],
            5.0
        );
        assert!(sequence.frames[1].transforms.is_empty());
    }
}

#[test]
fn pixels_may_lie_beside_their_header() {
    for (name, header) in [
        ("a.mhd", mha("2 1", 1, &[]) + "ElementDataFile = beside.raw\n"),
        ("a.nhdr", "NRRD0004\ntype: uchar\ndimension: 2\nsizes: 2 1\nencoding: raw\ndata file: beside.raw\n\n".into()),
    ] {
        let (folder, path) = file(name, &header, &[]);
        fs::write(folder.path().join("beside.raw"), [7, 8]).unwrap();
        assert_eq!(pictures(&path).1[0], array![[7.0, 8.0]]);
    }
}

#[test]
fn lines_of_rf_are_real_or_complex_and_begin_at_the_transducer() {
    let bytes: Vec<u8> = (1..=8i16).flat_map(|v| v.to_le_bytes()).collect();
    // Each line: re, and im where there is one.
    for (kind, code, sides, expected) in [
        (
            "RF_REAL",
            "FM",
            "4 2",
            ["1 0 2 0 3 0 4 0", "5 0 6 0 7 0 8 0"],
        ),
        (
            "RF_REAL",
            "FU",
            "4 2",
            ["5 0 6 0 7 0 8 0", "1 0 2 0 3 0 4 0"],
        ),
        (
            "RF_REAL",
            "NM",
            "4 2",
            ["4 0 3 0 2 0 1 0", "8 0 7 0 6 0 5 0"],
        ),
        ("RF_IQ_LINE", "FM", "4 2", ["1 2 3 4", "5 6 7 8"]),
        ("RF_IQ_LINE", "NU", "4 2", ["7 8 5 6", "3 4 1 2"]),
        ("RF_I_LINE_Q_LINE", "FM", "2 4", ["1 3 2 4", "5 7 6 8"]),
        ("RF_I_LINE_Q_LINE", "NU", "2 4", ["6 8 5 7", "2 4 1 3"]),
    ] {
        let orientation = format!("UltrasoundImageOrientation = {code}");
        let kind = format!("UltrasoundImageType = {kind}");
        let header = mha(sides, 1, &[&orientation, &kind, "ElementType = MET_SHORT"]) + LOCAL;
        let (_folder, path) = file("lines.mha", &header, &bytes);
        let sequence = Sequence::open(&path, &PoseTable::default()).unwrap();
        let read = sequence
            .lines(sequence.reader().unwrap().frame(0).unwrap())
            .unwrap();
        assert_eq!(sequence.sides, [read.ncols(), read.nrows()]);
        let lines = read.outer_iter().map(|line| {
            let numbers: Vec<String> = line.iter().map(|z| format!("{} {}", z.re, z.im)).collect();
            numbers.join(" ")
        });
        assert!(lines.eq(expected), "{kind} {code}: {read}");
        assert!(sequence.content.is_lines());
    }
}

#[test]
fn a_folder_is_matched_to_its_table_by_name_or_in_order() {
    let folder = tempdir().unwrap();
    let pngs = folder.path().join("UltrasoundImages");
    fs::create_dir(&pngs).unwrap();
    for (k, name) in ["9.png", "10.png", "0011.png"].iter().enumerate() {
        image::write(&Array2::from_elem((2, 3), k as f32), &pngs.join(name)).unwrap();
    }
    let table = folder.path().join("tracking.csv");
    let head = "timestamp,x,y,z,euler_x,euler_y,euler_z\n";
    let x = |sequence: &Sequence| -> Vec<Option<f64>> {
        let poses = sequence
            .frames
            .iter()
            .map(|frame| &frame.transforms["ProbeToReference"]);
        poses
            .map(|pose| pose.matrix.map(|matrix| matrix[0][3]))
            .collect()
    };
    // By name, in another order, without one; then in order.
    for (rows, expected) in [
        (
            "11,3,0,0,0,0,0\n9,1,0,0,0,0,0\n12,9,0,0,0,0,0\n",
            [Some(1.0), None, Some(3.0)],
        ),
        (
            "0.1,1,0,0,0,0,0\n0.2,2,0,0,0,0,0\n0.3,3,0,0,0,0,0\n",
            [Some(1.0), Some(2.0), Some(3.0)],
        ),
    ] {
        fs::write(&table, format!("{head}{rows}")).unwrap();
        let (sequence, pictures) = pictures(&pngs);
        assert_eq!(x(&sequence), expected);
        // 9 is before 10 and 0011.
        assert_eq!(pictures[2][[0, 0]], 2.0);
    }
    let refused = || {
        let options = PoseTable::default();
        let opened = Sequence::open(&pngs, &options);
        opened.map(|_| ()).unwrap_err().to_string()
    };
    fs::write(&table, format!("{head}0.1,1,0,0,0,0,0\n")).unwrap();
    assert!(refused().contains("has 1 rows, but"), "{}", refused());
    fs::write(folder.path().join("other.csv"), "").unwrap();
    assert!(refused().contains("by --poses"), "{}", refused());
}

/// Sides, frames, other lines of the header, bytes of pixels, words of the message.
const LIES: &str = "\
4 3|3||30|holds 2 whole frames; the header says 3
4 3|900000||30|claims 900000 frames
99999 3|1||30|99999 x 3
0 3|1||30|0 x 3
4 3|1|DimSize = 4 -3 1|30|DimSize = 4 -3 1
4 3|1|DimSize = 4 3 5 2;Kinds = domain domain domain list|200|[4, 3, 5]
4 3|1|Seq_Frame0001_ImageStatus = OK|12|frame 1, but pixels of 1 frames
4 3|1|Seq_Frame0000_AToBTransform = 1 2 3|12|AToBTransform that is not 16 numbers
4 3|1|Seq_Frame0000_AToBTransform = 1 0 0 0 0 1 0 0 0 0 1 0 5 6 7 1|12|expected 0, 0, 0, 1, rows first
4 3|1|Seq_Frame0000_AToBTransform = 2 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1|12|AToBTransform that scales by [2.000, 1.000, 1.000]
4 3|1|Seq_FrameX_AToBTransform = 1|12|names no frame
4 3|1|ElementDataFile = |0|no ElementDataFile
4 3|1|ElementDataFile = ../other.raw|0|expected one file in the same folder
4 3|1|ElementDataFile = LIST 2|0|expected one file in the same folder
4 3|1|ElementDataFile = none.raw|0|no such file
4 3|1|ElementType = MET_STRING|12|MET_STRING
4 3|1|UltrasoundImageOrientation = AMF|12|AMF
4 3|1|UltrasoundImageType = OTHER|12|OTHER
4 3|1|UltrasoundImageType = RF_REAL|12|fastest axis
4 3|1|ElementNumberOfChannels = 7|84|7 numbers
4 3|2|CompressedData = True;CompressedDataSize = 9000|40|compressed frames; the header says 9000
4 3|2|CompressedData = True|40|damaged";

#[test]
fn files_that_lie_are_refused_in_one_line() {
    for row in LIES.lines() {
        let cells: Vec<&str> = row.split('|').collect();
        let [sides, frames, more, bytes, words] = cells[..] else {
            panic!("{row}")
        };
        let more: Vec<&str> = more.split(';').filter(|line| !line.is_empty()).collect();
        let mut header = mha(sides, frames.parse().unwrap(), &more);
        match header.contains("ElementDataFile") {
            true => header = header.replace("ElementDataFile = \n", ""),
            false => header += LOCAL,
        }
        refused(&header, &vec![0; bytes.parse().unwrap()], words);
    }
    let compressed = mha("4 3", 2, &["CompressedData = True"]) + LOCAL;
    refused(
        &compressed,
        &zlib(&[1; 20]),
        "truncated within frame 1 of 2",
    );
    let nrrd = |more: &str| plus_nrrd(&[more]);
    for (more, words) in [
        ("encoding: bzip2", "encoding: bzip2"),
        ("type: block", "type: block"),
        ("byte skip: 12", "byte skip"),
        ("kinds: list domain list", "sides [2]"),
        ("endian: little", "damaged"),
    ] {
        refused(&nrrd(more), b"these bytes are no gzip", words);
    }
    refused("words\n", b"", "is no tracked sequence");
}

/// Checks that a file is refused when it is opened or read.
fn refused(header: &str, bytes: &[u8], words: &str) {
    let (_folder, path) = file("sweep.mha", header, bytes);
    let all = || -> bonebeam_files::Result<()> {
        let sequence = Sequence::open(&path, &PoseTable::default())?;
        let mut reader = sequence.reader()?;
        (0..sequence.frames.len()).try_for_each(|k| sequence.picture(reader.frame(k)?).map(|_| ()))
    };
    let message = all().unwrap_err().to_string();
    assert!(message.contains(words), "{words}: {message}");
    assert_eq!(message.lines().count(), 1);
}

/// zea names angles `euler_xyz`, and neither their unit nor whether the axes turn with the probe.
#[test]
fn how_angles_of_a_recordings_poses_are_taken_is_said() {
    let assumed = |length: usize| {
        let sequence =
            Sequence::of_recording(Path::new("a.hdf5"), &[None, Some(vec![0.5; length])]);
        sequence.assumed
    };
    assert!(assumed(6)[0].contains("fixed axes x, y, z, rad"));
    assert!(assumed(7).is_empty());
}
