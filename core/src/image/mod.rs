//! Beamformed lines → an image of isotropic pixels, 0..255.
