//! Usual names of the keys of channel data in files.
//!
//! If a key is not given and one array has a usual name of the key, this array is used, and the assumption is reported.

use crate::values::{NamedArrays, steps};
use crate::variables::{Given, KEYS, LAWS, Variables};

/// Other names of keys, without case and underscores.
const ALIASES: [(&str, &[&str]); 10] = [
    (
        "rf",
        &[
            "rfdata",
            "rawdata",
            "channeldata",
            "sig",
            "scat",
            "sensordata",
        ],
    ),
    ("iq", &["iqdata"]),
    ("f_demod", &["demodulationfrequency", "modulationfrequency"]),
    (
        "fs",
        &[
            "samplingfrequency",
            "samplingrate",
            "samplerate",
            "samplefrequency",
            "channeldatasamplingfrequency",
        ],
    ),
    (
        "f0",
        &[
            "fc",
            "centerfrequency",
            "centrefrequency",
            "centralfrequency",
        ],
    ),
    ("c", &["c0", "soundspeed", "speedofsound"]),
    (
        "t0",
        &["starttime", "initialtime", "tstart", "channeldatat0"],
    ),
    (
        "tx_angle",
        &["txangle", "txangles", "angle", "angles", "steeringangles"],
    ),
    ("tx_delay", &["txdelay", "txdelays"]),
    ("pitch", &[]),
];
/// Keys of which one is enough: the samples, the array, the delay law.
const ONE_OF: [&[&str]; 3] = [&["rf", "iq"], &["element_x", "pitch"], &LAWS];

/// The key that the last step of a path may mean.
fn meant(path: &str) -> Option<&'static str> {
    let steps = steps(path);
    let (last, _) = steps.last()?;
    let plain = |name: &str| name.replace('_', "").to_lowercase();
    let last = plain(last);
    let by_key = KEYS.into_iter().find(|key| plain(key) == last);
    by_key.or_else(|| {
        let row = ALIASES
            .iter()
            .find(|(_, names)| names.contains(&last.as_str()));
        row.map(|(key, _)| *key)
    })
}

/// Whether a key is given, or is the name of an array in the file.
pub fn is_given(source: &dyn NamedArrays, variables: &Variables, key: &str) -> bool {
    variables.get(key).is_some() || source.has(key)
}

/// Adds arrays with usual names to the variables; returns both, and what was added.
pub fn complete(source: &dyn NamedArrays, variables: &Variables) -> (Variables, Vec<String>) {
    let mut all = variables.clone();
    let mut assumed = Vec::new();
    let names = source.names();
    for key in KEYS {
        let group = ONE_OF.iter().find(|group| group.contains(&key));
        let group = group.copied().unwrap_or(std::slice::from_ref(&key));
        if group.iter().any(|key| is_given(source, &all, key)) {
            continue;
        }
        let takes_samples = ["rf", "iq"].contains(&key);
        let fits = |name: &&String| {
            let sides = source.sides(name).unwrap_or_default();
            let count = sides.iter().product::<usize>();
            meant(name) == Some(key)
                && count > 0
                && takes_samples == (sides.iter().filter(|&&side| side > 1).count() > 1)
                || key == "tx_delay" && meant(name) == Some(key) && count > 1
        };
        let mut found = names.iter().filter(fits);
        if let (Some(name), None) = (found.next(), found.next()) {
            all.insert(key, Given::Name(name.clone()));
            assumed.push(format!("{key} is the file's {name}"));
        }
    }
    (all, assumed)
}

/// Lists the arrays of a file with sides and possible keys, the largest first.
pub fn listed(source: &dyn NamedArrays) -> String {
    const MOST: usize = 20;
    let mut arrays: Vec<(String, Vec<usize>)> = source
        .names()
        .into_iter()
        .filter_map(|name| source.sides(&name).map(|sides| (name, sides)))
        .collect();
    let count = |sides: &[usize]| sides.iter().fold(1usize, |n, &side| n.saturating_mul(side));
    arrays.sort_by(|(a, x), (b, y)| count(y).cmp(&count(x)).then_with(|| a.cmp(b)));
    let largest = arrays.first().map_or(vec![], |(_, sides)| sides.clone());
    let more = arrays.len().saturating_sub(MOST);
    let mut names: Vec<String> = arrays
        .iter()
        .take(MOST)
        .enumerate()
        .map(|(position, (name, sides))| {
            let long: Vec<usize> = sides.iter().copied().filter(|&side| side > 1).collect();
            let shape: Vec<String> = sides.iter().map(usize::to_string).collect();
            let shape = match shape.is_empty() {
                true => "a number".into(),
                false => shape.join(" x "),
            };
            let role = match (meant(name), long.as_slice()) {
                (Some(key), _) => format!(", perhaps `{key}`"),
                (None, [_, _]) if position == 0 => ", perhaps `rf` or `lines`".into(),
                (None, [_, _, ..]) if position == 0 => ", perhaps `rf`".into(),
                (None, [side]) if largest.contains(side) => {
                    ", as long as an axis of the largest".into()
                }
                _ => String::new(),
            };
            format!("{name} ({shape}{role})")
        })
        .collect();
    if more > 0 {
        names.push(format!("and {more} more"));
    }
    match names.is_empty() {
        true => "none".into(),
        false => names.join(", "),
    }
}
