//! Report of the point: the paper's Fig. 2, and the dependence on beams and noise.

use crate::experiments::outcome::View;
use crate::experiments::study::*;

use super::measure::{PhaseResult, PointSpreadResult, ProfileMeasure};

const WIDTH: &str = "In theory, f-numbers 2.8 and 2.5 give DAS 0.96 mm; 0.8 mm would need both near 2. The \
     rank-1 lobe is narrower than an element. With one beam per element its width therefore depends on the \
     point's position between beams, which the paper does not give.";
const LOBE: &str = "Free of noise. With fine beams the largest side lobe of rank-1 ESMV is a shoulder beside \
     the main lobe. With beams one element apart it falls between two of them. The paper's -95 dB is the level \
     beyond it.";
const FIRST: &str =
    "The paper says of Fig. 2(c) that most of the main lobe between 0 and -20 dB is gone.";

/// The outcome of a result whose pictures show `range` dB.
pub fn outcome(result: &PointSpreadResult, range: f64, views: Vec<View>) -> Result<Outcome> {
    let mut parts = vec![Section::Text(format!(
        "One point at the transmit focus of 15 mm, as in the paper's Fig. 2: (a) DAS, (b) ESMV with only the \
         largest eigenvalue, (c) ESMV without it, (d) the two-way beam profiles. L = M/2, K = 0, forward \
         covariance (Eq. 5); forward-backward (FB) is shown beside it. The point lies on a beam. Beams are \
         {:.4} mm apart. Pixels are interpolated bilinearly, widths linearly in dB between beams. The pictures \
         show 3 mm × 5 mm, each relative to its own peak.",
        result.beam_spacing_mm
    ))];
    let mut grey = scales(range);
    grey.truncate(1);
    parts.extend(SideBySide::of("fig2", views, 0, Vec::new(), grey));
    parts.extend([
        Section::Heading("Beam profiles (Fig. 2d)"),
        Section::Plots(vec![
            profiles("Fine beams, forward covariance, as the paper's figure", &result.fine, false),
            profiles("Fine beams, forward-backward", &result.fine, true),
        ]),
        Section::Heading("Position of the point between the beams"),
        Section::Text(
            "One beam per element, as in the paper. The point moves from a beam to the middle between two."
                .into(),
        ),
        Section::Plots(phase_plots(&result.phases)),
        Section::Heading("Noise"),
        Section::Text(
            "Electronic noise with the transducer's spectrum. Channel SNR is the largest sample of the record \
             over the RMS of the noise. The table gives means over the seeds, with the least and the largest \
             value."
                .into(),
        ),
        Section::Table(noise_table(result)),
    ]);
    Ok(Outcome {
        title: "Fig. 2: a point scatterer",
        parts,
        tables: tables(result),
        comparisons: comparisons(result),
        data: data(result)?,
        ..Outcome::default()
    })
}

/// Profiles of DAS and of the beamformers with this covariance.
fn profiles(caption: &str, measures: &[ProfileMeasure], backward: bool) -> Plot {
    let chosen = measures
        .iter()
        .filter(|m| m.beamformer == "das" || m.beamformer.ends_with("-fb") == backward);
    let curves = chosen.map(|m| {
        let featured = ["das", "esmv-rank1", "esmv-rank1-fb"].contains(&&m.beamformer[..]);
        let points = m.x_mm.iter().zip(&m.profile_re_das_db);
        Curve::new(m.name.clone(), featured, points.map(|(&x, &y)| (x, y)))
    });
    let names = ["lateral, mm from the point", "dB re DAS peak"];
    Plot::new(caption, names, [[-2.7, 2.7], [-120.0, 0.0]], curves)
}

