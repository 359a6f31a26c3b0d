//! Courses that the motions of an effect take over the readings, and what of them is told. It fits nothing.

use std::f64::consts::TAU;

use crate::diagnose::cause::Cause;
use crate::diagnose::model::linear_model::{LinearModel, Term};
use crate::diagnose::selection::naming::component_name;
use crate::diagnose::selection::selected::Candidate;
use crate::effects::Signature::{BarLength, ErrorMotion, FreeCurve, Growth, Sag, Straightness};
use crate::effects::{Signature, WARM, is_a, signature, wave_numbers};
use crate::machine::{AxisKind, Component, Effect, Machine, Outlet, ParameterValue};
use crate::units::Measure;

/// Whether an effect goes on with time or temperature.
pub(crate) fn grows(effect: &Effect) -> bool {
    ["tau", "channel"].iter().any(|parameter| effect.parameter(parameter).is_some())
}

/// Where growth along its own axis shows; `None` for other effects.
fn along_its_axis(machine: &Machine, effect: &Effect) -> Option<Outlet> {
    let axis = effect.place.axis().filter(|_| is_a(&effect.kind, Signature::Growth))?;
    Some(match machine.axes[axis].kind {
        AxisKind::Linear => Outlet::own(machine, axis),
        AxisKind::Rotary => axial(machine, axis),
    })
}

/// Motion of an axis along the line that it moves or turns on.
fn axial(machine: &Machine, axis: usize) -> Outlet {
    Outlet::Motion { axis, component: Component::ALL[machine.axes[axis].own_component().direction_index()] }
}

/// The same where it is told: growth to the side alone has its own size.
pub(crate) fn told_along_its_axis(machine: &Machine, effect: &Effect, cause: &Cause) -> Option<Outlet> {
    along_its_axis(machine, effect).filter(|along| cause.components.contains(&component_name(machine, along)))
}

/// Whether a term turns once with its axis: pivots, balls and location errors take most of it up.
pub(crate) fn is_once_per_turn(effect: &Effect, term: &Term) -> bool {
    match effect.parameter("orders") {
        Some(ParameterValue::List(orders)) => orders.get(term.function / 2).is_some_and(|order| *order < 1.5),
        _ => false,
    }
}

/// Whether a candidate has the first order of a turn, which only whole turns show.
pub(crate) fn has_first_order(candidate: &Candidate) -> bool {
    candidate.terms.iter().any(|term| is_once_per_turn(&candidate.effect, term))
}

/// Arc that counts as a whole turn, rad.
const WHOLE_TURN: f64 = 1.8 * std::f64::consts::PI;
/// What a motion is over the rows: the terms that add to it, each with its function.
type Parts = Vec<(usize, Vec<f64>)>;

/// Courses of the terms over the rows in which the place's axis moves (all rows for other places), by outlet.
#[derive(Default)]
pub(crate) struct Trajectories {
    by_outlet: Vec<(Outlet, Parts)>,
    /// Positions of the place's axis in the same rows; empty for other places and for turns.
    positions: Vec<f64>,
    /// Lowest and highest position of the place's axis there, mm or rad.
    travel: Option<(f64, f64)>,
    /// The part did not begin at rest.
    settles: bool,
    /// By term; `None` on part of a turn, whose orders have no means.
    orders: Option<Vec<OrderTerm>>,
}

/// A term of an order over a whole turn.
struct OrderTerm {
    is_cosine: bool,
    /// It turns once.
    is_first: bool,
    /// It turns once across or about the axis: that is the axis's own location and the placement of balls. Along the axis
    /// nothing else does.
    is_taken_up: bool,
}

/// Whether a part leaves a first state that nobody knows.
pub(crate) fn settles(effect: &Effect) -> bool {
    let is_warm = matches!(effect.parameter("begins"), Some(ParameterValue::Word(state)) if state == WARM);
    is_warm || effect.number("warmth").is_some()
}

/// The course of a motion.
fn course(parts: &[(usize, Vec<f64>)], amplitudes: &[f64]) -> Vec<f64> {
    let mut course = vec![0.0; parts.first().map_or(0, |(_, rows)| rows.len())];
    for (k, rows) in parts {
        course.iter_mut().zip(rows).for_each(|(sum, value)| *sum += amplitudes[*k] * value);
    }
    course
}

