//! The bone surface in plain loops.
//!
//! Every mean is a separate sum, and every path is found by trying all preceding cells.

use bonebeam::surface::{Levels, Parameters, Point, Ramp, weights};

/// The searched cells of a line, and their positions.
struct Cells {
    stride: usize,
    length: f64,
    count: usize,
    first: usize,
    searched: usize,
}

fn cells(p: &Parameters) -> Cells {
    let mut stride = 1;
    while stride as f64 * p.samples.step < p.settings.cell * (1.0 - 1e-9) {
        stride += 1;
    }
    let length = stride as f64 * p.samples.step;
    let count = p.samples.count / stride;
    let at = |depth: f64| ((depth - p.samples.first) / length + 0.5).max(0.0) as usize;
    let near = (p.settings.near[1] / length + 0.5) as usize;
    let end = at(p.settings.depths[1]).min(count - near);
    let first = at(p.settings.depths[0]);
    Cells {
        stride,
        length,
        count,
        first,
        searched: end - first,
    }
}

/// Sum of the grey levels of the existing cells of `from..end`, and their samples' number.
fn sum(line: &[u8], cells: &Cells, from: i64, end: i64) -> (i64, i64) {
    let count = cells.count as i64;
    let (from, end) = (from.clamp(0, count) as usize, end.clamp(0, count) as usize);
    let samples = cells.stride * from..cells.stride * end.max(from);
    let length = samples.len() as i64;
    (line[samples].iter().map(|&g| i64::from(g)).sum(), length)
}

/// `⌊1024·ln(value)⌉`, apart from the table's step.
fn ln(value: i64) -> i64 {
    let exponent = 63 - i64::from(value.leading_zeros());
    let sixtyfourths = (((value << 24) >> exponent) >> 18) & 63;
    let mantissa = libm::log(1.0 + (sixtyfourths as f64 + 0.5) / 64.0);
    710 * exponent + (1024.0 * mantissa).round() as i64
}

fn ramp(x: i64, centre: i64, gain: i64, limit: i64) -> i64 {
    (((x - centre) * gain) >> 12).clamp(-limit, limit)
}

/// Slope of a ramp, in 2⁻¹² of a score over the range of `x` from 0 to 1.
fn slope(ramp: &Ramp) -> f64 {
    ramp.weight / ramp.width * 1024.0 * 4096.0
}

/// The ramp of a grey level, in 1/16 of one.
fn grey_ramp(x: i64, term: &Ramp) -> i64 {
    let centre = (term.centre * WHITE).round() as i64;
    let gain = (slope(term) / WHITE).round() as i64;
    ramp(x, centre, gain, nats(term.weight.abs()))
}

const WHITE: f64 = 4080.0;

fn nats(value: f64) -> i64 {
    (1024.0 * value).round() as i64
}

/// The score of an echo by the network, in 1/1024 nat, from the means around it.
fn network(means: &[i64], [dark, tissue, bright]: [i64; 3]) -> i64 {
    let log = |level: i64| ln(level + 64);
    let logs = means.iter().map(|&mean| log(mean) - log(means[0]));
    let of_frame = [log(dark) - log(bright), log(tissue) - log(bright)];
    let mut inputs: Vec<i64> = logs.chain(of_frame).collect();
    inputs[0] = log(means[0]) - log(bright);
    let inputs: Vec<i64> = (0..inputs.len())
        .map(|k| {
            ((inputs[k] - i64::from(weights::CENTRES[k])) * i64::from(weights::GAINS[k])) >> 12
        })
        .map(|input| input.clamp(-192, 192))
        .collect();
    let hidden = weights::WEIGHTS
        .iter()
        .zip(weights::BIASES)
        .map(|(unit, bias)| {
            let sum: i64 = unit
                .iter()
                .zip(&inputs)
                .map(|(&w, x)| i64::from(w) * x)
                .sum();
            (sum + i64::from(bias)).max(0) >> 8
        });
    let output: i64 = hidden
        .zip(weights::OUTPUT)
        .map(|(unit, w)| unit * i64::from(w))
        .sum();
    ((output + i64::from(weights::OUTPUT_BIAS)) >> 8).clamp(-4096, 6040)
}

