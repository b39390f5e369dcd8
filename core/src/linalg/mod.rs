//! Cholesky, power iteration and the full eigensolver, over lanes.