/// Takes the line through its end points off a course over the positions that an axis took, standing or moving, as in the
/// end-point reference of ISO 230-1: what is left is told by its largest distance from that line.
fn take_end_points_off(course: &mut [f64], positions: &[f64]) {
    let rows = || positions.iter().zip(course.iter()).map(|(q, value)| (*q, *value));
    let first = rows().min_by(|a, b| a.0.total_cmp(&b.0));
    let last = rows().max_by(|a, b| a.0.total_cmp(&b.0));
    let (Some((from, begins)), Some((to, ends))) = (first, last) else { return };
    let slope = if to > from { (ends - begins) / (to - from) } else { 0.0 };
    course.iter_mut().zip(positions).for_each(|(value, q)| *value -= begins + slope * (q - from));
}

fn low_and_high(course: &[f64]) -> (f64, f64) {
    course.iter().fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(*value), high.max(*value)))
}

/// Waves that drift apart by less than this over a travel are one, rad: a turn.
const ONE_WAVE: f64 = TAU;
/// Places along a travel at which a wave is looked at.
const PLACES: usize = 32;

/// Share of the largest range from which a motion of what grows is told.
const GROWS_WITH: f64 = 0.15;

/// Motions that growth in one or several shapes shows in, that along its axis first and then by their ranges over the
/// readings (display units): amplitudes of nodes may cancel, and a node may have settled before the first reading.
pub(crate) fn growing_outlets(model: &LinearModel, parts: &[(&Candidate, Vec<f64>)]) -> Vec<Outlet> {
    let courses = growth_courses(model, parts);
    let mut ranges: Vec<(Outlet, f64)> =
        courses.iter().map(|(outlet, course)| (*outlet, range(low_and_high(course)))).collect();
    ranges.sort_by(|a, b| b.1.total_cmp(&a.1));
    let largest = ranges.first().map_or(0.0, |(_, range)| *range);
    ranges.retain(|(_, range)| *range >= GROWS_WITH * largest);
    let along = parts.first().and_then(|(lead, _)| along_its_axis(model.context.machine(), &lead.effect));
    // the size is that of the first one
    ranges.sort_by_key(|(outlet, _)| Some(*outlet) != along);
    ranges.into_iter().map(|(outlet, _)| outlet).collect()
}

/// Growth of several shapes together, peak to peak: along its axis where that is told, else the largest one.
pub(crate) fn growth(model: &LinearModel, parts: &[(&Candidate, Vec<f64>)], cause: &Cause) -> f64 {
    let machine = model.context.machine();
    let along = parts.first().and_then(|(lead, _)| told_along_its_axis(machine, &lead.effect, cause));
    let settles = parts.iter().any(|(part, _)| settles(&part.effect));
    let measured = |outlet: &Outlet| match along {
        Some(along) => *outlet == along,
        None => outlet.measure(machine) == Measure::Length,
    };
    let courses = growth_courses(model, parts);
    let sizes =
        courses.iter().filter(|(outlet, _)| measured(outlet)).map(|(_, course)| grown(low_and_high(course), settles));
    sizes.fold(0.0, f64::max)
}

/// Growth from the ends of its course: from the session's beginning, where it is zero by form; how a part left its first
/// state before the first reading is known to nobody.
fn grown((low, high): (f64, f64), settles: bool) -> f64 {
    if settles { range((low, high)) } else { high.max(0.0) - low.min(0.0) }
}

/// Course of every motion over the readings, summed over the shapes (display units).
fn growth_courses(model: &LinearModel, parts: &[(&Candidate, Vec<f64>)]) -> Vec<(Outlet, Vec<f64>)> {
    let all = |part: &Candidate| (0..part.terms.len()).collect();
    let courses = Trajectories::of_all(model, parts.iter().map(|(part, _)| (*part, all(part))));
    let amplitudes: Vec<f64> = parts.iter().flat_map(|(_, sizes)| sizes.iter().copied()).collect();
    courses.by_outlet.into_iter().map(|(outlet, terms)| (outlet, course(&terms, &amplitudes))).collect()
}

