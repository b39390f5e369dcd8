//! A refusal as a line of text: kind, name and numbers.

use bonebeam::Error;

pub fn refused<T>(result: Result<T, Error>) -> String {
    match result.err().expect("a refusal") {
        Error::Parameter {
            name,
            value,
            expected,
        } => format!("parameter {name} {value}: {expected}"),
        Error::Length {
            name,
            actual,
            expected,
        } => format!("length {name} {actual} for {expected}"),
        Error::Capacity {
            name,
            actual,
            capacity,
        } => format!("capacity {name} {actual} over {capacity}"),
        Error::NonFinite { name, index } => format!("non-finite {name} {index}"),
        error => format!("{error:?}"),
    }
}

/// Asserts that the text of a refusal begins with some words.
#[track_caller]
pub fn assert_refused<T>(result: Result<T, Error>, words: &str) {
    let found = refused(result);
    assert!(found.starts_with(words), "{found}, expected {words}");
}

/// The name of what was refused.
#[track_caller]
pub fn name<T>(result: Result<T, Error>) -> &'static str {
    match result.err().expect("a refusal") {
        Error::Parameter { name, .. } | Error::Capacity { name, .. } => name,
        error => panic!("{error}"),
    }
}
