//! Measures on lines and images.
