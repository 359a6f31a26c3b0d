//! Whether a fit fits and its readings can be judged at all: noise, outliers, and what was stated of set-up and machine. It names no mistake.

use super::quick_fit::{LEAST_SPREAD_MM, MOST_STRAIN};
use crate::identify::{Estimate, Fit, FreePrior, Quantity, TestFit, Unknown};
use crate::session::{Recording, Session, Setups, Test};
use crate::statistics::{median, noise_of_rows};
use statrs::function::erf::erfc;
use std::f64::consts::SQRT_2;

/// Noise from row to row above which readings cannot be judged, µm. Makers of ball bars state 0.5 to 1 µm for the gauge and
/// 0.1 µm for its resolution: ten times the worst of it is a loose ball, a bad contact or another unit.
pub(crate) const MOST_NOISE_UM: f64 = 10.0;

/// The same for lengths that no bar measured, µm: laser trackers and draw wires.
const MOST_NOISE_WITHOUT_BAR_UM: f64 = 100.0;

/// Share of readings far from their neighbours above which the others are not to be trusted either: sound recordings have
/// a few in a thousand, and from one in ten on they hide each other.
const MOST_LEFT_OUT: f64 = 0.05;

/// A location error so many of its widest plausible sizes (1 mm and 0.1° on machine tools) is none.
const MOST_LOCATION: f64 = 3.0;

/// Residual that no physics of a working machine leaves, as a share of the largest plausible location error: 0.1 mm on
/// machine tools, ten times what the worst in the catalogue's trials leave; 2 mm on arms.
const MOST_RESIDUAL: f64 = 0.1;

/// Noise of readings from row to row, µm, whatever the model: of the middle one of the sweeps. `None` for static poses, which
/// have no neighbours.
pub(crate) fn repeats_um(session: &Session, fit: &Fit) -> Option<f64> {
    let runs = session.tests.iter().map(|test| test.recording.as_ref().is_some_and(Recording::is_run));
    let sweeps = fit.tests.iter().zip(runs).filter(|(_, is_run)| *is_run);
    median(sweeps.map(|(test, _)| 1e3 * noise_of_rows(&test.residual_mm)))
}

/// Why nothing is to be learnt from these readings; `None` where they can be judged.
pub(crate) fn unjudged(session: &Session, fit: &Fit) -> Option<String> {
    let has_bar = session.tests.iter().any(|test| test.bar_length_mm.is_some());
    let limit = if has_bar { MOST_NOISE_UM } else { MOST_NOISE_WITHOUT_BAR_UM };
    let mut reasons = Vec::new();
    if let Some(noise_um) = repeats_um(session, fit).filter(|noise_um| *noise_um > limit) {
        reasons.push(format!(
            "readings scatter by {noise_um:.0} µm from row to row, where a gauge in order stays below {limit:.0} µm"
        ));
    }
    let share = fit.left_out_share();
    if share > MOST_LEFT_OUT {
        let left_out = fit.left_out();
        reasons.push(format!(
            "{left_out} readings ({:.0} %) lie far from their neighbours, where more than {:.0} % make the others doubtful",
            100.0 * share,
            100.0 * MOST_LEFT_OUT
        ));
    }
    let cure = match session.has_parts() {
        true => "; look after instruments, targets and sockets, and the units of the columns, and record again",
        false => {
            "; look after the gauge, its balls and magnets and its connection, and the unit of length_mm, and record again"
        }
    };
    (!reasons.is_empty()).then(|| reasons.join(", and ") + cure)
}

/// What a fit left or moved beyond what noise, stated spreads and a working machine allow; `None` for a fit that fits.
pub(crate) fn misfit(session: &Session, fit: &Fit) -> Option<String> {
    let prior = FreePrior::of(&session.machine);
    // without a bar between balls nothing says what else the residual may be: only what no chain explains is refused
    let share = if session.has_parts() { 1.0 } else { MOST_RESIDUAL };
    let allowed_um = 1e3 * share * prior.length_mm;
    let rms_um = 1e3 * fit.rms_mm;
    if rms_um > allowed_um {
        let noise = match repeats_um(session, fit) {
            Some(noise_um) => format!("readings repeat to {noise_um:.1} µm from row to row and "),
            None => String::new(),
        };
        return Some(format!(
            "the model leaves {rms_um:.0} µm rms, where {noise}a machine that works leaves less than {allowed_um:.0} µm"
        ));
    }
    if let Some(says) = misfit_of_distances(session, fit) {
        return Some(says);
    }
    let farthest = fit
        .unknowns
        .iter()
        .zip(&fit.estimates)
        .map(|(unknown, estimate)| {
            let off = (estimate.value - unknown.prior_mean).abs();
            let (allowed, most) = match unknown.quantity {
                Quantity::Location { .. } => (unknown.prior_sigma, MOST_LOCATION),
                _ => (unknown.prior_sigma.max(LEAST_SPREAD_MM), MOST_STRAIN),
            };
            (off / (most * allowed), off, unknown)
        })
        .max_by(|a, b| a.0.total_cmp(&b.0));
    farthest.filter(|(ratio, ..)| *ratio > 1.0).map(|(_, off, unknown)| {
        let measure = unknown.measure;
        format!(
            "the fit puts {} {:.0} {} from where the files put it, beyond what their spreads allow",
            unknown.label,
            measure.to_output(off),
            measure.shown_unit()
        )
    })
}

