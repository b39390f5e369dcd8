//! The beamformers: weights from a covariance, and a whole line from delayed samples (Eq. 1, 4–8).
