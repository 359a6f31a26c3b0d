//! The one number by which a finding is known: half width, height, amplitude, growth; with its uncertainty. It fits nothing.

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::finding::SizeFound;
use super::found::Candidate;
use super::ground::{Ground, Term};
use super::library::travelled;
use super::naming::{Cause, component_name, unit};
use super::stage::Stage;
use crate::effects::{WARM, kind};
use crate::machine::{AxisKind, Component, Effect, Machine, Outlet, ParameterValue};
use crate::units::Measure;

/// Size of a finding's leading effect; `parts` are the accepted columns of its terms, once for every shape whose
/// amplitudes add.
pub fn size_of(
    ground: &Ground,
    lead: &Candidate,
    cause: &Cause,
    stage: &Stage,
    covariance: &DMatrix<f64>,
    parts: &[Vec<usize>],
) -> SizeFound {
    let nuisance = ground.problem.unknowns.len();
    let count = lead.terms.len();
    let amplitudes: Vec<f64> = (0..count).map(|k| parts.iter().map(|part| stage.accepted(part[k])).sum()).collect();
    let sub = DMatrix::from_fn(count, count, |i, j| {
        let rows = parts.iter().flat_map(|one| parts.iter().map(move |other| (one[i], other[j])));
        rows.map(|(one, other)| covariance[(nuisance + one, nuisance + other)]).sum::<f64>()
    });
    // terms in the unit of the finding: lengths if it has any
    let main: Vec<usize> = main_terms(ground, &lead.effect, cause, &lead.terms);
    let measure = main.first().map_or(Measure::Length, |&k| lead.terms[k].measure);
    let prior = lead.judgement.tau.max(1.0);
    let variances: Vec<f64> = (0..count).map(|k| sub[(k, k)]).collect();
    let curves = Curves::of(ground, lead, &main);
    let value_at = |a: &[f64]| match cause.effect.as_str() {
        "vibration" => vibration(&lead.terms, a, &variances, prior),
        _ => size_function(lead, cause, &main, &curves, a),
    };
    let value = value_at(&amplitudes);
    let (value, sigma) = match cause.effect.as_str() {
        // many amplitudes of equal rank, none of them hidden
        "vibration" | "unknown" => (value, first_order(&value_at, &amplitudes, &sub)),
        _ => {
            // orders that placement takes up are left as they were fitted
            let held: Vec<bool> = lead.terms.iter().map(|term| is_once_per_turn(&lead.effect, term)).collect();
            // a jump may be any number of times longer along a direction that the recordings hide; placement takes up
            // most of a sag
            let is_slip = cause.effect.ends_with("-slip");
            let longer = if is_slip || cause.effect == "gravity-sag" { WIDENED } else { WIDER };
            let over = |longer: f64| drawn(&value_at, &amplitudes, &sub, &held, (HIDDEN * prior, longer));
            let spread = over(longer).unwrap_or((value, first_order(&value_at, &amplitudes, &sub)));
            // these have no favourite direction: the hidden part is likely as long as a seen one
            let even = match is_slip {
                true => over(1.0),
                false if curves.is_whole_turn => over(HIDDEN_ORDERS),
                false => None,
            };
            even.map_or(spread, |(value, _)| (value, spread.1))
        }
    };
    let is_part_of_turn = cause.effect == "rotary-error-motion" && !curves.is_whole_turn;
    let form = if is_part_of_turn { PART_OF_TURN } else { form_sigma(&cause.effect) };
    let sigma = sigma.hypot(form * value);
    let meaning = match cause.effect.as_str() {
        _ if grows(&lead.effect) => "peak to peak over the session",
        "straightness" => "height of the bump, or of the bow over its end points",
        "rotary-error-motion" if curves.is_whole_turn => {
            "largest of a component, without what turns once across the axis"
        }
        "rotary-error-motion" => "half the range of a component over the arc travelled",
        name => kind(name).map_or("largest", |kind| kind.size_meaning),
    };
    let meaning = meaning.to_string();
    SizeFound { value, sigma, unit: unit(measure), meaning }
}