impl Trajectories {
    pub(crate) fn of(model: &LinearModel, lead: &Candidate, main: &[usize]) -> Trajectories {
        // bars that grow in proportion to their lengths: the size is the longest one's
        let effect = match lead.effect.parameter("growing") {
            Some(_) => &lead.effect.clone().with("growing", ParameterValue::Word("alike".into())),
            None => &lead.effect,
        };
        let empty = Trajectories {
            settles: settles(&lead.effect),
            orders: orders_of_a_turn(model, lead),
            ..Trajectories::default()
        };
        let Ok(profiles) = model.profiles(effect) else { return empty };
        let machine = model.context.machine();
        // one axis may move as another one drives it
        let driving = match lead.effect.parameter("of") {
            Some(ParameterValue::Word(name)) => machine.axis_index(name),
            _ => None,
        };
        let axis = driving.or(lead.effect.place.axis());
        // a joint that stands still sags as the one that carries it tilts
        let everywhere = matches!(signature(&lead.effect.kind), Some(Growth | Straightness | BarLength | Sag));
        let counts =
            |test: &usize| everywhere || axis.is_none_or(|axis| model.context.motion(*test).moving.contains(&axis));
        let mut tests: Vec<usize> = (0..model.tests()).filter(counts).collect();
        // an axis that moves between tests alone leaves in them what it did there
        if tests.is_empty() {
            tests.extend(0..model.tests());
        }
        let function = |k: usize| -> Vec<f64> {
            let mut rows = Vec::new();
            for &test in &tests {
                let profile = &profiles[lead.terms[k].function][test];
                let count = model.residual_mm[test].len();
                let is_of_other = lead.terms[k].test.is_some_and(|own| own != test);
                if profile.is_empty() || is_of_other {
                    rows.resize(rows.len() + count, 0.0)
                } else {
                    rows.extend_from_slice(profile)
                }
            }
            rows
        };
        let mut by_outlet: Vec<(Outlet, Parts)> = Vec::new();
        for &k in main {
            let outlet = lead.terms[k].outlet;
            let part = (k, function(k));
            match by_outlet.iter_mut().find(|(other, _)| *other == outlet) {
                Some((_, parts)) => parts.push(part),
                None => by_outlet.push((outlet, vec![part])),
            }
        }
        let positions = |axis: usize| -> Vec<f64> {
            tests.iter().flat_map(|&test| model.context.motion(test).axis(axis)).collect()
        };
        let is_length = |(outlet, _): &(Outlet, Parts)| outlet.measure(machine) == Measure::Length;
        let of_axis = lead.effect.place.axis().filter(|_| by_outlet.iter().all(is_length));
        let travel = lead.effect.place.axis().map(|axis| low_and_high(&positions(axis)));
        let positions = of_axis.map(positions).unwrap_or_default();
        Trajectories { by_outlet, positions, travel, ..empty }
    }

    /// The courses of several shapes of one place, which add, by some terms of each; amplitudes are those of all terms of the
    /// first shape, then of the next.
    pub(crate) fn of_all<'s>(
        model: &LinearModel,
        shapes: impl Iterator<Item = (&'s Candidate, Vec<usize>)>,
    ) -> Trajectories {
        let mut all = Trajectories::default();
        let mut first = 0;
        for (shape, terms) in shapes {
            all.settles |= settles(&shape.effect);
            for (outlet, parts) in Trajectories::of(model, shape, &terms).by_outlet {
                let parts = parts.into_iter().map(|(k, rows)| (first + k, rows));
                match all.by_outlet.iter_mut().find(|(other, _)| *other == outlet) {
                    Some((_, sum)) => sum.extend(parts),
                    None => all.by_outlet.push((outlet, parts.collect())),
                }
            }
            first += shape.terms.len();
        }
        all
    }

    /// Whether the place's axis makes whole turns.
    pub(crate) fn is_whole_turn(&self) -> bool {
        self.orders.is_some()
    }

    /// Whether a bump is narrower than the travel: a wider one is a bow, whose top may lie where nothing went.
    pub(crate) fn hold(&self, bump: &Candidate) -> bool {
        let (from, to) = low_and_high(&self.positions);
        let width = bump.effect.number("width");
        self.positions.is_empty() || width.is_none_or(|width| width <= to - from)
    }

    /// Height of a bump in the direction where it is highest, whether or not a test stood at its centre.
    pub(crate) fn height(&self, amplitudes: &[f64]) -> f64 {
        let heights = self.by_outlet.iter().map(|(_, parts)| parts.iter().map(|(k, _)| amplitudes[*k].abs()).sum());
        heights.fold(0.0, f64::max)
    }

    /// Amplitude of the largest wave of a cyclic error.
    pub(crate) fn cyclic(&self, lead: &Candidate, amplitudes: &[f64]) -> f64 {
        let numbers: Vec<f64> = wave_numbers(&lead.effect).collect();
        numbers.iter().map(|first| self.wave(*first, &numbers, lead, amplitudes)).fold(0.0, f64::max)
    }

