//! Spatially smoothed, time-averaged covariance (Eq. 2, 3).