/// First-order propagation of the amplitudes' covariance.
fn first_order(value_at: &impl Fn(&[f64]) -> f64, amplitudes: &[f64], covariance: &DMatrix<f64>) -> f64 {
    let gradient = DVector::from_iterator(
        amplitudes.len(),
        (0..amplitudes.len()).map(|k| {
            let step = covariance[(k, k)].sqrt().max(1e-6);
            let mut up = amplitudes.to_vec();
            up[k] += step;
            let mut down = amplitudes.to_vec();
            down[k] -= step;
            (value_at(&up) - value_at(&down)) / (2.0 * step)
        }),
    );
    (gradient.transpose() * covariance * &gradient)[(0, 0)].max(0.0).sqrt()
}

/// Share of the prior that a direction keeps when it is hidden, and the factors by which a jump or a sag, and another motion,
/// may then be larger.
const HIDDEN: f64 = 0.6;
const WIDENED: f64 = 2.5;
const WIDER: f64 = 1.5;
/// The same for orders of a whole turn: the largest of several components is a little more than a typical one.
const HIDDEN_ORDERS: f64 = 1.15;
/// Uncertainty of an error motion over part of a turn, as a share: what of it placement takes up differs from arc to arc.
const PART_OF_TURN: f64 = 0.25;
/// Arc that counts as a whole turn, rad.
const WHOLE_TURN: f64 = 1.8 * std::f64::consts::PI;
/// Draws of the amplitudes.
const DRAWS: usize = 120;

/// Mean and standard deviation of a size over what the amplitudes may be: motions that the recordings hide count with
/// what they may add. `None` where the covariance is not one.
fn drawn(
    value_at: &impl Fn(&[f64]) -> f64,
    amplitudes: &[f64],
    covariance: &DMatrix<f64>,
    held: &[bool],
    (hidden_from, longer): (f64, f64),
) -> Option<(f64, f64)> {
    let count = amplitudes.len();
    let eigen = SymmetricEigen::new(covariance.clone());
    let spread: Vec<f64> = eigen.eigenvalues.iter().map(|value| value.max(0.0).sqrt()).collect();
    // what is hidden is as large as what is seen
    let along = eigen.eigenvectors.tr_mul(&DVector::from_column_slice(amplitudes));
    let seen: Vec<f64> = (0..count).filter(|&k| spread[k] <= hidden_from).map(|k| along[k].powi(2)).collect();
    let typical = (seen.iter().sum::<f64>() / seen.len().max(1) as f64).sqrt();
    let spread: Vec<f64> =
        spread.into_iter().map(|own| if own > hidden_from { longer * own.min(typical) } else { own }).collect();
    // the symmetric root: it does not depend on the signs of the eigenvectors, which are chance
    let scales = DMatrix::from_diagonal(&DVector::from_vec(spread));
    let root = &eigen.eigenvectors * scales * eigen.eigenvectors.transpose();
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let sizes: Vec<f64> = (0..DRAWS)
        .map(|_| {
            let drawn = DVector::from_iterator(count, (0..count).map(|_| rng.sample::<f64, _>(StandardNormal)));
            let off = &root * drawn;
            let amplitudes: Vec<f64> = (0..count).map(|k| amplitudes[k] + if held[k] { 0.0 } else { off[k] }).collect();
            value_at(&amplitudes)
        })
        .collect();
    let mean = sizes.iter().sum::<f64>() / DRAWS as f64;
    let variance = sizes.iter().map(|size| (size - mean).powi(2)).sum::<f64>() / DRAWS as f64;
    mean.is_finite().then_some((mean, variance.sqrt()))
}

/// Whether a term turns once with its axis: pivots, balls and location errors take most of it up.
fn is_once_per_turn(effect: &Effect, term: &Term) -> bool {
    match effect.parameter("orders") {
        Some(ParameterValue::List(orders)) => orders.get(term.function / 2).is_some_and(|order| *order < 1.5),
        _ => false,
    }
}

/// Whether a candidate has the first order of a turn, which only whole turns show.
pub(super) fn has_first_order(candidate: &Candidate) -> bool {
    candidate.terms.iter().any(|term| is_once_per_turn(&candidate.effect, term))
}