    /// Amplitude of the wave that a period and those which the travel does not tell from it make, root mean square over the travel.
    /// Periods that a travel hardly tells apart share it between them at will.
    fn wave(&self, first: f64, numbers: &[f64], lead: &Candidate, amplitudes: &[f64]) -> f64 {
        let Some((from, to)) = self.travel else { return 0.0 };
        let near: Vec<f64> = numbers.iter().map(|number| number - first).collect();
        let is_near = |k: usize| near[k].abs() * (to - from) < ONE_WAVE;
        let square_at = |parts: &Parts, q: f64| {
            let waves = parts.iter().filter(|(k, _)| is_near(lead.terms[*k].function / 2));
            let (along, across) = waves.fold((0.0, 0.0), |(along, across), (k, _)| {
                let function = lead.terms[*k].function;
                // a cosine's phasor turns by the difference of the two waves; a sine's is a quarter turn behind
                let (sin, cos) = (near[function / 2] * q).sin_cos();
                let (real, imaginary) = if function.is_multiple_of(2) { (cos, sin) } else { (sin, -cos) };
                (along + amplitudes[*k] * real, across + amplitudes[*k] * imaginary)
            });
            along * along + across * across
        };
        let place = |k: usize| from + (to - from) * (k as f64 + 0.5) / PLACES as f64;
        let of_outlet =
            |(_, parts): &(Outlet, Parts)| (0..PLACES).map(|k| square_at(parts, place(k))).sum::<f64>() / PLACES as f64;
        self.by_outlet.iter().map(of_outlet).sum::<f64>().sqrt()
    }

    /// Largest value, or range, of the courses of the outlets over the session.
    pub(crate) fn largest(&self, cause: &Cause, amplitudes: &[f64]) -> f64 {
        let size = |parts: &Parts| match signature(&cause.effect) {
            Some(ErrorMotion) => self.error_motion(parts, amplitudes),
            Some(Straightness) => {
                let mut course = course(parts, amplitudes);
                take_end_points_off(&mut course, &self.positions);
                farthest(low_and_high(&course))
            }
            Some(Growth | BarLength) => grown(low_and_high(&course(parts, amplitudes)), self.settles),
            Some(FreeCurve) => 0.5 * range(low_and_high(&course(parts, amplitudes))),
            _ => farthest(low_and_high(&course(parts, amplitudes))),
        };
        self.by_outlet.iter().map(|(_, parts)| size(parts)).fold(0.0, f64::max)
    }

    /// Largest of a component over the turn from its mean, without what placement takes up; half its range over an arc.
    fn error_motion(&self, parts: &Parts, amplitudes: &[f64]) -> f64 {
        // where the readings told first orders alone, placement has not taken them up
        let told = self.orders.as_ref().filter(|orders| !orders.iter().all(|order| order.is_first));
        let Some(orders) = told else { return 0.5 * range(low_and_high(&course(parts, amplitudes))) };
        let left: Vec<f64> =
            amplitudes.iter().zip(orders).map(|(size, order)| if order.is_taken_up { 0.0 } else { *size }).collect();
        let (low, high) = low_and_high(&course(parts, &left));
        // orders count from zero at the axis's zero: their mean over a turn is less the cosines'
        let mean: f64 = -parts.iter().filter(|(k, _)| orders[*k].is_cosine).map(|(k, _)| left[*k]).sum::<f64>();
        if low > high { 0.0 } else { (high - mean).max(mean - low) }
    }
}

/// The terms of an error motion over a whole turn.
fn orders_of_a_turn(model: &LinearModel, lead: &Candidate) -> Option<Vec<OrderTerm>> {
    let axis = lead.effect.place.axis().filter(|_| has_first_order(lead))?;
    model.context.travelled(axis).filter(|(from, to)| to - from > WHOLE_TURN)?;
    let axial = axial(model.context.machine(), axis);
    let order = |term: &Term| {
        let is_first = is_once_per_turn(&lead.effect, term);
        OrderTerm {
            is_cosine: term.function.is_multiple_of(2),
            is_first,
            is_taken_up: is_first && term.outlet != axial,
        }
    };
    Some(lead.terms.iter().map(order).collect())
}

/// Range of a course from its ends; zero for an empty one.
fn range((low, high): (f64, f64)) -> f64 {
    (high - low).max(0.0)
}

/// Largest distance of a course from zero; zero for an empty one.
fn farthest((low, high): (f64, f64)) -> f64 {
    if low > high { 0.0 } else { high.abs().max(low.abs()) }
}
