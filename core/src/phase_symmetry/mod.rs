//! Phase symmetry: log-Gabor filters and the ridge measure (Eq. 9, 10).
