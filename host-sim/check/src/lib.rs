//! Checks of a recording from its own echoes.
//!
//! [`check`] reads the first frame and changes nothing. It compares the echoes with the file's keys: samples, carrier,
//! order of elements and transmits, single elements, sound speed, time zero. Each result is a [`Finding`].

mod base;
mod elements;
mod finding;
mod order;
mod samples;
mod speed;
mod table;
mod time;

use bonebeam_files::ChannelData;

pub use finding::{Finding, Severity};
pub use time::Speed;

use elements::Elements;
use table::{Table, View};

/// All findings of a recording's first frame, the worst first.
#[must_use]
pub fn check(data: &ChannelData) -> Vec<Finding> {
    let chosen = table::chosen(data.transmits.len());
    let view = View::new(data, &chosen);
    let keys = data.key_warnings().into_iter();
    let mut findings: Vec<Finding> = keys
        .map(|text| Finding::new("keys", Severity::Warning, text))
        .collect();
    let offset = data.offset().into_iter();
    findings.extend(offset.map(|text| Finding::new("offset-binary", Severity::Warning, text)));
    if data.samples.dead().len() == data.element_x.len() {
        let text = "every record is constant: nothing was received";
        findings.push(Finding::new("dead", Severity::Error, text));
        return findings;
    }
    findings.extend(samples::check(data));
    let (base, view, found) = order::band(data, &chosen, &view);
    findings.extend(found);
    let table = Table::new(&base, &view);
    let (view, table, found) =
        order::check(&base, view, table, chosen.len() == data.transmits.len());
    findings.extend(found);
    let elements = Elements::new(&base, &view, &table);
    findings.extend(elements.check(&base, &view, &table));
    findings.extend(order::transmits(data, &base, &view, &table));
    findings.extend(time::check(data, &base, &view, &elements.good));
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    findings
}

/// The sound speed of the echoes in a recording's first frame; `None` if they do not show it well.
#[must_use]
pub fn sound_speed(data: &ChannelData) -> Option<Speed> {
    let chosen = table::chosen(data.transmits.len());
    let view = View::new(data, &chosen);
    let base = base::Base::new(data, &chosen, data.f0, data.fs);
    let elements = Elements::new(&base, &view, &Table::new(&base, &view));
    let speeds = speed::estimate(&base, &view, &elements.good)?;
    speeds.is_sure().then(|| time::speed(data, &speeds))
}
