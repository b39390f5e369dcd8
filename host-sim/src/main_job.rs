//! The main job: both phantoms, every method, every check, one report.
