//! Lines → image, through the core.
