//! Structs and cells of MATLAB 7.3.

use super::*;

/// A struct, an array of structs and a cell, as in MATLAB 7.3.
///
/// They are a group, a group of references and a dataset of references.
#[test]
fn structs_and_cells_are_read_by_their_paths() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mat");
    let file = H5File::create(&path).unwrap();
    let number = |name: &str, values: &[f64]| {
        let dataset = file.new_dataset::<f64>().shape([values.len()]);
        dataset.create(name).unwrap().write_raw(values).unwrap();
    };
    for group in ["P", "Receive", "#refs#"] {
        file.create_group(group).unwrap();
    }
    number("P/c", &[1540.0]);
    for (name, value) in [("a", 1.0), ("b", 9.0), ("c", 7.0)] {
        number(&format!("#refs#/{name}"), &[value]);
    }
    for (name, entries) in [
        ("Receive/start", &["/#refs#/a", "/#refs#/b"][..]),
        ("RcvData", &["/#refs#/c"]),
    ] {
        let dataset = file.new_dataset::<u64>().object_references();
        let dataset = dataset.shape([entries.len()]).create(name).unwrap();
        dataset.write_object_references(entries).unwrap();
    }
    file.close().unwrap();
    let file = Store::open(&path, true).unwrap();
    let mut names = file.names();
    names.sort();
    assert_eq!(names, ["P/c", "RcvData", "Receive/start"]);
    for (name, values) in [
        ("P.c", &[1540.0][..]),
        ("/P/c", &[1540.0]),
        ("RcvData", &[7.0]),
        ("RcvData{1}", &[7.0]),
        ("Receive.start", &[1.0, 9.0]),
        ("Receive(2).start", &[9.0]),
    ] {
        assert!(file.has(name), "{name}");
        assert_eq!(file.vector(name).unwrap(), values, "{name}");
    }
    for name in [
        "P",
        "P(2).c",
        "Receive(3).start",
        "RcvData{2}",
        "Receive.end",
    ] {
        assert!(!file.has(name), "{name}");
        file.vector(name).unwrap_err();
    }
    let several = file.samples("Receive.start", None).unwrap_err().to_string();
    assert!(several.contains("stands for 2 arrays"), "{several}");
}
