//! Phase symmetry of an image, through the core's strips.
