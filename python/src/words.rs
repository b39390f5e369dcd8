//! The host's messages with Python's keywords instead of the command's flags.

/// Replaces flags by keywords in a message.
///
/// `--beta` becomes `` `beta` ``, `--variable f0=5e6` an entry of `variables`.
pub fn in_python(message: &str) -> String {
    let message = message
        .replace(" in [variables] (--variable)", " in `variables`")
        .replace(" (--iq-conjugate)", " in `variables`")
        .replace("[variables]", "`variables`")
        .replace("see --help", "see docs/file-formats.md");
    let mut rest = message.as_str();
    let mut text = String::new();
    while let Some(at) = flag(rest) {
        text.push_str(&rest[..at]);
        rest = &rest[at + 2..];
        let end = rest.find(|c: char| !c.is_ascii_lowercase() && c != '-');
        let (name, after) = rest.split_at(end.unwrap_or(rest.len()));
        let key = name.replace('-', "_");
        rest = after;
        match name {
            "variable" => {
                let mut entries = vec![];
                entries.extend(entry(&mut rest));
                while let Some(after) = rest.strip_prefix(" --variable") {
                    rest = after;
                    entries.extend(entry(&mut rest));
                }
                text.push_str(&dict(&entries));
            }
            "layout" | "track" => {
                let named = word(&mut rest).map(|word| format!("\"{name}\": \"{word}\""));
                text.push_str(&dict(named.as_slice()));
            }
            "iq-conjugate" => text.push_str("`variables={\"iq_conjugate\": 1}`"),
            _ => {
                text.push_str(&format!("`{key}`"));
                // The command names the key and its section beside the flag.
                let section = rest
                    .strip_prefix(&format!(" (`{key}` in ["))
                    .and_then(|rest| rest.split_once("])"));
                rest = section.map_or(rest, |(_, after)| after);
            }
        }
    }
    text + rest
}

/// Index of the next flag.
fn flag(text: &str) -> Option<usize> {
    let begins = |&(at, _): &(usize, &str)| {
        let before = text[..at].chars().next_back();
        let after = text[at + 2..].chars().next();
        before.is_none_or(|c| " (`".contains(c)) && after.is_some_and(|c| c.is_ascii_lowercase())
    };
    text.match_indices("--").find(begins).map(|(at, _)| at)
}

/// The next word, without the punctuation after it.
fn word<'a>(rest: &mut &'a str) -> Option<&'a str> {
    let after = rest.strip_prefix(' ')?;
    let end = after.find(' ').unwrap_or(after.len());
    let word = after[..end].trim_end_matches([',', ';', '.', ')', ':']);
    *rest = &after[word.len()..];
    Some(word)
}

/// An entry of a dict, from `KEY=VALUE`.
fn entry(rest: &mut &str) -> Option<String> {
    let before = *rest;
    let Some((key, value)) = word(rest).and_then(|word| word.split_once('=')) else {
        *rest = before;
        return None;
    };
    let literal = |value: &str| {
        // A number, or a word for a number, is not in quotes.
        let is_open = value
            .chars()
            .all(|c| c.is_ascii_uppercase() || c == '_' || c == '…');
        match is_open || value.parse::<f64>().is_ok() {
            true => value.to_owned(),
            false => format!("\"{value}\""),
        }
    };
    let values: Vec<String> = value.split(',').map(literal).collect();
    let values = match values.as_slice() {
        [one] => one.clone(),
        several => format!("[{}]", several.join(", ")),
    };
    Some(format!("\"{key}\": {values}"))
}

fn dict(entries: &[String]) -> String {
    match entries.is_empty() {
        true => "`variables`".to_owned(),
        false => format!("`variables={{{}}}`", entries.join(", ")),
    }
}
