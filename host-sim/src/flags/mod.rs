//! Flags of a section: one for each of its keys.

mod simulate;

pub use simulate::SimulateFlags;

use std::fmt;
use std::marker::PhantomData;

use bonebeam_files::section::{Key, Section, Value};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser, ValueParser};
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};

/// The flags of a section that were given.
pub struct Flags<S> {
    given: Vec<(Key, String)>,
    section: PhantomData<S>,
}

impl<S: Section> Flags<S> {
    /// The flags that were given, under their headings in `--help`.
    pub fn given(&self) -> impl Iterator<Item = (&str, &str)> {
        self.given
            .iter()
            .map(|(key, _)| (key.flag.as_str(), key.heading))
    }

    /// Whether a flag was given.
    pub fn has(&self, flag: &str) -> bool {
        self.given().any(|(given, _)| given == flag)
    }

    /// Sets the section's values to those of the flags.
    ///
    /// Keys of the section that contradict a flag become their defaults.
    pub fn apply(&self, section: &mut S) {
        for (key, text) in &self.given {
            let before = section.clone();
            section.set(&key.name, text);
            if !key.row.if_changed || *section != before {
                key.row
                    .replaces
                    .iter()
                    .for_each(|replaced| section.reset(replaced));
            }
        }
        self.given
            .iter()
            .for_each(|(key, text)| section.set(&key.name, text));
    }
}

impl<S> fmt::Debug for Flags<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list()
            .entries(self.given.iter().map(|(key, text)| (&key.flag, text)))
            .finish()
    }
}

/// The parser of a choice.
pub fn choice<T: Value + Clone + Send + Sync + 'static>() -> impl TypedValueParser<Value = T> {
    names(T::choices()).try_map(|name| T::read(&name))
}

fn names(choices: Vec<[&'static str; 2]>) -> PossibleValuesParser {
    let values = choices
        .into_iter()
        .map(|[name, help]| PossibleValue::new(name).help(help));
    PossibleValuesParser::new(values)
}

/// The keys that have flags.
fn keys<S: Section>() -> impl Iterator<Item = Key> {
    S::keys().into_iter().filter(|key| !key.flag.is_empty())
}

/// The flag of a key.
fn flag(key: Key) -> Arg {
    let aliases = key.aliases.iter().map(|alias| alias.replace('_', "-"));
    let aliases: Vec<String> = aliases.filter(|alias| *alias != key.flag).collect();
    let arg = Arg::new(key.flag.clone())
        .long(key.flag)
        .aliases(aliases)
        .conflicts_with_all(key.row.excludes);
    let arg = match key.more.is_empty() {
        true => arg.help(key.help),
        false => arg
            .long_help(format!("{}\n\n{}", key.help, key.more))
            .help(key.help),
    };
    let arg = match key.heading {
        "" => arg,
        heading => arg.help_heading(heading),
    };
    if key.switch {
        return arg.action(ArgAction::SetTrue);
    }
    let arg = arg.value_name(key.placeholder);
    let check = key.check;
    match (key.choices.is_empty(), key.list) {
        (false, _) => arg.value_parser(names(key.choices)),
        (true, false) => arg.value_parser(checked(check)),
        (true, true) => arg
            .value_delimiter(',')
            .action(ArgAction::Append)
            .value_parser(checked(check)),
    }
}

fn checked(check: fn(&str) -> Result<(), String>) -> ValueParser {
    ValueParser::new(move |text: &str| check(text).map(|()| text.to_owned()))
}

impl<S: Section> Args for Flags<S> {
    fn augment_args(command: Command) -> Command {
        command.args(keys::<S>().map(flag))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<S: Section> FromArgMatches for Flags<S> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let given = |key: Key| {
            let text = match key.switch {
                true => matches.get_flag(&key.flag).then(|| "true".to_owned()),
                false => {
                    let texts = matches.get_many::<String>(&key.flag);
                    texts.map(|texts| texts.map(String::as_str).collect::<Vec<_>>().join(","))
                }
            };
            text.map(|text| (key, text))
        };
        Ok(Flags {
            given: keys::<S>().filter_map(given).collect(),
            section: PhantomData,
        })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}
