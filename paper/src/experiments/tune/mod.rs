//! Joint tuning of beamformer, image and detector of the bone surface.
//!
//! They are tuned on some simulated bones and judged on others.

mod scenes;
mod search;
mod show;
mod variables;

use super::study::*;
use super::surface::disturb::Disturbances;
use bonebeam::surface::Settings;
use bonebeam_drive::config::Beamform;
use bonebeam_drive::methods::MethodName;
use bonebeam_simulate::Settings as Scanner;
use scenes::{Found, Frame, Recorded, Scenes, found, score};
use search::{DETECTORS, Evaluation, best, search};
pub use show::Shown;
pub use variables::Sections;
use variables::Variable;

/// Number of the first bone, beyond those of the paper's experiments.
///
/// Each seed has its own bones: first those for tuning, then those for judging.
const FIRST_BONE: u64 = 1 << 48;
/// Largest number of bones for tuning, and for judging.
const MOST_BONES: u64 = 1 << 10;
/// Detector settings that sections do not have.
const DETECTOR: Settings = Settings::COHERENCE;
/// The largest seed.
const MOST_SEEDS: u64 = 1 << 32;

/// All parameters of a tuning.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tune {
    /// Methods, each tuned by itself.
    pub methods: Vec<MethodName>,
    /// Number of bones for tuning, and of others for judging.
    pub bones: u64,
    /// Evaluations of each search.
    pub evaluations: usize,
    /// Seed of the search and of the bones.
    pub seed: u64,
    /// Start of the search, and values that are not tuned.
    pub sections: Sections,
    /// The scenes.
    pub scenes: Scenes,
}

/// Candidate: sections that are judged.
#[derive(Clone, Debug, Serialize)]
struct Candidate {
    name: String,
    /// Score on the bones for tuning.
    score: f64,
    sections: Sections,
    #[serde(skip)]
    variables: Vec<Variable>,
    #[serde(skip)]
    evaluations: Vec<Evaluation>,
}

/// A bone that was judged.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct JudgedBone {
    number: u64,
    /// Results of every candidate, in their order, in every condition.
    found: Vec<Vec<Found>>,
}

impl Tune {
    /// The full tuning, or a coarse one for a first look.
    pub fn new(quick: bool) -> Self {
        let scanner = Scanner {
            fs: 20e6,
            depth_start: 2e-3,
            depth_end: 45e-3,
            focus: 20e-3,
            ..Scanner::volume()
        };
        let full = Tune {
            methods: vec![MethodName::Das, MethodName::Mv, MethodName::EsmvRank1],
            bones: 6,
            evaluations: 240,
            seed: 1,
            sections: Sections::default(),
            scenes: Scenes {
                scanner,
                thickness: 3e-3,
                density: 20e9,
                disturbances: Disturbances::default(),
            },
        };
        if !quick {
            return full;
        }
        Tune {
            methods: vec![MethodName::Das, MethodName::Mv],
            bones: 2,
            evaluations: 24,
            scenes: Scenes {
                scanner: common::quick(full.scenes.scanner),
                thickness: 1e-3,
                density: 5e9,
                ..full.scenes
            },
            ..full
        }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`Error::Usage`] naming the flag, the value and the range.
    pub fn validate(&self) -> Result<()> {
        for (flag, value, [least, most]) in [
            ("bones", self.bones, [2, MOST_BONES]),
            ("evaluations", self.evaluations as u64, [1, 100_000]),
            ("seed", self.seed, [0, MOST_SEEDS]),
        ] {
            if !(least..=most).contains(&value) {
                return Err(Error::Usage(format!(
                    "--{flag} is {value}; expected {least} to {most}"
                )));
            }
        }
        for (k, method) in self.methods.iter().enumerate() {
            if self.methods[..k].contains(method) {
                return Err(Error::Usage(format!(
                    "--methods has {method} twice; expected each method once"
                )));
            }
            self.sections.start(*method).beamform.validate()?;
        }
        self.sections.image.validate()?;
        self.sections.surface.validate()?;
        self.scenes.scanner.validate()
    }

