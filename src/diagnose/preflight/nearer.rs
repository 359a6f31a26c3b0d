//! Mistakes that have a size brought nearer to it than the grid on which they are tried. Which one was made is for others to judge.

use rayon::prelude::*;

use super::late_clock::shifted;
use super::places::standing::{column_off, stood_at};
use super::suspicion::{Judged, Suspicion};
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::model::decimate::Sampled;
use crate::machine::AxisKind;
use crate::session::Session;

/// Steps about the grid at which an axis is thought to have stood or to be off, deg: together more than half a step of the
/// grid. And mm for slides.
const FINER_DEG: [f64; 11] = [8.0, 4.0, 2.0, 1.0, 0.5, 0.25, 0.12, 0.06, 0.03, 0.015, 0.008];
const FINER_MM: [f64; 11] = [3.0, 1.5, 0.8, 0.4, 0.2, 0.1, 0.05, 0.025, 0.012, 0.006, 0.003];
/// The same of a shift in time, as shares of it.
const FINER_SHARE: [f64; 5] = [0.08, 0.04, 0.02, 0.01, 0.005];

/// Mistakes that have a size brought nearer to it, each the best of its grid.
const BROUGHT_NEARER: usize = 8;

/// Brings the best few mistakes that have a size nearer to it than the grid: others find theirs in the fit. Shifts in time are made on all
/// rows.
pub(crate) fn bring_nearer(
    sampled: Sampled<'_>,
    misfit_um: impl Fn(&Session) -> Option<f64> + Sync + Copy,
    judged: &mut [Judged],
) {
    let thinned = sampled.few_rows;
    judged.sort_by(|a, b| a.left_um.total_cmp(&b.left_um));
    let mut seen: Vec<(FaultKind, Vec<String>, Vec<String>)> = Vec::new();
    let mut places = Vec::new();
    for (place, Judged { suspicion: one, .. }) in judged.iter().enumerate() {
        let key = (one.kind, one.components.clone(), one.tests.clone());
        let has_size = [FaultKind::StandingAxis, FaultKind::ColumnShifted, FaultKind::TimeShift].contains(&one.kind);
        if has_size && !seen.contains(&key) && places.len() < BROUGHT_NEARER {
            seen.push(key);
            places.push(place);
        }
    }
    for place in places {
        let Judged { left_um, suspicion } = &judged[place];
        let nearer = match suspicion.shift_ms {
            Some(shift_ms) => finer_shift(sampled, misfit_um, (*left_um, suspicion), shift_ms / 1e3),
            None => finer_place(thinned, misfit_um, (*left_um, suspicion)),
        };
        if let Some(nearer) = nearer {
            judged[place] = nearer;
        }
    }
}

/// A shift in time brought nearer to its true size than the grid; `None` where nothing lowers the misfit.
fn finer_shift(
    sampled: Sampled<'_>,
    misfit_um: impl Fn(&Session) -> Option<f64> + Sync,
    (left_um, suspicion): (f64, &Suspicion),
    seconds: f64,
) -> Option<Judged> {
    let whole = sampled.all_rows;
    let is_struck = |test: &usize| suspicion.tests.is_empty() || suspicion.tests.contains(&whole.tests[*test].name);
    let struck: Vec<usize> = (0..whole.tests.len()).filter(is_struck).collect();
    let moved = |seconds: f64| Some(shifted(sampled, &struck, seconds));
    descended((left_um, seconds), FINER_SHARE.map(|share| share * seconds.abs()), moved, misfit_um).map(Judged::from)
}

/// An axis brought nearer to where it stood, or to what its column is off by, than the grid; `None` where nothing lowers the misfit,
/// and for other mistakes, which have no such size.
pub(crate) fn finer_place(
    thinned: &Session,
    misfit_um: impl Fn(&Session) -> Option<f64> + Sync,
    (left_um, suspicion): (f64, &Suspicion),
) -> Option<Judged> {
    let tests: Vec<usize> =
        (0..thinned.tests.len()).filter(|&test| suspicion.tests.contains(&thinned.tests[test].name)).collect();
    let axis = suspicion.components.first().and_then(|name| thinned.machine.axis_index(name));
    let (Some(axis), Some(&first), FaultKind::StandingAxis | FaultKind::ColumnShifted) =
        (axis, tests.first(), suspicion.kind)
    else {
        return None;
    };
    let stands = suspicion.kind == FaultKind::StandingAxis;
    let at = |session: &Session| match stands {
        true => session.tests[first].positions[axis].unwrap_or(0.0),
        false => first_position(session, first, axis).unwrap_or(0.0),
    };
    let moved = |shift: f64| match stands {
        true => stood_at(thinned, axis, &tests, shift),
        false => column_off(thinned, axis, &tests, shift),
    };
    let steps = match thinned.machine.axes[axis].kind {
        AxisKind::Rotary => FINER_DEG.map(f64::to_radians),
        AxisKind::Linear => FINER_MM,
    };
    descended((left_um, at(&suspicion.undone) - at(thinned)), steps, moved, misfit_um).map(Judged::from)
}

/// A mistake that has a size, with the misfit that undoing it leaves, µm.
pub(super) struct Sized {
    pub(super) misfit_um: f64,
    pub(super) size: f64,
    pub(super) suspicion: Suspicion,
}

impl From<Sized> for Judged {
    fn from(sized: Sized) -> Judged {
        Judged { left_um: sized.misfit_um, suspicion: sized.suspicion }
    }
}

/// A mistake of the size that leaves least, from a misfit in µm and a size, by steps to either side, each smaller than the last; `None` where
/// none lowers the misfit.
pub(super) fn descended<const N: usize>(
    from: (f64, f64),
    steps: [f64; N],
    moved: impl Fn(f64) -> Option<Suspicion> + Sync,
    misfit_um: impl Fn(&Session) -> Option<f64> + Sync,
) -> Option<Sized> {
    let mut best: Option<Sized> = None;
    for step in steps {
        let (least_um, size) = best.as_ref().map_or(from, |best| (best.misfit_um, best.size));
        let beside: Vec<Sized> = [-step, step]
            .into_par_iter()
            .filter_map(|step| {
                let (size, suspicion) = (size + step, moved(size + step)?);
                Some(Sized { misfit_um: misfit_um(&suspicion.undone)?, size, suspicion })
            })
            .collect();
        let less = beside.into_iter().filter(|beside| beside.misfit_um < least_um);
        best = less.min_by(|one, other| one.misfit_um.total_cmp(&other.misfit_um)).or(best);
    }
    best
}

/// Where an axis is in the first row of a test's recording.
pub(crate) fn first_position(session: &Session, test: usize, axis: usize) -> Option<f64> {
    let recording = session.tests[test].recording.as_ref()?;
    let column = recording.column_of(axis)?;
    recording.positions[column].first().copied()
}
