//! Drives the core's beamformer over the beams of a frame, on all threads.