/// Width and far level by the point's position.
fn phase_plots(phases: &[PhaseResult]) -> Vec<Plot> {
    type Pick = fn(&ProfileMeasure) -> Option<f64>;
    let rows: [(&str, &'static str, [f64; 2], Pick); 2] = [
        ("−12 dB width", "mm", [0.0, 1.4], |m| m.width_12db_mm),
        ("Level beyond 2 mm", "dB", [-110.0, 0.0], |m| {
            m.beyond_2mm_db
        }),
    ];
    let x = "distance of the point from the nearest beam, pitches";
    let plot = |(caption, y, y_range, pick): (&str, &'static str, [f64; 2], Pick)| {
        let all = phases[0].beamformers.iter().enumerate();
        let shown = all.filter(|(_, m)| !m.beamformer.contains("without-first"));
        let curves = shown.map(|(k, m)| {
            let featured = ["das", "esmv-rank1"].contains(&&m.beamformer[..]);
            let points = phases
                .iter()
                .map(|p| (p.offset_pitches, pick(&p.beamformers[k])));
            Curve::new(m.name.clone(), featured, points)
        });
        Plot::new(caption, [x, y], [[0.0, 0.5], y_range], curves)
    };
    rows.map(plot).into()
}

fn noise_table(result: &PointSpreadResult) -> Table {
    fn cell(value: Option<[f64; 3]>) -> String {
        value.map_or("–".into(), |[mean, ends @ ..]| ranged(mean, ends))
    }
    let snrs = result.snrs.iter();
    Table::of(
        "Fine beams, by channel SNR",
        snrs.flat_map(|at| at.beamformers.iter().map(|m| (at.snr_db, m))),
        &[
            ("", |(snr, m)| format!("{snr} dB, {}", m.name)),
            ("-12 dB width, mm", |(_, m)| cell(m.width_12db_mm)),
            ("beyond 2 mm, dB", |(_, m)| cell(m.beyond_2mm_db)),
        ],
    )
}

fn tables(result: &PointSpreadResult) -> Vec<Table> {
    let table = |title: String, measures: &[ProfileMeasure]| {
        let columns: [Column<&ProfileMeasure>; 7] = [
            ("", |m| m.name.clone()),
            ("-12 dB width, mm", |m| number(m.width_12db_mm)),
            ("FWHM, mm", |m| number(m.fwhm_mm)),
            ("side lobe, dB", |m| number(m.side_lobe_db)),
            ("beyond 2 mm, dB", |m| number(m.beyond_2mm_db)),
            ("peak re DAS, dB", |m| number(m.peak_re_das_db)),
            ("on axis re DAS, dB", |m| number(m.on_axis_re_das_db)),
        ];
        Table::of(title, measures, &columns).on_page()
    };
    let fine = table("Fine beams, free of noise".into(), &result.fine);
    let phases = result.phases.iter().map(|p| {
        let title = format!(
            "One beam per element, point {} pitches off the nearest",
            p.offset_pitches
        );
        table(title, &p.beamformers)
    });
    std::iter::once(fine).chain(phases).collect()
}

fn comparisons(result: &PointSpreadResult) -> Vec<Comparison> {
    type Row = (
        &'static str,
        fn(&ProfileMeasure) -> Option<f64>,
        [&'static [f64]; 2],
        &'static str,
    );
    #[rustfmt::skip]
    let rows: [Row; 4] = [
        ("-12 dB width, mm", |m| m.width_12db_mm, [&[0.8], &[0.35]], WIDTH),
        ("peak side lobe, dB", |m| m.side_lobe_db, [&[-30.0], &[-95.0]], LOBE),
        ("level beyond 2 mm, dB", |m| m.beyond_2mm_db, [&[], &[]], LOBE),
        ("on axis re DAS peak, dB", |m| Some(m.on_axis_re_das_db), [&[], &[]], FIRST),
    ];
    let beamformers = [
        ("das", "DAS"),
        ("esmv-rank1", "ESMV rank 1"),
        ("esmv-without-first", "ESMV without λ₁"),
    ];
    let mut sets = vec![("Fig. 2(d), fine beams".to_owned(), &result.fine)];
    for p in &result.phases {
        let group = format!(
            "Fig. 2(d), one beam per element, point {} pitches off",
            p.offset_pitches
        );
        sets.push((group, &p.beamformers));
    }
    let comparison =
        |group: &str, measures: &[ProfileMeasure], (quantity, pick, paper, note): Row| {
            let value = |(k, (beamformer, name)): (usize, (&'static str, &'static str))| {
                let measure = measures.iter().find(|m| m.beamformer == beamformer);
                PaperComparison {
                    beamformer,
                    name,
                    here: measure.and_then(pick),
                    paper: paper.get(k).map_or(Vec::new(), |paper| paper.to_vec()),
                }
            };
            Comparison {
                group: group.into(),
                quantity: quantity.into(),
                values: beamformers.into_iter().enumerate().map(value).collect(),
                note,
            }
        };
    let of_set = |(group, measures): (String, &Vec<ProfileMeasure>)| {
        rows.map(|row| comparison(&group, measures, row))
    };
    sets.into_iter().flat_map(of_set).collect()
}