/// The known distance of two sockets that a fit leaves farthest from what the session states, beyond what its spread allows.
fn misfit_of_distances(session: &Session, fit: &Fit) -> Option<String> {
    let of = |(test, fitted): (&Test, &TestFit)| {
        let spread_mm = test.reading.part().filter(|_| test.reading.is_gap())?.noise_mm?.max(LEAST_SPREAD_MM);
        let off_mm = fitted.residual_mm.iter().copied().find(|off| off.is_finite())?.abs();
        Some((off_mm / spread_mm, off_mm, test.stated_name().to_string()))
    };
    let distances = session.tests.iter().zip(&fit.tests).filter_map(of);
    let (ratio, off_mm, name) =
        distances.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(ratio, ..)| *ratio > MOST_STRAIN)?;
    Some(format!(
        "the fit leaves the distance {name} {:.0} µm from what the session states, {ratio:.1} times its spread: that distance, another one, or \
         which socket a test was recorded in is wrong",
        1e3 * off_mm
    ))
}

/// Readings more than unknowns that they tell, from which the noise that they leave is known: of ten its σ to 22 %.
const LEAST_REDUNDANCY: f64 = 10.0;

/// Too few readings to know noise, and σ with it, in words.
pub(crate) fn too_few(fit: &Fit) -> Option<String> {
    let readings = fit.readings();
    let told = fit
        .unknowns
        .iter()
        .enumerate()
        .map(|(k, unknown)| 1.0 - (fit.covariance[(k, k)] / unknown.prior_sigma.powi(2)).clamp(0.0, 1.0))
        .sum::<f64>();
    (readings as f64 - told < LEAST_REDUNDANCY).then(|| {
        format!(
            "{readings} readings tell {told:.0} unknowns: what they leave does not say how well, so no error is called determined; record more of \
             them, {LEAST_REDUNDANCY:.0} more than unknowns at least"
        )
    })
}

/// Spread of a ball's place below which none is known, µm: the best balls are out of round by more (ISO 3290-1, grade 3: 0.08 µm).
const LEAST_KNOWN_UM: f64 = 0.05;

/// A ball that is stated to be where no ball is known to be, in words: errors take up what it may not.
pub(crate) fn known_too_well(session: &Session) -> Option<String> {
    if session.has_parts() {
        return None;
    }
    let setups = Setups::of(session);
    let balls = setups.pivots.iter().chain(&setups.spindle_balls);
    let best = balls.min_by(|one, other| one.spread_mm.total_cmp(&other.spread_mm))?;
    let stated_um = 1e3 * best.spread_mm;
    (stated_um < LEAST_KNOWN_UM).then(|| {
        format!(
            "the spread of {} is stated as {stated_um:.1e} µm, where balls themselves are round to some hundredths: every σ would hold only with \
             that, so no error is called determined; look after the unit, or state the spread that is true",
            best.label
        )
    })
}

/// Residual, in noise from row to row, that gauges and set-ups do not leave: of 290 simulated sessions without an effect, with white
/// noise, a zero that drifts and cups that settle, the largest left 2.8.
const LEFT_OVER: f64 = 3.0;

/// Noise of readings that repeat better than a gauge resolves, µm.
const RESOLVED_UM: f64 = 0.1;

/// What a fit leaves that readings of the same machine would not, in words: something beside the errors that were fitted acts, and
/// moves them by more than their σ says. Readings between which nothing repeats say nothing of it.
pub(crate) fn left_over(session: &Session, fit: &Fit) -> Option<String> {
    let left_um = 1e3 * fit.rms_mm;
    let repeats_um = exceeded_repeats_um(session, fit, left_um)?;
    Some(format!(
        "the fit leaves {left_um:.2} µm rms where readings repeat to {repeats_um:.2} µm: something beside these errors acts and may \
         have moved them by more than their σ, so none is called determined; run 'diagnose' to find it"
    ))
}

/// To what readings repeat from row to row, µm, where a model leaves far more, `left_um`; `None` where it does not.
pub(crate) fn exceeded_repeats_um(session: &Session, fit: &Fit, left_um: f64) -> Option<f64> {
    repeats_um(session, fit).filter(|repeats_um| exceeds(left_um, *repeats_um))
}

/// Whether more is left, µm, than gauges and set-ups leave of readings that repeat to so much.
pub(crate) fn exceeds(left_um: f64, repeats_um: f64) -> bool {
    left_um > LEFT_OVER * repeats_um.max(RESOLVED_UM)
}

/// Chance with which any ball or bar of a sound session is so far from its stated place as the one that makes a fit doubtful.
const BY_CHANCE: f64 = 1e-3;