/// Size of a candidate with the amplitudes that it was judged with.
pub fn size_as_judged(ground: &Ground, candidate: &Candidate, cause: &Cause) -> f64 {
    let main = main_terms(ground, &candidate.effect, cause, &candidate.terms);
    let curves = Curves::of(ground, candidate, &main);
    size_function(candidate, cause, &main, &curves, &candidate.judgement.amplitudes)
}

/// Uncertainty of a size from the form of its effect, as a share: a form is never exact, a vibration breathes, a screw's
/// period swells along its travel, and the peak of a spike lies between two readings.
fn form_sigma(effect: &str) -> f64 {
    match effect {
        "reversal-spike" => 0.12,
        "vibration" => 0.06,
        "cyclic-error" => 0.07,
        _ => 0.03,
    }
}

/// Whether a term moves along a direction, per kelvin or not.
pub(super) fn is_length(term: &Term) -> bool {
    matches!(term.measure, Measure::Length | Measure::LengthPerKelvin)
}

/// Where growth along its own axis shows; `None` for other effects.
fn along_its_axis(machine: &Machine, effect: &Effect) -> Option<Outlet> {
    let axis = effect.place.axis().filter(|_| effect.kind == "thermal-growth")?;
    Some(match machine.axes[axis].kind {
        AxisKind::Linear => Outlet::own(machine, axis),
        AxisKind::Rotary => {
            let along = Component::ALL[machine.axes[axis].own_component().direction_index()];
            Outlet::Motion { axis, component: along }
        }
    })
}

/// The same where it is told: growth to the side alone has its own size.
fn told_along_its_axis(machine: &Machine, effect: &Effect, cause: &Cause) -> Option<Outlet> {
    along_its_axis(machine, effect).filter(|along| cause.components.contains(&component_name(machine, along)))
}

/// Terms that carry the size: of a lag the lag, of what grows the growth along its axis, else lengths where there are any,
/// else all.
fn main_terms(ground: &Ground, effect: &Effect, cause: &Cause, terms: &[Term]) -> Vec<usize> {
    let of = |outlet: &dyn Fn(&Outlet) -> bool| -> Vec<usize> {
        (0..terms.len()).filter(|&k| outlet(&terms[k].outlet)).collect()
    };
    let lags = of(&|outlet| matches!(outlet, Outlet::Lag { .. }));
    if !lags.is_empty() {
        return lags;
    }
    let machine = ground.context.machine();
    let along = told_along_its_axis(machine, effect, cause);
    let growth = of(&|outlet| Some(*outlet) == along);
    if !growth.is_empty() {
        return growth;
    }
    let lengths: Vec<usize> = (0..terms.len()).filter(|&k| is_length(&terms[k])).collect();
    if lengths.is_empty() { (0..terms.len()).collect() } else { lengths }
}

/// Share of an amplitude that the readings must tell.
const LEAST_KNOWN: f64 = 0.3;

/// Amplitude over tests that have a cosine and a sine each, weighted by how well each is known: some tests hardly show it.
/// Directions at right angles, and the degrees in which an amplitude wanders, add as their squares.
fn vibration(terms: &[Term], amplitudes: &[f64], variances: &[f64], prior: f64) -> f64 {
    // by outlet and degree: weighted squares and weights
    let mut parts: Vec<((Outlet, usize), f64, f64)> = Vec::new();
    for ((term, amplitude), variance) in terms.iter().zip(amplitudes).zip(variances) {
        // share that the readings have in an amplitude, the prior the rest
        let known = 1.0 - variance / (prior * prior);
        if known < LEAST_KNOWN {
            continue;
        }
        // without the prior's pull; noise alone has a square as well
        let weight = known / variance.max(f64::MIN_POSITIVE);
        let square = weight * (amplitude / known).powi(2) - 1.0;
        let key = (term.outlet, term.function / 2);
        match parts.iter_mut().find(|(part, ..)| *part == key) {
            Some((_, squares, sum)) => (*squares, *sum) = (*squares + square, *sum + weight),
            None => parts.push((key, square, weight)),
        }
    }
    // mean square of a Legendre polynomial
    let share = |degree: usize| 1.0 / (2 * degree + 1) as f64;
    let squares =
        parts.iter().map(|((_, degree), squares, weights)| share(*degree) * (2.0 * squares / weights).max(0.0));
    squares.sum::<f64>().sqrt()
}