/// The scores of the learnt model.
fn learnt(p: &Parameters, line: &[u8], levels: Levels) -> Vec<i64> {
    let cells = cells(p);
    let (first, count) = (cells.first as i64, cells.searched as i64);
    let of = |length: f64| ((1e-3 * length / cells.length + 0.5) as i64).min(1 << 20);
    let least = |length: f64| of(length).max(1);
    let mean = |from: i64, end: i64| {
        let from = from.clamp(0, cells.count as i64 - 1);
        let end = end.min(cells.count as i64).max(from + 1);
        let (sum, samples) = sum(line, &cells, from, end);
        16 * sum / samples
    };
    let echo = |cell: i64| mean(cell - least(0.2), cell + least(0.2) + 1);
    let echoes: Vec<i64> = (first..first + count).map(echo).collect();
    let brightest = |cells: std::ops::Range<i64>| {
        let cells = cells.start.max(0)..cells.end.min(count);
        cells.map(|k| echoes[k as usize]).max().unwrap_or(0)
    };
    let below = [
        (0.3, 0.6),
        (0.5, 1.0),
        (1.0, 2.0),
        (2.0, 4.0),
        (4.0, 8.0),
        (8.0, 16.0),
    ];
    let [dark, tissue, bright] = [levels.dark, levels.tissue, levels.bright].map(i64::from);
    let dark = dark.min((tissue - 16 * 56).max(16 * 13));
    let length = least(1.0);
    let score = |k: i64| {
        let (level, cell) = (echoes[k as usize], first + k);
        let blocks = cell + least(1.5)..=cells.count as i64 - length;
        let block = blocks.map(|at| mean(at, at + length)).max().unwrap_or(0);
        let neighbours = least(0.4);
        let is_echo = level >= dark + 48
            && 5 * (block + 64) <= 4 * (level + 64)
            && brightest(k - neighbours..k) <= level
            && (k + 1 >= count || brightest(k + 1..k + 1 + neighbours) < level);
        if !is_echo {
            return None;
        }
        let around = |from: i64, end: i64| mean(cell + from, cell + end);
        let mut means = vec![level];
        means.push(around(-of(0.1), of(0.1) + 1));
        means.push(around(-least(0.5), least(0.5) + 1));
        means.extend(below.map(|(near, far)| around(of(near), of(far))));
        means.extend(
            below[..5]
                .iter()
                .map(|&(near, far)| around(1 - of(far), 1 - of(near))),
        );
        means.push(mean(cell + least(1.5), i64::MAX / 2));
        means.push(mean(0, cell + 1 - least(0.5)));
        means.push(block);
        means.push(brightest(k + length..count));
        means.push(brightest(0..k - length + 1));
        means.push(brightest(0..count));
        Some(network(&means, [dark, tissue, bright]))
    };
    let own: Vec<Option<i64>> = (0..count).map(score).collect();
    let at = |k: i64| usize::try_from(k).ok().and_then(|k| *own.get(k)?);
    let best = |k: i64| {
        let beside = [at(k - 1), at(k + 1)].map(|score| score.map(|score| score - 717));
        beside
            .into_iter()
            .chain([at(k)])
            .flatten()
            .fold(-4096, i64::max)
    };
    (0..count).map(best).collect()
}

