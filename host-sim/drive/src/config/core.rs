//! The core's parameters in the section `[beamform]`: keys, flags and ranges from the core's table.
//!
//! A row of [`Parameters::TABLE`] is a key, a flag and a range here without being named. So is the postfilter.

use bonebeam::Error as Refused;
use bonebeam::beamform::{Parameter, Parameters, Postfilter};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser, ValueParser};
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches};

use crate::Result;
use bonebeam_files::settings::out_of_range;
use bonebeam_files::terminal::short;

/// The key of the postfilter.
pub(super) const POSTFILTER: &str = "postfilter";
/// Former names of keys and flags.
const ALIASES: [(&str, &str); 3] = [
    ("temporal", "temporal_half_window"),
    ("loading", "diagonal_loading"),
    ("subarray_ratio", "subaperture_ratio"),
];

/// The row of a key.
pub(super) fn row(key: &str) -> Option<&'static Parameter> {
    const TABLE: &[Parameter] = &Parameters::TABLE;
    let alias = ALIASES.iter().find(|(alias, _)| *alias == key);
    let name = alias.map_or(key, |(_, name)| name);
    TABLE.iter().find(|row| row.name == name)
}

/// A number of the core as a person writes it: 0.05, not the f32 that is nearest to it.
pub(crate) fn plain(value: f64) -> f64 {
    let narrow = value as f32;
    let shortest = || narrow.to_string().parse().unwrap_or(value);
    if f64::from(narrow) == value {
        shortest()
    } else {
        value
    }
}

/// Checks the method's argument and the rows of the core's table.
///
/// # Errors
/// [`crate::Error::Usage`] naming the flag, the key, the value and the range.
pub(super) fn check_rows(section: &str, parameters: &Parameters) -> Result<()> {
    let method = parameters.method;
    let rows = Parameters::TABLE.into_iter().zip(parameters.values());
    for (row, value) in method
        .parameter()
        .zip(method.argument())
        .into_iter()
        .chain(rows)
    {
        if let Err(Refused::Parameter { expected, .. }) = row.check(value) {
            return Err(out_of_range(section, row.name, plain(value), expected));
        }
    }
    Ok(())
}

/// The flags of the core's parameters that were given.
#[derive(Debug, Default)]
pub(super) struct CoreFlags {
    values: Vec<(&'static str, f64)>,
    postfilter: Option<Postfilter>,
}

impl CoreFlags {
    pub(super) fn apply(&self, parameters: &mut Parameters) {
        for &(name, value) in &self.values {
            parameters.set(name, value).expect("a row of the table");
        }
        parameters.postfilter = self.postfilter.unwrap_or(parameters.postfilter);
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
        command.args(rows).arg(
            flag(POSTFILTER, ValueParser::new(parser))
                .help("The factor that multiplies the beamformer's output [default: none]"),
        )
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
