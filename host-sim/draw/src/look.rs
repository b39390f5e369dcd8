//! How bone looks.

/// Ranges that make bone clear or faint, dB: flat bone over speckle, noise at the skin, fall of all echoes over the field.
#[derive(Debug)]
pub struct Look(pub(crate) [[f32; 2]; 3]);

impl Look {
    /// Bone of any kind.
    pub const ANY: Look = Look([[6.0, 40.0], [-78.0, -36.0], [-2.0, 60.0]]);
    /// Bone brighter than most of the tissue.
    pub const CLEAR: Look = Look([[20.0, 40.0], [-78.0, -45.0], [-2.0, 25.0]]);
    /// Bone from that down to what hardly differs from tissue.
    pub const FAINT: Look = Look([[6.0, 30.0], [-70.0, -36.0], [5.0, 50.0]]);
}
