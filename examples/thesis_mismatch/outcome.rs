//! What the methods and the diagnosis make of one cause: disagreement of the three methods; found, blind, or neither.

use std::error::Error;

use fiveaxis::diagnose::{Cause, Diagnosis, Finding, diagnose};
use fiveaxis::identify::Options;
use fiveaxis::session::Session;

use super::causes::LeftOut;
use super::designs::{Design, extended, record};

/// The four orientation errors.
pub const ORIENTATIONS: [&str; 4] = ["EB0A", "EC0A", "EA0C", "EB0C"];

/// An orientation error by the three methods, arcsec, with the standard deviation of the mean that the repeats tell.
#[derive(Debug, Clone, Default)]
pub struct ByMethod {
    pub value: [f64; 3],
    pub sigma: [f64; 3],
}

impl ByMethod {
    /// Largest difference between two methods, arcsec.
    pub fn spread(&self) -> f64 {
        let largest = self.value.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        largest - self.value.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Largest ratio of the difference of two methods to the standard deviation of that difference.
    pub fn in_sigmas(&self) -> f64 {
        let pairs = [(0, 1), (0, 2), (1, 2)];
        let ratio = |(a, b): (usize, usize)| (self.value[a] - self.value[b]).abs() / self.sigma[a].hypot(self.sigma[b]);
        pairs.into_iter().map(ratio).fold(0.0, f64::max)
    }
}

/// How close a finding comes to the cause.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Named {
    /// Its effect, place and one of its components.
    Exactly,
    /// The same among what the finding cannot be told from.
    AsRival,
    /// Its place and component, as sag in place of error motion or the other way round (the finding or a rival): over one
    /// arc of a tilting axis the direction of gravity is a function of the angle.
    AsSagOrErrorMotion,
    /// The same motion of the table as a sag at C, which A carries: C stands still in every test of A.
    AsSagOfCarried,
}

/// How a diagnosis deals with a cause that is there.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// It is a finding, or stands among what a finding cannot be told from.
    Found { how: Named, probability: f64 },
    /// Not found, and listed with a smallest visible size above the cause's (`None`: of any size).
    Blind(Option<f64>),
    /// Nothing to find: no cause, or one that is fitted anyway.
    Clean,
    /// Not found, and not listed as out of sight at its size.
    Neither(String),
}

/// Diagnoses a recorded session and compares it with what is there.
fn outcome(session: &Session, cause: &LeftOut) -> Result<Outcome, Box<dyn Error>> {
    Ok(judged(&diagnose(session, &Options::default())?, cause))
}

fn judged(diagnosis: &Diagnosis, cause: &LeftOut) -> Outcome {
    let found = || -> Vec<String> {
        let size = |finding: &Finding| format!("{:.1} {}", finding.size.value, finding.size.unit);
        let one = |finding: &Finding| {
            format!(
                "{} {} {} {}",
                finding.cause.effect,
                finding.cause.place,
                finding.cause.components.join(" "),
                size(finding)
            )
        };
        diagnosis.findings.iter().map(one).collect()
    };
    let Some((kind, place, components)) = cause.truth() else {
        return if diagnosis.findings.is_empty() { Outcome::Clean } else { Outcome::Neither(found().join("; ")) };
    };
    let is_it = |other: &Cause| {
        other.effect == kind && other.place == place && other.components.iter().any(|name| components.contains(name))
    };
    let of_angle = |name: &str| ["rotary-error-motion", "gravity-sag"].contains(&name);
    let is_like = |other: &Cause| {
        let shares = other.components.iter().any(|name| components.contains(name));
        of_angle(&other.effect) && of_angle(kind) && other.place == place && shares
    };
    let causes = || {
        diagnosis.findings.iter().flat_map(|finding| {
            let rivals = finding.rivals.iter().map(|(rival, odds)| (false, rival, *odds));
            std::iter::once((true, &finding.cause, finding.probability)).chain(rivals)
        })
    };
    if let Some((first, _, probability)) = causes().find(|(_, cause, _)| is_it(cause)) {
        return Outcome::Found { how: if first { Named::Exactly } else { Named::AsRival }, probability };
    }
    if let Some((_, _, probability)) = causes().find(|(_, cause, _)| is_like(cause)) {
        return Outcome::Found { how: Named::AsSagOrErrorMotion, probability };
    }
    let is_carried = |other: &Cause| {
        let carried = |name: &String| name.ends_with('A') && other.components.contains(&name.replace("A", "C"));
        other.effect == "gravity-sag" && other.place == "C" && place == "A" && components.iter().any(carried)
    };
    if let Some((_, _, probability)) = causes().find(|(_, cause, _)| is_carried(cause)) {
        return Outcome::Found { how: Named::AsSagOfCarried, probability };
    }
    if !diagnosis.findings.is_empty() {
        return Outcome::Neither(format!("named: {}", found().join("; ")));
    }
    let listed: Vec<_> = diagnosis.blind_to.iter().filter(|blind| is_it(&blind.cause)).collect();
    let sizes = listed.iter().map(|blind| blind.smallest);
    let out_of_sight = |smallest: &Option<f64>| smallest.is_none_or(|smallest| smallest >= cause.size);
    match sizes.clone().find(out_of_sight) {
        Some(smallest) => Outcome::Blind(smallest),
        None => match sizes.flatten().reduce(f64::min) {
            Some(smallest) => Outcome::Neither(format!("clean; listed as visible from {smallest:.1}")),
            None => Outcome::Neither("clean; not listed".into()),
        },
    }
}

/// Session of a design with the cause in it; `seed` decides every draw.
fn session_of(design: &Design, cause: &LeftOut, seed: u64) -> Result<Session, Box<dyn Error>> {
    record(&design.session, cause, seed + u64::from(design.chapter))
}

/// The orientation errors by the three methods with a cause in their sessions.
pub fn by_method(designs: &[Design], cause: &LeftOut, seed: u64) -> Result<[ByMethod; 4], Box<dyn Error>> {
    let mut errors: [ByMethod; 4] = Default::default();
    for (index, design) in designs.iter().enumerate() {
        let estimate = (design.method)(&session_of(design, cause, seed)?)?;
        for (k, wanted) in ORIENTATIONS.iter().enumerate() {
            let found = estimate.values.iter().find(|value| value.name.to_string() == *wanted);
            let found = found.ok_or_else(|| format!("no {wanted}"))?;
            let output = |radians: f64| found.name.component.measure().to_output(radians);
            errors[k].value[index] = output(found.value);
            errors[k].sigma[index] = output(found.mean_deviation.unwrap_or(0.0));
        }
    }
    Ok(errors)
}

/// What the diagnosis says of the session of every design.
pub fn outcomes(designs: &[Design], cause: &LeftOut, seed: u64) -> Result<Vec<Outcome>, Box<dyn Error>> {
    designs.iter().map(|design| outcome(&session_of(design, cause, seed)?, cause)).collect()
}

/// What it says of the extension that should show the cause, and the extension in words.
pub fn shown(
    designs: &[Design],
    cause: &LeftOut,
    seed: u64,
) -> Result<Option<(&'static str, Outcome)>, Box<dyn Error>> {
    let Some(extension) = cause.extension else { return Ok(None) };
    let (session, words) = extended(designs, extension);
    Ok(Some((words, outcome(&record(&session, cause, seed)?, cause)?)))
}