    /// Tunes and judges. The outcome depends on the parameters only.
    pub fn run(&self, context: &Context<'_>) -> Result<Shown> {
        let mut bones = Bones {
            tune: self,
            context,
            recorded: Vec::new(),
            lines: None,
        };
        let das = self.sections.start(MethodName::Das);
        let default = Candidate {
            name: "DAS, detector's defaults".into(),
            score: bones.score(&das)?,
            sections: das.clone(),
            variables: Vec::new(),
            evaluations: Vec::new(),
        };
        let detector = Variable::of_detector();
        let mut candidates = vec![default];
        // Detectors take much less time than lines.
        let many = self.evaluations.saturating_mul(DETECTORS);
        let name = "DAS, detector tuned";
        let tuned = self.tuned(&mut bones, name, &das, detector, many)?;
        let surface = tuned.sections.surface.clone();
        candidates.push(tuned);
        for method in &self.methods {
            // Joint tuning starts from the result of the detector alone.
            let start = Sections {
                surface: surface.clone(),
                ..self.sections.start(*method)
            };
            let name = format!("{method}, tuned together");
            let variables = Variable::of_method(*method);
            candidates.push(self.tuned(&mut bones, &name, &start, variables, self.evaluations)?);
        }
        drop(bones);
        let judged = self.judge(context, &candidates)?;
        Shown::new(self, &candidates, &judged)
    }

    fn tuned(
        &self,
        bones: &mut Bones<'_>,
        name: &str,
        start: &Sections,
        variables: Vec<Variable>,
        count: usize,
    ) -> Result<Candidate> {
        let progress = bones.context.progress;
        let values = start.values(&variables)?;
        let mut n = 0;
        let evaluations = search(&variables, &values, count, self.seed, |values| {
            progress(name, n as f64 / count as f64);
            n += 1;
            bones.score(&start.with(&variables, values)?)
        })?;
        let none = || Error::Usage("--evaluations gives no evaluation".into());
        let best = best(&evaluations).ok_or_else(none)?;
        Ok(Candidate {
            name: name.to_owned(),
            score: best.score,
            sections: start.with(&variables, &best.values)?,
            variables,
            evaluations,
        })
    }

    /// Judges each candidate on bones that were not used for tuning.
    fn judge(&self, context: &Context<'_>, candidates: &[Candidate]) -> Result<Vec<JudgedBone>> {
        let first = self.first_bone() + MOST_BONES;
        let sections: Vec<&Sections> = candidates.iter().map(|c| &c.sections).collect();
        let bone = |number: u64| {
            let key = format!("{:?} {number} {sections:?} {DETECTOR:?}", self.scenes);
            kept(context, "tune-judged", &key, || {
                let what = format!("judge: bone {} of {}", number - first + 1, self.bones);
                let recorded = self.scenes.record(context, number, &what)?;
                let of = |(k, sections): (usize, &&Sections)| {
                    (context.progress)(&what, k as f64 / candidates.len() as f64);
                    let frames = recorded.frames(&sections.beamform, &sections.surface)?;
                    found(&frames, &sections.surface)
                };
                let found = sections.iter().enumerate().map(of).collect::<Result<_>>()?;
                Ok(JudgedBone { number, found })
            })
        };
        (first..first + self.bones).map(bone).collect()
    }

    fn first_bone(&self) -> u64 {
        FIRST_BONE + 2 * MOST_BONES * self.seed
    }
}

/// The bones for tuning, which are recorded when the first new score is needed.
struct Bones<'a> {
    tune: &'a Tune,
    context: &'a Context<'a>,
    recorded: Vec<Recorded>,
    /// The lines of the last beamformer.
    lines: Option<(Beamform, Vec<Frame>)>,
}

impl Bones<'_> {
    fn score(&mut self, sections: &Sections) -> Result<f64> {
        let (tune, context) = (self.tune, self.context);
        let bones = (tune.first_bone(), tune.bones);
        let key = format!("{:?} {bones:?} {sections:?} {DETECTOR:?}", tune.scenes);
        kept(context, "tune-score", &key, || {
            let frames = match self.lines.take() {
                Some((beamform, frames)) if beamform == sections.beamform => frames,
                _ => self.frames(sections)?,
            };
            let found = found(&frames, &sections.surface)?;
            self.lines = Some((sections.beamform.clone(), frames));
            Ok(score(&found))
        })
    }

    fn frames(&mut self, sections: &Sections) -> Result<Vec<Frame>> {
        let tune = self.tune;
        if self.recorded.is_empty() {
            let record = |k: u64| {
                let what = format!("tune: bone {} of {}", k + 1, tune.bones);
                tune.scenes
                    .record(self.context, tune.first_bone() + k, &what)
            };
            self.recorded = (0..tune.bones).map(record).collect::<Result<_>>()?;
        }
        let mut frames = Vec::new();
        for recorded in &self.recorded {
            frames.extend(recorded.frames(&sections.beamform, &sections.surface)?);
        }
        Ok(frames)
    }
}