/// The scores of a line's cells from the first searched one, in 1/1024 nat.
pub fn scores(p: &Parameters, line: &[u8], levels: Levels) -> Vec<i64> {
    if p.settings.learnt {
        return learnt(p, line, levels);
    }
    let s = &p.settings;
    let cells = cells(p);
    let of = |length: f64| (length / cells.length + 0.5) as i64;
    // 2²³ times the mean of cells a to b, from a cell.
    let mean = |cell: i64, a: i64, b: i64| {
        let (sum, samples) = sum(line, &cells, cell + a, cell + b + 1);
        if samples == 0 {
            0
        } else {
            sum * ((1 << 23) / samples)
        }
    };
    let dark = i64::from(levels.dark);
    let least = (s.shadow_range * WHITE).round() as i64;
    let range = (i64::from(levels.tissue) - dark).max(least);
    let shadow_gain = (slope(&s.shadow).round() as i64 / range).clamp(-131_071, 131_071);
    let shadow_centre = dark + (((256.0 * s.shadow.centre).round() as i64 * range) >> 8);
    let floor = (s.onset_floor * WHITE * WHITE + 0.5) as i64;
    let scores = (cells.first..cells.first + cells.searched).map(|cell| {
        let cell = cell as i64;
        let echo = mean(cell, -of(s.echo), of(s.echo));
        let near = mean(cell, of(s.near[0]), of(s.near[1]));
        let far = mean(cell, of(s.far[0]), of(s.far[1]));
        let above = mean(cell, -of(s.above[1]), -of(s.above[0]));
        let below = mean(cell, of(s.below[0]), of(s.below[1]));
        let (total, samples) = sum(line, &cells, cell + of(s.shadow_from), cells.count as i64);
        let shadow = 16 * total / samples.max(1);
        let onset = ((echo - near) >> 19).max(0) * ((echo - far) >> 19).max(0);
        let onset = ln(onset + floor) - ln(4080 * 4080);
        let contrast = grey_ramp((echo - above) >> 19, &s.contrast);
        let margin = (s.margin * WHITE).round() as i64;
        let reference = above.max(echo - (margin << 19));
        let level = grey_ramp((reference - below) >> 19, &s.level);
        let block = of(s.rest_block).max(1);
        let last = cells.count as i64 - block;
        let from = (cell + of(s.rest_from)).min(last);
        let rest = (from..=last).map(|at| mean(at, 0, block - 1) >> 19).max();
        let rest = grey_ramp((reference >> 19) - rest.unwrap_or(0), &s.rest);
        let shadow = ramp(
            shadow,
            shadow_centre,
            shadow_gain,
            nats(s.shadow.weight.abs()),
        );
        ((onset * nats(s.onset_weight)) >> 10) + contrast + level + rest + shadow
    });
    scores.collect()
}

/// The terms of coherence of a line's cells, in 1/1024 nat.
///
/// They begin at the first searched cell.
pub fn coherence_term(p: &Parameters, coherence: &[u8]) -> Vec<i64> {
    let (term, [from, to]) = (&p.settings.coherence, p.settings.below);
    let cells = cells(p);
    let of = |length: f64| (length / cells.length + 0.5) as i64;
    let of_cell = |cell: usize| {
        let cell = cell as i64;
        let (sum, samples) = sum(coherence, &cells, cell + of(from), cell + of(to) + 1);
        let mean = sum * (1_i64 << 23).checked_div(samples).unwrap_or(0);
        grey_ramp(mean >> 19, term)
    };
    (cells.first..cells.first + cells.searched)
        .map(of_cell)
        .collect()
}

/// The frame's levels, from every fourth line that is not black.
pub fn levels(p: &Parameters, frame: &[u8]) -> Levels {
    let cells = cells(p);
    let (mut grey, mut shadows) = (Vec::new(), Vec::new());
    let lines = frame.chunks(p.samples.count).step_by(4);
    for line in lines.filter(|line| line.iter().any(|&g| g > 0)) {
        grey.extend(
            line[..cells.stride * cells.count]
                .iter()
                .map(|&g| i64::from(g)),
        );
        for cell in cells.first..cells.first + cells.searched {
            let from = cell as i64 + (p.settings.shadow_from / cells.length + 0.5) as i64;
            let (sum, samples) = sum(line, &cells, from, cells.count as i64);
            if samples > 0 {
                shadows.push(sum / samples);
            }
        }
    }
    let percentile = |mut values: Vec<i64>, percent: usize| {
        values.sort_unstable();
        let index = (values.len() * percent).div_ceil(100).max(1) - 1;
        values.get(index).map_or(0, |&value| 16 * value as u16)
    };
    Levels {
        dark: percentile(shadows, 2),
        tissue: percentile(grey.clone(), 60),
        bright: percentile(grey, 98),
    }
}

/// The predecessor of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
enum From {
    Cell(usize),
    Jump(usize),
    Absence,
}

/// The best paths to all cells of a line, and to absence.
struct Best {
    values: Vec<i64>,
    absent: i64,
    from: Vec<From>,
    absent_from: Option<usize>,
}

/// The first cell of the largest value.
fn largest(values: &[i64]) -> usize {
    let largest = values.iter().max();
    let at = values.iter().position(|value| Some(value) == largest);
    at.unwrap_or_default()
}

