//! Channel data → delayed analytic samples.