/// Whether an effect goes on with time or temperature.
fn grows(effect: &Effect) -> bool {
    ["tau", "channel"].iter().any(|parameter| effect.parameter(parameter).is_some())
}

/// The size for given amplitudes (display units).
fn size_function(lead: &Candidate, cause: &Cause, main: &[usize], curves: &Curves, amplitudes: &[f64]) -> f64 {
    match cause.effect.as_str() {
        // a height of 1 at the centre, whether or not a test stood there
        "straightness" if is_bump(lead, main) && curves.hold(lead) => curves
            .by_outlet
            .iter()
            .map(|terms| terms.iter().map(|(k, _)| amplitudes[*k].abs()).sum())
            .fold(0.0, f64::max),
        "rotary-error-motion" => {
            // what turns once across or about the axis is its own location and the placement of balls; along it, it is not
            let is_taken_up = |k: usize| {
                curves.is_whole_turn
                    && Some(lead.terms[k].outlet) != curves.along
                    && is_once_per_turn(&lead.effect, &lead.terms[k])
            };
            let without: Vec<f64> =
                (0..amplitudes.len()).map(|k| if is_taken_up(k) { 0.0 } else { amplitudes[k] }).collect();
            curves.largest(cause, &without)
        }
        "straightness" | "unknown" | "thermal-growth" | "reversal-spike" | "lateral-play" => {
            curves.largest(cause, amplitudes)
        }
        // the first period is the effect, the others are its form
        "cyclic-error" => {
            let first = main.iter().filter(|&&k| lead.terms[k].function < 2);
            first.map(|&k| amplitudes[k].powi(2)).sum::<f64>().sqrt()
        }
        "gravity-sag" | "arrival-lag" => curves.largest(cause, amplitudes),
        "bar-length" if grows(&lead.effect) => curves.largest(cause, amplitudes),
        _ => main.iter().map(|&k| amplitudes[k].powi(2)).sum::<f64>().sqrt(),
    }
}

/// Whether the main terms are the height of one bump.
fn is_bump(lead: &Candidate, main: &[usize]) -> bool {
    lead.effect.parameter("width").is_some() && main.iter().all(|&k| lead.terms[k].measure == Measure::Length)
}

/// Functions of the terms over the rows in which the place's axis moves (all rows for other places), by outlet.
struct Curves {
    outlets: Vec<Outlet>,
    by_outlet: Vec<Vec<(usize, Vec<f64>)>>,
    /// Positions of the place's axis in the same rows; empty for other places and for turns.
    positions: Vec<f64>,
    /// The part did not begin at rest.
    settles: bool,
    /// Orders over a whole turn, which have means; part of a turn has none.
    is_whole_turn: bool,
    /// By term, whether it is the cosine of an order.
    is_cosine: Vec<bool>,
    /// Motion along the joint's axis.
    along: Option<Outlet>,
}

/// Whether a part leaves a first state that nobody knows.
pub(super) fn settles(effect: &Effect) -> bool {
    matches!(effect.parameter("begins"), Some(ParameterValue::Word(state)) if state == WARM)
}

/// The curve that an outlet follows.
fn curve(terms: &[(usize, Vec<f64>)], amplitudes: &[f64]) -> Vec<f64> {
    let mut curve = vec![0.0; terms.first().map_or(0, |(_, rows)| rows.len())];
    for (k, rows) in terms {
        curve.iter_mut().zip(rows).for_each(|(sum, value)| *sum += amplitudes[*k] * value);
    }
    curve
}

/// Takes the line through its end points off a curve over the positions that an axis took, standing or moving, as in the
/// end-point reference of ISO 230-1: what is left is told by its largest distance from that line.
fn take_end_points_off(curve: &mut [f64], positions: &[f64]) {
    let rows = || positions.iter().zip(curve.iter()).map(|(q, value)| (*q, *value));
    let first = rows().min_by(|a, b| a.0.total_cmp(&b.0));
    let last = rows().max_by(|a, b| a.0.total_cmp(&b.0));
    let (Some((from, begins)), Some((to, ends))) = (first, last) else { return };
    let slope = if to > from { (ends - begins) / (to - from) } else { 0.0 };
    curve.iter_mut().zip(positions).for_each(|(value, q)| *value -= begins + slope * (q - from));
}

