//! The core's parameters in the section `[beamform]`: keys, flags and ranges from the core's table.
//!
//! A row of [`Parameters::TABLE`] is a key, a flag and a range here without being named. So is the postfilter.

use std::borrow::Cow;
use std::fmt;

use bonebeam::Error as Refused;
use bonebeam::beamform::{Parameter, Parameters, Postfilter};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser, ValueParser};
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches};
use serde::de::value::{CowStrDeserializer, MapAccessDeserializer};
use serde::de::{DeserializeSeed, MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::Beamform;
use crate::Result;
use bonebeam_files::settings::out_of_range;
use bonebeam_files::terminal::short;

/// The key of the postfilter.
const POSTFILTER: &str = "postfilter";
/// Former names of keys and flags.
const ALIASES: [(&str, &str); 3] = [
    ("temporal", "temporal_half_window"),
    ("loading", "diagonal_loading"),
    ("subarray_ratio", "subaperture_ratio"),
];

/// The row of a key.
fn row(key: &str) -> Option<&'static Parameter> {
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

impl Serialize for Beamform {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Section<'a> {
            #[serde(flatten)]
            host: Host<'a>,
            #[serde(flatten)]
            core: Core<'a>,
        }
        let section = Section {
            host: Host(self),
            core: Core(&self.core),
        };
        section.serialize(serializer)
    }
}

struct Host<'a>(&'a Beamform);

impl Serialize for Host<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        Beamform::serialize(self.0, serializer)
    }
}

struct Core<'a>(&'a Parameters);

impl Serialize for Core<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry(POSTFILTER, self.0.postfilter.key())?;
        for (row, value) in Parameters::TABLE.into_iter().zip(self.0.values()) {
            match row.whole {
                true => map.serialize_entry(row.name, &(value as u64))?,
                false => map.serialize_entry(row.name, &plain(value))?,
            }
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for Beamform {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        deserializer.deserialize_map(Section)
    }
}

struct Section;

impl<'de> Visitor<'de> for Section {
    type Value = Beamform;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a section of keys")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> std::result::Result<Beamform, A::Error> {
        let mut core = Parameters::DEFAULT;
        let others = Others {
            map,
            core: &mut core,
        };
        let section = Beamform::deserialize(MapAccessDeserializer::new(others))?;
        Ok(Beamform { core, ..section })
    }
}

/// The entries of a map that are not the core's; those go to `core` on the way.
struct Others<'a, A> {
    map: A,
    core: &'a mut Parameters,
}

impl<'de, A: MapAccess<'de>> MapAccess<'de> for Others<'_, A> {
    type Error = A::Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> std::result::Result<Option<K::Value>, A::Error> {
        let mut seed = Some(seed);
        while let Some(key) = self.map.next_key_seed(KeySeed(&mut seed))? {
            match key {
                Key::Other(key) => return Ok(Some(key)),
                Key::Postfilter => self.core.postfilter = self.map.next_value()?,
                Key::Row(row) => {
                    let value = match row.whole {
                        true => self.map.next_value::<usize>()? as f64,
                        false => self.map.next_value()?,
                    };
                    self.core.set(row.name, value).expect("a row of the table");
                }
            }
        }
        Ok(None)
    }

    fn next_value_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> std::result::Result<T::Value, A::Error> {
        self.map.next_value_seed(seed)
    }
}

enum Key<T> {
    Row(&'static Parameter),
    Postfilter,
    Other(T),
}

/// Reads a key; one that is not the core's by the seed within.
struct KeySeed<'a, K>(&'a mut Option<K>);

impl<'de, K: DeserializeSeed<'de>> DeserializeSeed<'de> for KeySeed<'_, K> {
    type Value = Key<K::Value>;

    fn deserialize<D: Deserializer<'de>>(
        self,
        deserializer: D,
    ) -> std::result::Result<Self::Value, D::Error> {
        let key = Cow::<str>::deserialize(deserializer)?;
        if let Some(row) = row(&key) {
            return Ok(Key::Row(row));
        }
        if key == POSTFILTER {
            return Ok(Key::Postfilter);
        }
        let seed = self.0.take().expect("one key of another kind at a time");
        let key = seed.deserialize(CowStrDeserializer::new(key))?;
        Ok(Key::Other(key))
    }
}
