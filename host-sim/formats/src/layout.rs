//! Common layouts of programs, by their names on the command line.

use bonebeam_files::choice;

choice! {
    /// A layout of arrays, by its name on the command line.
    Layout {
        /// MUST and its f-k migration.
        ///
        /// RF [sample, element, transmit or frame] and a struct with `fs` and `pitch`.
        Must = "must",
        /// k-Wave: `sensor_data` [element, sample, transmit] and `dt`.
        KWave = "kwave",
        /// Field II, as `calc_scat_multi` writes it.
        ///
        /// `scat` [sample, element, transmit] and `start_time`.
        Field2 = "field2",
        /// Plane waves of the CUBDL challenge: `channel_data` [transmit, element, sample].
        Cubdl = "cubdl",
        /// A Verasonics workspace: `RcvData`, `Receive`, `Trans`, `TX`, `Resource`.
        Verasonics = "verasonics",
    }
}

impl Layout {
    /// The order of the axes of the samples.
    pub fn axes(self) -> [&'static str; 2] {
        match self {
            Layout::KWave | Layout::Cubdl => ["element", "sample"],
            _ => ["sample", "element"],
        }
    }
}