fn paths(p: &Parameters, scores: &[Vec<i64>]) -> Vec<Best> {
    let s = &p.settings;
    let cells = cells(p);
    let factor = (256.0 * p.spacing / s.spacing).round() as i64;
    let step = (1024.0 * s.slope * cells.length).round() as i64;
    let absence = (nats(s.absence) * factor) >> 8;
    let dearest = nats(s.jump).min(62 * step - 1);
    let mut lines: Vec<Best> = Vec::new();
    for scores in scores {
        let own = |cell: usize| (scores[cell] * factor) >> 8;
        let best = match lines.last() {
            None => Best {
                values: (0..scores.len()).map(own).collect(),
                absent: absence,
                from: vec![From::Absence; scores.len()],
                absent_from: None,
            },
            Some(before) => {
                let peak = largest(&before.values);
                let ended = before.values[peak] - nats(s.end);
                let to = |cell: usize| {
                    let move_from = |from: usize| {
                        let price = step * cell.abs_diff(from) as i64;
                        (before.values[from] - price, From::Cell(from))
                    };
                    let above = (0..=cell).rev().map(move_from);
                    let below = (cell + 1..scores.len()).map(move_from);
                    let jump = (before.values[peak] - dearest, From::Jump(peak));
                    let start = (before.absent - nats(s.end), From::Absence);
                    let all = above.chain(below).chain([jump, start]);
                    // The first of the largest.
                    let mut all = all.collect::<Vec<_>>();
                    all.reverse();
                    let best = all.into_iter().max_by_key(|candidate| candidate.0);
                    best.unwrap_or((0, From::Absence))
                };
                let best: Vec<_> = (0..scores.len()).map(to).collect();
                Best {
                    values: best.iter().enumerate().map(|(k, b)| b.0 + own(k)).collect(),
                    absent: before.absent.max(ended) + absence,
                    from: best.iter().map(|b| b.1).collect(),
                    absent_from: (ended > before.absent).then_some(peak),
                }
            }
        };
        lines.push(best);
    }
    lines
}

/// The best path to the last of some lines: cell, and whether a piece begins there.
///
/// A piece has no move by more than `most` cells.
fn trace(lines: &[Best], most: f64) -> Vec<Option<(usize, bool)>> {
    let mut path = vec![None; lines.len()];
    let Some(last) = lines.last() else {
        return path;
    };
    let peak = largest(&last.values);
    let mut cell = (last.values[peak] >= last.absent).then_some(peak);
    for (line, best) in lines.iter().enumerate().rev() {
        let Some(at) = cell else {
            cell = best.absent_from;
            continue;
        };
        let from = best.from[at];
        let goes_on = matches!(from, From::Cell(cell) if cell.abs_diff(at) as f64 <= most);
        path[line] = Some((at, !goes_on));
        cell = match from {
            From::Cell(cell) | From::Jump(cell) => Some(cell),
            From::Absence => None,
        };
    }
    path
}