fn low_and_high(curve: &[f64]) -> (f64, f64) {
    curve.iter().fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(*value), high.max(*value)))
}

/// Share of the largest range from which a motion of what grows is told.
const GROWS_WITH: f64 = 0.15;

/// Motions that growth in one or several shapes shows in, that along its axis first and then by their ranges over the
/// readings (display units): amplitudes of nodes may cancel, and a node may have settled before the first reading.
pub(super) fn growing_outlets(ground: &Ground, parts: &[(&Candidate, Vec<f64>)]) -> Vec<Outlet> {
    let range = |curve: &[f64]| {
        let (low, high) = low_and_high(curve);
        (high - low).max(0.0)
    };
    let curves = growth_curves(ground, parts);
    let mut ranges: Vec<(Outlet, f64)> = curves.iter().map(|(outlet, curve)| (*outlet, range(curve))).collect();
    ranges.sort_by(|a, b| b.1.total_cmp(&a.1));
    let largest = ranges.first().map_or(0.0, |(_, range)| *range);
    ranges.retain(|(_, range)| *range >= GROWS_WITH * largest);
    let along = parts.first().and_then(|(lead, _)| along_its_axis(ground.context.machine(), &lead.effect));
    // the size is that of the first one
    ranges.sort_by_key(|(outlet, _)| Some(*outlet) != along);
    ranges.into_iter().map(|(outlet, _)| outlet).collect()
}

/// Growth of several shapes together, peak to peak: along its axis where that is told, else the largest one.
pub(super) fn growth(ground: &Ground, parts: &[(&Candidate, Vec<f64>)], cause: &Cause) -> f64 {
    let machine = ground.context.machine();
    let along = parts.first().and_then(|(lead, _)| told_along_its_axis(machine, &lead.effect, cause));
    let settles = parts.iter().any(|(part, _)| settles(&part.effect));
    let measured = |outlet: &Outlet| match along {
        Some(along) => *outlet == along,
        None => outlet.measure(machine) == Measure::Length,
    };
    let curves = growth_curves(ground, parts);
    let sizes =
        curves.iter().filter(|(outlet, _)| measured(outlet)).map(|(_, curve)| grown(low_and_high(curve), settles));
    sizes.fold(0.0, f64::max)
}

/// Growth from the ends of its course: from the session's beginning, where it is zero by form; how a part left its first
/// state before the first reading is known to nobody.
fn grown((low, high): (f64, f64), settles: bool) -> f64 {
    if settles { high - low } else { high.max(0.0) - low.min(0.0) }
}

/// Course of every motion over the readings, summed over the shapes (display units).
fn growth_curves(ground: &Ground, parts: &[(&Candidate, Vec<f64>)]) -> Vec<(Outlet, Vec<f64>)> {
    let mut sums: Vec<(Outlet, Vec<f64>)> = Vec::new();
    for (part, amplitudes) in parts {
        let all: Vec<usize> = (0..part.terms.len()).collect();
        let curves = Curves::of(ground, part, &all);
        for (outlet, terms) in curves.outlets.iter().zip(&curves.by_outlet) {
            let own = curve(terms, amplitudes);
            match sums.iter_mut().find(|(other, _)| other == outlet) {
                Some((_, sum)) => sum.iter_mut().zip(&own).for_each(|(sum, value)| *sum += value),
                None => sums.push((*outlet, own)),
            }
        }
    }
    sums
}

