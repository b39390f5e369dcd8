//! The flags of the core's parameters, from the core's table.

use bonebeam::beamform::{Apodization, Parameter, Parameters, Postfilter};
use bonebeam_drive::config::{ALIASES, APODIZATION, POSTFILTER};
use bonebeam_files::terminal::short;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser, ValueParser};
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches};

/// The flags of the core's parameters that were given.
#[derive(Debug, Default)]
pub(super) struct CoreFlags {
    values: Vec<(&'static str, f64)>,
    postfilter: Option<Postfilter>,
    apodization: Option<Apodization>,
}

impl CoreFlags {
    /// Whether the flag of a parameter was given.
    pub(super) fn has(&self, name: &str) -> bool {
        self.values.iter().any(|(given, _)| *given == name)
    }

    pub(super) fn apply(&self, parameters: &mut Parameters) {
        for &(name, value) in &self.values {
            parameters.set(name, value).expect("a row of the table");
        }
        parameters.postfilter = self.postfilter.unwrap_or(parameters.postfilter);
        parameters.apodization = self.apodization.unwrap_or(parameters.apodization);
    }
}

impl Args for CoreFlags {
    fn augment_args(command: Command) -> Command {
        let rows = Parameters::TABLE.map(|row| {
            let aliases = ALIASES.iter().filter(|(_, name)| *name == row.name);
            let parser = match row.whole {
                true => ValueParser::new(|text: &str| text.parse::<usize>().map(|n| n as f64)),
                false => ValueParser::new(|text: &str| text.parse::<f64>()),
            };
            flag(row.name, parser)
                .aliases(aliases.map(|(alias, _)| alias.replace('_', "-")))
                .value_name(if row.whole { "N" } else { "X" })
                .help(format!(
                    "{}; {} [default: {}]",
                    row.help.trim().trim_end_matches('.').replace('\n', ""),
                    row.range.text,
                    short(row.default)
                ))
        });
        let values = Postfilter::EXAMPLES
            .map(|postfilter| PossibleValue::new(postfilter.key()).help(postfilter.help()));
        let parser = PossibleValuesParser::new(values).map(|key| postfilter(&key));
        let postfilter = flag(POSTFILTER, ValueParser::new(parser))
            .help("Postfilter: a factor on the beamformer's output [default: none]");
        let values = Apodization::EXAMPLES
            .map(|window| PossibleValue::new(window.key()).help(window.help()));
        let parser = PossibleValuesParser::new(values).map(|key| apodization(&key));
        let apodization = flag(APODIZATION, ValueParser::new(parser)).help(
            "Receive weights of the elements of das, or of the subapertures of other methods [default: none]",
        );
        command.args(rows).args([postfilter, apodization])
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for CoreFlags {
    fn from_arg_matches(matches: &ArgMatches) -> std::result::Result<Self, clap::Error> {
        let given = |row: Parameter| Some((row.name, *matches.get_one::<f64>(row.name)?));
        Ok(CoreFlags {
            values: Parameters::TABLE.into_iter().filter_map(given).collect(),
            postfilter: matches.get_one(POSTFILTER).copied().flatten(),
            apodization: matches.get_one(APODIZATION).copied().flatten(),
        })
    }

    fn update_from_arg_matches(
        &mut self,
        matches: &ArgMatches,
    ) -> std::result::Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

fn flag(key: &'static str, parser: ValueParser) -> Arg {
    Arg::new(key)
        .long(key.replace('_', "-"))
        .value_parser(parser)
        .help_heading("Beamformer")
}

/// The postfilter of a key.
fn postfilter(key: &str) -> Option<Postfilter> {
    let mut all = Postfilter::EXAMPLES.into_iter();
    all.find(|postfilter| postfilter.key() == key)
}

/// The apodization of a key.
fn apodization(key: &str) -> Option<Apodization> {
    let mut all = Apodization::EXAMPLES.into_iter();
    all.find(|apodization| apodization.key() == key)
}