/// A stated place of a ball, a bar or a zero, and what readings say of it, in units of its spread.
pub(crate) struct Place<'a> {
    pub(crate) unknown: &'a Unknown,
    /// How far from where it was stated, with its variance.
    pub(crate) off: f64,
    pub(crate) variance: f64,
    /// The spread under which both were found, in those stated.
    pub(crate) widened: f64,
}

impl Place<'_> {
    /// How far it is, in standard deviations of what a sound session shows: the stated spread, and what readings leave open.
    fn strain(&self) -> f64 {
        // the share that readings take away of what was thought possible; without it they say nothing
        let told = 1.0 - self.variance;
        let by_readings = self.off / told;
        let expected = self.widened.powi(-2) + self.variance / told;
        if told > LEAST_TOLD { by_readings.abs() / expected.sqrt() } else { 0.0 }
    }
}

/// The place that lies farther from where it was stated than in a sound session, in words: errors are determined only as well as what
/// was stated of balls and bars is true.
pub(crate) fn strained_among(places: &[Place]) -> Option<String> {
    let farthest = places.iter().max_by(|one, other| one.strain().total_cmp(&other.strain()))?;
    let by_chance = places.len() as f64 * erfc(farthest.strain() / SQRT_2);
    let (unknown, measure) = (farthest.unknown, farthest.unknown.measure);
    (by_chance < BY_CHANCE).then(|| {
        format!(
            "the fit stands only with {} {:.1} {} from where the session puts it, {:.1} times its spread: that place, a bar, a zero, an axis \
             that stood or some readings are not what the session says, so no error is called determined; correct it, or state the spread that is true",
            unknown.label,
            measure.to_output(farthest.off * unknown.prior_sigma),
            measure.shown_unit(),
            (farthest.off * farthest.widened).abs()
        )
    })
}

/// The same of a fit with the spreads as stated.
pub(crate) fn strained(fit: &Fit) -> Option<String> {
    let setups = fit.unknowns.iter().zip(&fit.estimates).filter(|(unknown, _)| unknown.quantity.is_setup());
    let of = |(unknown, estimate): (_, &Estimate)| {
        let unknown: &Unknown = unknown;
        let off = (estimate.value - unknown.prior_mean) / unknown.prior_sigma;
        Place { unknown, off, variance: (estimate.sigma / unknown.prior_sigma).powi(2), widened: 1.0 }
    };
    strained_among(&setups.map(of).collect::<Vec<_>>())
}

/// Share of a spread's variance that readings take away at least where they say anything of a place.
const LEAST_TOLD: f64 = 0.01;

/// A setup so many spreads off is warned of.
const WARNED_STRAIN: f64 = 3.0;

/// Share of readings left out that is warned of.
const WARNED_LEFT_OUT: f64 = 0.01;

/// A location error of this share of its widest plausible size is warned of: 0.3 mm and 0.03° on machine tools, where tens of
/// micrometres and arcseconds are usual.
const WARNED_LOCATION: f64 = 0.3;

/// Standard deviations from which a location error is that large, and not perhaps.
const FAR_BY_SIGMAS: f64 = 3.0;

/// What a user should look at although the fit stands.
pub(crate) fn warnings(fit: &Fit) -> Vec<String> {
    let setups = fit.unknowns.iter().zip(&fit.estimates).filter(|(unknown, _)| unknown.quantity.is_setup());
    let strained = setups.filter_map(|(unknown, estimate)| {
        let strain = (estimate.value / unknown.prior_sigma).abs();
        (strain > WARNED_STRAIN).then(|| {
            format!(
                "{} is off by {strain:.1} times its spread: check the session, or state a wider spread",
                unknown.label
            )
        })
    });
    let share = fit.left_out_share();
    let outliers = (share > WARNED_LEFT_OUT).then(|| {
        format!("{:.1} % of the readings were left out as gross outliers: look after the gauge", 100.0 * share)
    });
    strained.chain(outliers).chain(far(fit)).collect()
}

/// Why nothing is determined where a location error is larger than those of machines in use.
pub(crate) fn displaced(fit: &Fit) -> Option<String> {
    far(fit).into_iter().next().map(|says| format!("{says}; correct that first, no error is called determined"))
}

/// Location errors that are larger than those of machines in use, in words: something else stands elsewhere than the files say, or that line
/// does, and then it is to be stated first.
fn far(fit: &Fit) -> Vec<String> {
    let located = fit.unknowns.iter().zip(&fit.estimates).filter(|(unknown, _)| !unknown.quantity.is_setup());
    let far = located.filter_map(|(unknown, estimate)| {
        let off = estimate.value - unknown.prior_mean;
        let is_far = matches!(unknown.quantity, Quantity::Location { .. })
            && off.abs() > WARNED_LOCATION * unknown.prior_sigma
            && off.abs() > FAR_BY_SIGMAS * estimate.sigma;
        let measure = unknown.measure;
        is_far.then(|| {
            format!(
                "{} of {:.0} {} is more than machines in use have: it may as well be a ball or the line of the axis that stands \
                 elsewhere than the files say",
                unknown.label,
                measure.to_output(off),
                measure.shown_unit()
            )
        })
    });
    far.collect()
}