impl Curves {
    fn of(ground: &Ground, lead: &Candidate, main: &[usize]) -> Curves {
        // bars that grow in proportion to their lengths: the size is the longest one's
        let effect = match lead.effect.parameter("growing") {
            Some(_) => &lead.effect.clone().with("growing", ParameterValue::Word("alike".into())),
            None => &lead.effect,
        };
        let settles = settles(&lead.effect);
        let turns = lead.effect.place.axis().and_then(|axis| travelled(ground, axis));
        let is_whole_turn = has_first_order(lead) && turns.is_some_and(|(from, to)| to - from > WHOLE_TURN);
        let is_cosine: Vec<bool> = lead.terms.iter().map(|term| term.function % 2 == 0).collect();
        let along = lead.effect.place.axis().map(|axis| Outlet::Motion {
            axis,
            component: Component::ALL[ground.context.machine().axes[axis].own_component().direction_index()],
        });
        let Ok(profiles) = ground.profiles(effect) else {
            return Curves {
                outlets: Vec::new(),
                by_outlet: Vec::new(),
                positions: Vec::new(),
                settles,
                is_whole_turn,
                is_cosine,
                along,
            };
        };
        // one axis may move as another one drives it
        let driving = match lead.effect.parameter("of") {
            Some(ParameterValue::Word(name)) => ground.context.machine().axis_index(name),
            _ => None,
        };
        let axis = driving.or(lead.effect.place.axis());
        // a joint that stands still sags as the one that carries it tilts
        let everywhere =
            matches!(lead.effect.kind.as_str(), "thermal-growth" | "straightness" | "bar-length" | "gravity-sag");
        let counts =
            |test: &usize| everywhere || axis.is_none_or(|axis| ground.context.motion(*test).moving.contains(&axis));
        let tests: Vec<usize> = (0..ground.tests()).filter(counts).collect();
        let function = |k: usize| -> Vec<f64> {
            let mut rows = Vec::new();
            for &test in &tests {
                let profile = &profiles[lead.terms[k].function][test];
                let count = ground.residual_mm[test].len();
                if profile.is_empty() { rows.resize(rows.len() + count, 0.0) } else { rows.extend_from_slice(profile) }
            }
            rows
        };
        let mut outlets: Vec<Outlet> = Vec::new();
        let mut by_outlet: Vec<Vec<(usize, Vec<f64>)>> = Vec::new();
        for &k in main {
            let outlet = lead.terms[k].outlet;
            let place = outlets.iter().position(|other| *other == outlet).unwrap_or_else(|| {
                outlets.push(outlet);
                by_outlet.push(Vec::new());
                outlets.len() - 1
            });
            by_outlet[place].push((k, function(k)));
        }
        let positions =
            |axis: usize| tests.iter().flat_map(move |&test| ground.context.motion(test).axis(axis)).collect();
        let is_length = |outlet: &Outlet| outlet.measure(ground.context.machine()) == Measure::Length;
        let of_axis = lead.effect.place.axis().filter(|_| outlets.iter().all(is_length));
        let positions = of_axis.map(positions).unwrap_or_default();
        Curves { outlets, by_outlet, positions, settles, is_whole_turn, is_cosine, along }
    }

    /// Whether a bump is narrower than the travel: a wider one is a bow, whose top may lie where nothing went.
    fn hold(&self, bump: &Candidate) -> bool {
        let (from, to) = low_and_high(&self.positions);
        let width = bump.effect.number("width");
        self.positions.is_empty() || width.is_none_or(|width| width <= to - from)
    }

    /// Largest value, or range, of the curves that the outlets follow over the session.
    fn largest(&self, cause: &Cause, amplitudes: &[f64]) -> f64 {
        let size = |terms: &Vec<(usize, Vec<f64>)>| -> f64 {
            let mut curve = curve(terms, amplitudes);
            if cause.effect == "straightness" {
                take_end_points_off(&mut curve, &self.positions);
            }
            let (low, high) = low_and_high(&curve);
            if low > high {
                return 0.0;
            }
            match cause.effect.as_str() {
                "thermal-growth" | "bar-length" => grown((low, high), self.settles),
                "rotary-error-motion" if self.is_whole_turn => {
                    // orders count from zero at the axis's zero: their mean over a turn is less the cosines'
                    let cosines = terms.iter().filter(|(k, _)| self.is_cosine[*k]);
                    let mean: f64 = -cosines.map(|(k, _)| amplitudes[*k]).sum::<f64>();
                    (high - mean).max(mean - low)
                }
                "rotary-error-motion" | "unknown" => 0.5 * (high - low),
                _ => high.abs().max(low.abs()),
            }
        };
        self.by_outlet.iter().map(size).fold(0.0, f64::max)
    }
}
