//! Sound speed, time zero and pitch as findings, with their effect in mm.

use std::fmt::{self, Display, Formatter};

use bonebeam_files::ChannelData;
use serde::Serialize;

use crate::base::Base;
use crate::finding::{Finding, Severity, drawn};
use crate::speed::{self, Speeds};
use crate::table::{Table, sureness};
use crate::view::View;

/// Standard deviations by which a speed and a time must differ from the file's, with a part of those of the gain in
/// coherence, and the least of these: a few points show a time that makes nothing sharper.
const SURE: [f64; 2] = [3.0, f64::NEG_INFINITY];
const SURE_LATE: [f64; 2] = [4.0, 2.0];
/// These parts of a gain and of a loss, and the most that a gain adds.
const GAIN: f64 = 0.5;
const LOSS: f64 = 1.5;
const MOST: f64 = 2.0;
/// Smallest difference of the sound speed that is reported, as a share.
const SPEED: f64 = 0.02;
/// Smallest time that is reported, s.
const LATE: f64 = 0.5e-6;
/// Sound speeds of tissue and water, m/s; beyond, the pitch is wrong.
const TISSUE: [f64; 2] = [1330.0, 1700.0];
/// Standard deviation of a sound speed above which it is too uncertain to be used, m/s.
const UNCERTAIN: f64 = 30.0;

impl Speeds {
    /// Whether the speed can be used: it is that of tissue, within a percent or two.
    pub fn is_sure(&self) -> bool {
        self.speed.deviation <= UNCERTAIN && plausible(self.speed.value)
    }
}

/// The sound speed that the echoes show.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Speed {
    /// m/s, the mean between the array and the echoes.
    pub value: f64,
    /// Interval of 95 %, m/s.
    pub interval: [f64; 2],
    /// By this much the file's speed draws an echo in the middle of the record too deep, mm; negative: too shallow.
    pub shift_mm: f64,
}

impl Display for Speed {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let [low, high] = self.interval;
        write!(
            f,
            "sound speed {:.0} m/s ({low:.0} to {high:.0}): by the file's, {}",
            self.value,
            drawn(self.shift_mm)
        )
    }
}

/// Depth of the record's middle, m.
fn middle(data: &ChannelData) -> f64 {
    let [first, last] = data.depths(data.c);
    (first + last) / 2.0
}

pub(crate) fn speed(data: &ChannelData, speeds: &Speeds) -> Speed {
    let value = speeds.speed.value;
    Speed {
        value,
        interval: speeds.speed.interval(),
        shift_mm: 1e3 * middle(data) * (data.c - value) / data.c,
    }
}

/// Findings of sound speed, pitch and time zero.
pub(crate) fn check(
    data: &ChannelData,
    base: &Base,
    view: &View,
    (good, speeds): (&[bool], &Option<Speeds>),
) -> Vec<Finding> {
    let Some(speeds) = speeds else {
        let text =
            "too few echoes are curved over the aperture: the sound speed cannot be measured";
        return vec![Finding::new("sound-speed", Severity::Note, text)];
    };
    let found = speed(data, speeds);
    let finding = |name, severity, text: String| Finding {
        value: Some(found.value),
        interval: Some(found.interval),
        unit: "m/s",
        shift_mm: Some(found.shift_mm),
        ..Finding::new(name, severity, text)
    };
    let (free, late) = (speeds.free, speeds.late);
    // One transmit a line has no path of its own.
    let times = if view.own { 2.0 } else { 1.0 };
    let focused = |c: f64, late: f64| {
        let mut view = view.clone();
        view.without = (0..good.len()).filter(|&m| !good[m]).collect();
        view.c = c;
        view.late -= late;
        Table::new(base, &view).focused()
    };
    let is_sure = |deviations: f64, [sure, least]: [f64; 2], [old, new]: [[f64; 2]; 2]| {
        let [old, new] = [old, new].map(|[c, late]| focused(c, late));
        let gain = sureness(&new, &old);
        gain > least && deviations + (GAIN * gain).min(MOST).min(LOSS * gain) > sure
    };
    // An estimate that starts from the found values finds them again.
    let again = |c: f64, late: f64| {
        let mut view = view.clone();
        view.c = c;
        view.late -= late;
        speed::estimate(base, &view, good).filter(Speeds::is_sure)
    };
    let same = |a: f64, b: f64, deviation: f64| (a - b).abs() < deviation;
    let with_late = [[found.value, 0.0], [free.value, late.value]];
    if late.value.abs() > LATE
        && plausible(free.value)
        && is_sure(
            late.value.abs() / (times * late.deviation),
            SURE_LATE,
            with_late,
        )
        && again(free.value, late.value).is_some_and(|s| same(s.late.value, 0.0, late.deviation))
    {
        let text = format!(
            "echoes come {:.2} us later than the file's times, if the sound speed is the same at all depths \
             (then {:.0} m/s); `t0` and `lens_delay` cannot be told apart",
            1e6 * late.value,
            free.value
        );
        let shift = 1e3 * data.c * late.value / 2.0;
        let interval = late.interval().map(|late| 1e6 * late);
        return vec![
            Finding {
                interval: Some(interval),
                shift_mm: Some(-shift),
                ..Finding::new("time-zero", Severity::Warning, text).valued(1e6 * late.value, "us")
            }
            .remedy("add it to t0"),
        ];
    }
    let beyond = (TISSUE[0] - found.value).max(found.value - TISSUE[1]);
    let with_speed = [[data.c, 0.0], [found.value, 0.0]];
    if beyond > SPEED * data.c && is_sure(beyond / speeds.speed.deviation, SURE, with_speed) {
        let pitch = data.pitch() * data.c / found.value;
        let text = format!(
            "the curvature of echoes fits {:.0} m/s, which is not tissue, or a pitch of {:.4} mm and not {:.4} mm",
            found.value,
            1e3 * pitch,
            1e3 * data.pitch()
        );
        return vec![finding("pitch", Severity::Error, text).remedy("element_x, or fs, t0 and c")];
    }
    if speeds.speed.deviation > UNCERTAIN {
        return vec![finding(
            "sound-speed",
            Severity::Note,
            "the echoes do not show the sound speed well".into(),
        )];
    }
    let off = found.value - data.c;
    let is_off = off.abs() > SPEED * data.c;
    let deviation = speeds.speed.deviation;
    let is_found =
        || again(found.value, 0.0).is_some_and(|s| same(s.speed.value, found.value, deviation));
    if !(is_off && is_sure(off.abs() / deviation, SURE, with_speed) && is_found()) {
        let text = match (found.interval[0]..=found.interval[1]).contains(&data.c) {
            true => "the echoes agree with the file's sound speed".into(),
            false => format!(
                "the echoes show {:.0} m/s beside the file's {:.0}, which is too little to be sure of",
                found.value, data.c
            ),
        };
        return vec![finding("sound-speed", Severity::Note, text)];
    }
    let text = format!(
        "the echoes have another sound speed than the file's {:.0} m/s",
        data.c
    );
    vec![
        finding("sound-speed", Severity::Warning, text)
            .remedy(format!("--sound-speed {:.0}", found.value)),
    ]
}

fn plausible(speed: f64) -> bool {
    (TISSUE[0]..=TISSUE[1]).contains(&speed)
}
