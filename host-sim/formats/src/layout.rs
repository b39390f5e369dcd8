//! Common layouts of programs, by their names on the command line.

/// Defines the layouts, one per row, with the name on the command line.
macro_rules! layouts {
    ($($(#[doc = $doc:literal])* $layout:ident, $name:literal;)*) => {
        /// A layout of arrays.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Layout {
            $($(#[doc = $doc])* $layout,)*
        }

        impl Layout {
            /// All layouts.
            pub const ALL: [Self; [$($name),*].len()] = [$(Layout::$layout),*];

            /// Its name on the command line.
            pub fn name(self) -> &'static str {
                match self {
                    $(Layout::$layout => $name,)*
                }
            }
        }
    };
}

layouts! {
    /// MUST and its f-k migration.
    ///
    /// RF [sample, element, transmit or frame] and a struct with `fs` and `pitch`.
    Must, "must";
    /// k-Wave: `sensor_data` [element, sample, transmit] and `dt`.
    KWave, "kwave";
    /// Field II, as `calc_scat_multi` writes it.
    ///
    /// `scat` [sample, element, transmit] and `start_time`.
    Field2, "field2";
    /// Plane waves of the CUBDL challenge: `channel_data` [transmit, element, sample].
    Cubdl, "cubdl";
    /// A Verasonics workspace: `RcvData`, `Receive`, `Trans`, `TX`, `Resource`.
    Verasonics, "verasonics";
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
