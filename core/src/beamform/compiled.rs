//! Optional parts that the crate's features compile in.

/// Whether apodizations are compiled in.
pub(crate) const APODIZATION: bool = cfg!(feature = "apodization");
/// Whether the forward covariance is compiled in.
pub(crate) const FORWARD: bool = cfg!(feature = "forward");
/// Whether postfilters are compiled in.
pub(crate) const POSTFILTERS: bool = cfg!(feature = "postfilters");
/// Whether kernels of several directions are compiled in.
pub(crate) const SUB_LINES: bool = cfg!(feature = "sub-lines");