/// The surface of a frame, by scores.
///
/// Each line is decided by the lines up to `latency` after it.
pub fn of_scores(p: &Parameters, scores: &[Vec<i64>]) -> Vec<Option<Point>> {
    let lines = paths(p, scores);
    // As they are kept: in 1/32 nat, from −10 to below 6.
    let kept = |line: usize, cell: usize| ((scores[line][cell] >> 5) + 320).clamp(0, 511);
    let nats = |line: usize, cell: usize| kept(line, cell) as f32 / 32.0 - 10.0;
    let cells = cells(p);
    let decide = |line: usize| {
        let known = (line + p.latency + 1).min(lines.len());
        let path = trace(&lines[..known], p.settings.step / cells.length);
        let (cell, begins) = path[line]?;
        // From the first line that the piece reaches to the last, of those around it.
        let mut first = line;
        while first > line.saturating_sub(4)
            && path[first].is_some_and(|(_, begins)| !begins)
            && path[first - 1].is_some()
        {
            first -= 1;
        }
        let mut last = line;
        while last < (line + 4).min(known - 1) && path[last + 1].is_some_and(|(_, begins)| !begins)
        {
            last += 1;
        }
        let own = nats(line, cell);
        let back = (first..line).rev();
        let others = back.chain(line + 1..last + 1);
        let sum = others.fold(own, |sum, k| sum + path[k].map_or(0.0, |(c, _)| nats(k, c)));
        let absence = (1024.0 * p.settings.absence).round() as f32 / 1024.0;
        let margin = sum / (last - first + 1) as f32 - absence;
        let [a, b] = p.settings.confidence;
        // Lines in the order of their sum, with the depths of their centroids of scores from the cell on.
        let beside = (first.max(line.saturating_sub(3))..line).rev();
        let beside = beside.chain(line + 1..(last + 1).min(line + 4));
        let echo = |k: usize| {
            let at = path[k].map_or(0, |(at, _)| at);
            if at < 2 || at + 2 >= cells.searched {
                return at as f32 - cell as f32;
            }
            let around = at - 2..at + 3;
            let largest = around.clone().map(|c| kept(k, c)).max().unwrap_or(0);
            let weights =
                around.map(|c| (c as i64 - at as i64, (kept(k, c) - largest + 32).max(0)));
            let moment: i64 = weights.clone().map(|(below, weight)| below * weight).sum();
            let centre = moment as f32 / weights.map(|w| w.1).sum::<i64>() as f32;
            at as f32 - cell as f32 + centre
        };
        let fitted: Vec<_> = [line].into_iter().chain(beside).collect();
        let sum = |term: &dyn Fn(f32, f32, f32) -> f32| {
            let terms = fitted.iter().map(|&k| {
                let x = k as f32 - line as f32;
                term(4.0 - x.abs(), x, echo(k))
            });
            terms.reduce(|sum, term| sum + term).unwrap_or(0.0)
        };
        let [w, wx, wxx] = [
            sum(&|w, _, _| w),
            sum(&|w, x, _| w * x),
            sum(&|w, x, _| w * x * x),
        ];
        let [wz, wxz] = [sum(&|w, _, z| w * z), sum(&|w, x, z| w * x * z)];
        let fraction = match fitted.len() {
            1 => wz / w,
            _ => (wz * wxx - wxz * wx) / (w * wxx - wx * wx),
        } - 0.15;
        let sample = ((cells.first + cell) as f64 + f64::from(fraction)) * cells.stride as f64
            + (cells.stride - 1) as f64 / 2.0;
        Some(Point {
            depth: (p.samples.first + sample * p.samples.step) as f32,
            confidence: 1.0 / (1.0 + libm::expf(-(a + b * margin))),
            begins,
        })
    };
    (0..lines.len()).map(decide).collect()
}

/// The surface of a frame, grey levels `[line][sample]`.
pub fn surface(p: &Parameters, frame: &[u8]) -> Vec<Option<Point>> {
    let levels = levels(p, frame);
    let lines = frame.chunks(p.samples.count);
    let scores: Vec<_> = lines.map(|line| scores(p, line, levels)).collect();
    sure(p, of_scores(p, &scores))
}

/// The pieces whose mean confidence is at least the settings' `piece`.
fn sure(p: &Parameters, points: Vec<Option<Point>>) -> Vec<Option<Point>> {
    let goes_on = |_: &Option<Point>, next: &Option<Point>| next.is_some_and(|p| !p.begins);
    let pieces = points.chunk_by(goes_on).flat_map(|piece| {
        let confidences = piece.iter().flatten().map(|point| point.confidence);
        let count = confidences.clone().count() as f32;
        let keeps = confidences.fold(0.0, |sum, own| sum + own) >= p.settings.piece * count;
        piece.iter().map(move |point| point.filter(|_| keeps))
    });
    pieces.collect()
}

/// The surface of a frame with the coherence of its samples, 0 to 255.
pub fn surface_with_coherence(
    p: &Parameters,
    frame: &[u8],
    coherence: &[u8],
) -> Vec<Option<Point>> {
    let levels = levels(p, frame);
    let lines = frame.chunks(p.samples.count);
    let scores = lines.zip(coherence.chunks(p.samples.count));
    let scores = scores.map(|(grey, coherence)| {
        let term = coherence_term(p, coherence);
        let own = self::scores(p, grey, levels);
        own.iter().zip(term).map(|(own, term)| own + term).collect()
    });
    sure(p, of_scores(p, &scores.collect::<Vec<_>>()))
}
