//! The one test that tells the causes left apart: each candidate circle predicted under every cause with its fitted size.

use nalgebra::{DMatrix, DVector, Vector2};

use super::causes::Kind;
use super::design::{Design, Group};
use super::prepared::Prepared;
use super::verdict::Verdict;
use crate::chain::Composition;
use crate::methods::turning_circle;
use crate::session::Session;
use crate::simulate::simulate;
use crate::units::UM_PER_MM;

/// What would be run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Candidate {
    /// A circle again at the end of its session, nothing remounted.
    Again { claim: usize, group: usize },
    /// The short bar with both balls where the extended bar had the standing one.
    ShortInPlace { claim: usize, group: usize },
}

/// The test that decides most.
#[derive(Debug, Clone, PartialEq)]
pub struct DecidingTest {
    pub candidate: Candidate,
    /// By cause named: index among the causes and the centre that it predicts beside the nominal one, µm.
    pub predicted: Vec<(usize, [f64; 2])>,
    /// Pairs of named causes that it tells apart, and all pairs.
    pub told_apart: (usize, usize),
}

/// Two centres this far apart are told apart, µm: three times what a centre is uncertain by with bar and slides of ±1 µm.
const APART_UM: f64 = 2.5;
/// Causes compared at most, the best first.
const COMPARED: usize = 12;

/// The best test; `None` where fewer than two causes are named.
pub fn deciding(prepared: &Prepared, values: &DVector<f64>, verdicts: &[Verdict]) -> Option<DecidingTest> {
    let named: Vec<&Verdict> = verdicts.iter().filter(|verdict| verdict.is_named()).take(COMPARED).collect();
    if named.len() < 2 {
        return None;
    }
    let mut best: Option<DecidingTest> = None;
    for (claim, design) in prepared.designs.iter().enumerate() {
        for (group, of) in design.groups.iter().enumerate() {
            let mut candidates = vec![Candidate::Again { claim, group }];
            if of.reach_mm.abs() > 1.0 {
                candidates.push(Candidate::ShortInPlace { claim, group });
            }
            for candidate in candidates {
                let predicted: Option<Vec<(usize, [f64; 2])>> = named
                    .iter()
                    .map(|verdict| Some((verdict.cause, predict(prepared, values, verdict, candidate)?)))
                    .collect();
                let Some(predicted) = predicted else { continue };
                let apart = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) > APART_UM;
                let pairs = (0..predicted.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
                let told = pairs.filter(|(a, b)| apart(&predicted[*a].1, &predicted[*b].1)).count();
                let all = predicted.len() * (predicted.len() - 1) / 2;
                if told > best.as_ref().map_or(0, |best| best.told_apart.0) {
                    best = Some(DecidingTest { candidate, predicted, told_apart: (told, all) });
                }
            }
        }
    }
    best
}

/// Centre of the candidate's circle under a cause, µm beside the nominal one.
fn predict(prepared: &Prepared, values: &DVector<f64>, verdict: &Verdict, candidate: Candidate) -> Option<[f64; 2]> {
    let (Candidate::Again { claim, group } | Candidate::ShortInPlace { claim, group }) = candidate;
    let design = &prepared.designs[claim];
    let cause = &prepared.causes[verdict.cause];
    let size = verdict.size.map_or(1.0, |size| size.value);
    let corrected = match verdict.size {
        Some(_) => values - prepared.stacked(cause, values) * size,
        None => values + prepared.stacked(cause, values),
    };
    let machine = machine_errors(prepared, design, &corrected)?;
    let in_it = cause.claim.is_none_or(|of| of == claim);
    let session = design.with_errors(&design.session, &machine);
    let session = if in_it { with_cause(design, &session, &cause.kind, size) } else { session };
    let with = centre(design, &candidate_session(&session, design, candidate), group)?;
    let nominal = centre(design, &candidate_session(&design.session, design, candidate), group)?;
    let off = (with - nominal) * UM_PER_MM;
    Some([off.x, off.y])
}

/// Weighted mean of the machine's errors over the claims, in the order of a design's names, µm and arcsec.
fn machine_errors(prepared: &Prepared, design: &Design, values: &DVector<f64>) -> Option<DVector<f64>> {
    let mut names = prepared.names.clone();
    names.sort();
    names.dedup();
    let x = DMatrix::from_fn(prepared.names.len(), names.len(), |row, column| {
        f64::from(prepared.names[row] == names[column])
    });
    let weights = prepared.covariance.clone().cholesky()?;
    let normal = x.transpose() * weights.solve(&x);
    let found = normal.cholesky()?.solve(&(x.transpose() * weights.solve(values)));
    let of = |name| names.iter().position(|other| other == name).map_or(0.0, |k| found[k]);
    Some(DVector::from_iterator(design.names.len(), design.names.iter().map(of)))
}

/// The session as it is with physics of a size (µm); assumptions and misread circles change no machine.
fn with_cause(design: &Design, session: &Session, kind: &Kind, size: f64) -> Session {
    let mut with = session.clone();
    match *kind {
        Kind::Seat { from_group, coordinate } => {
            // whoever runs a circle again has the ball as it stands now
            let later = design.groups[from_group..].iter().flat_map(|group| &group.tests);
            later.for_each(|(test, _)| with.tests[*test].spindle_ball.at[coordinate] += size / UM_PER_MM);
        }
        _ => with.machine.effects.extend(super::causes::effect_of(design, kind).map(|effect| effect.scaled(size))),
    }
    with
}

/// The session with the candidate as the last test: the first run of its group.
fn candidate_session(session: &Session, design: &Design, candidate: Candidate) -> Session {
    let (Candidate::Again { group, .. } | Candidate::ShortInPlace { group, .. }) = candidate;
    let of: &Group = &design.groups[group];
    let mut extended = session.clone();
    let Some((first, _)) = of.tests.first() else { return extended };
    let mut test = session.tests[*first].clone();
    let last_s = session.tests.iter().map(|test| test.started_at_s).fold(0.0, f64::max);
    test.started_at_s = last_s + 120.0;
    test.name = format!("{} again", test.name);
    if let Some(last) = session.tests.last().filter(|last| last.spindle_ball.link == test.spindle_ball.link) {
        test.spindle_ball.at = last.spindle_ball.at;
    }
    if let Candidate::ShortInPlace { .. } = candidate {
        let along = session.machine.axes[of.axis].direction * of.reach_mm;
        if design.pivot_is_carried(of, *first) { test.pivot.at -= along } else { test.spindle_ball.at -= along }
    }
    extended.tests.push(test);
    extended
}

/// Centre of the last test's circle, read by the nominal description, mm.
fn centre(design: &Design, session: &Session, group: usize) -> Option<Vector2<f64>> {
    let lengths = simulate(session, Composition::Exact).ok()?.pop()?.length_mm;
    let mut declared = session.clone();
    declared.machine = design.session.machine.clone();
    let index = declared.tests.len() - 1;
    declared.tests[index].recording.as_mut()?.length_mm = lengths;
    turning_circle(&declared, &design.chain, index, design.groups[group].axis).ok().map(|circle| circle.centre_mm)
}
