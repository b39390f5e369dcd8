//! Checks of a recording from its own echoes.
//!
//! [`check`] reads the first frame and changes nothing. It compares the echoes with the file's keys: samples, carrier,
//! order of elements and transmits, single elements, sound speed, time zero. Each result is a [`Finding`].

mod band;
mod base;
mod elements;
mod finding;
mod order;
mod samples;
mod speed;
mod table;
mod time;
mod transmits;
mod view;

use bonebeam_files::{ChannelData, Survey};

pub use finding::{Finding, Severity};
pub use time::Speed;

use base::Base;
use elements::Elements;
use speed::Speeds;
use table::Table;
use view::{LINES, View};

/// Transmits that [`doubt`] reads at most, unless each has a line of its own.
const FEW: usize = 8;
/// Elements from which it judges.
const LEAST: usize = 32;

/// All findings of a recording's first frame, the worst first.
#[must_use]
pub fn check(data: &ChannelData) -> Vec<Finding> {
    let chosen = view::chosen(data.transmits.len(), LINES);
    let view = View::new(data, &chosen);
    let keys = data.key_warnings().into_iter();
    let mut findings: Vec<Finding> = keys
        .map(|text| Finding::new("keys", Severity::Warning, text))
        .collect();
    let survey = data.samples.survey();
    let offset = data.offset(&survey).into_iter();
    findings.extend(offset.map(|text| Finding::new("offset-binary", Severity::Warning, text)));
    if survey.dead().len() == data.element_x.len() {
        let text = "every record is constant: nothing was received";
        findings.push(Finding::new("dead", Severity::Error, text));
        return findings;
    }
    findings.extend(samples::check(data, &survey));
    let power = survey.power();
    let (base, view, found) = band::check(data, &chosen, &view);
    findings.extend(found);
    let table = Table::new(&base, &view);
    let (view, table, found) = order::check(&base, (data, &chosen), view, table);
    findings.extend(found);
    let elements = Elements::new(&power, &view, &table);
    let speeds = speed::estimate(&base, &view, &elements.good);
    findings.extend(time::check(data, &base, &view, (&elements.good, &speeds)));
    // Single elements and transmits agree better where the delays of tissue before them are known.
    let aligned = speeds.filter(Speeds::is_sure).map(|speeds| speeds.view);
    let (view, table, elements) = match aligned {
        Some(view) => {
            let table = Table::new(&base, &view);
            let elements = Elements::new(&power, &view, &table);
            (view, table, elements)
        }
        None => (view, table, elements),
    };
    findings.extend(elements.check(&base, &power, &view, &table));
    findings.extend(transmits::check(data, &base, &view, &table));
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    findings
}

/// The findings of single elements by a few transmits, in a line; these cost little.
///
/// The survey is that of the data's samples.
#[must_use]
pub fn doubt(data: &ChannelData, survey: &Survey) -> Option<String> {
    let count = data.element_x.len();
    if count < LEAST || survey.dead().len() == count {
        return None;
    }
    let of = |most: usize| view::chosen(data.transmits.len(), most);
    let own = View::new(data, &of(LINES)).own;
    let chosen = of(if own { LINES } else { FEW });
    let view = View::new(data, &chosen);
    let base = Base::new(data, &chosen, data.f0, data.fs);
    let (table, power) = (Table::new(&base, &view), survey.power());
    let elements = Elements::new(&power, &view, &table);
    let findings = elements.check(&base, &power, &view, &table);
    let texts: Vec<&str> = findings.iter().map(|f| f.text.as_str()).collect();
    (!texts.is_empty()).then(|| format!("{}; see `host-sim check`", texts.join("; ")))
}

/// The sound speed of the echoes in a recording's first frame; `None` if they do not show it well.
#[must_use]
pub fn sound_speed(data: &ChannelData) -> Option<Speed> {
    let chosen = view::chosen(data.transmits.len(), LINES);
    let view = View::new(data, &chosen);
    let base = Base::new(data, &chosen, data.f0, data.fs);
    let power = data.samples.survey().power();
    let elements = Elements::new(&power, &view, &Table::new(&base, &view));
    let speeds = speed::estimate(&base, &view, &elements.good)?;
    speeds.is_sure().then(|| time::speed(data, &speeds))
}
