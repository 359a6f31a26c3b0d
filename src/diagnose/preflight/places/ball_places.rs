//! Where the lengths put a ball whose stated place may be wrong by any amount: trilateration from the other ball. It weighs no explanation.
//!
//! Seen from the link that carries a ball, the other ball visits points `s_k`; the readings say `|x − s_k| = L_k`, which
//! is solved for x from many starts, because mirrored and turned places fit nearly as well.

use nalgebra::{Matrix3, Vector3};

use crate::chain::{Chain, Geometry};
use crate::diagnose::preflight::quick_fit::Refit;
use crate::identify::Quantity;
use crate::session::{Ball, Motion, Session, Setups, Test};

/// Share of a misfit by the nominal machine that putting a statement right must take off, to be worth a refit.
pub(crate) const WORTH: f64 = 0.5;

/// Points that the other ball visits, and the readings there, mm.
pub(crate) type Sights = Vec<(Vector3<f64>, f64)>;

/// One end of a bar.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum End {
    Pivot,
    Spindle,
}

impl End {
    /// Name in answers.
    pub(crate) fn place(self) -> &'static str {
        match self {
            End::Pivot => "pivot",
            End::Spindle => "spindle-ball",
        }
    }

    /// Name in sentences.
    pub(crate) fn words(self) -> &'static str {
        match self {
            End::Pivot => "pivot",
            End::Spindle => "spindle ball",
        }
    }

    /// The end that answers name so.
    pub(crate) fn named(name: &str) -> Option<End> {
        [End::Pivot, End::Spindle].into_iter().find(|end| end.place() == name)
    }

    /// Which setup of its balls a test uses.
    pub(crate) fn setup_of(self, setups: &Setups, test: usize) -> usize {
        match self {
            End::Pivot => setups.pivot_of[test],
            End::Spindle => setups.spindle_ball_of[test],
        }
    }

    /// Whether an unknown places the ball of a setup.
    pub(crate) fn is_placed_by(self, quantity: Quantity, setup: usize) -> bool {
        match (self, quantity) {
            (End::Pivot, Quantity::Pivot { setup: of, .. })
            | (End::Spindle, Quantity::SpindleBall { setup: of, .. }) => of == setup,
            _ => false,
        }
    }

    pub(crate) fn of(self, test: &Test) -> &Ball {
        match self {
            End::Pivot => &test.pivot,
            End::Spindle => &test.spindle_ball,
        }
    }

    pub(crate) fn of_mut(self, test: &mut Test) -> &mut Ball {
        match self {
            End::Pivot => &mut test.pivot,
            End::Spindle => &mut test.spindle_ball,
        }
    }

    /// Has the ball of a test a setup of its own, and another spread where one is given.
    pub(crate) fn mount_anew(self, test: &mut Test, setup: String, spread_mm: Option<f64>) {
        let ball = self.of_mut(test);
        ball.setup = Some(setup);
        ball.spread_mm = spread_mm.or(ball.spread_mm);
    }

    fn other(self) -> End {
        match self {
            End::Pivot => End::Spindle,
            End::Spindle => End::Pivot,
        }
    }
}

/// How far a refit puts the ball of a setup from its stated place, mm, as the fit counts it.
pub(crate) fn placement(refitted: &Refit, end: End, setup: usize) -> Vector3<f64> {
    let mut placement = Vector3::zeros();
    for (unknown, value) in refitted.unknowns.iter().zip(&refitted.values) {
        if end.is_placed_by(unknown.quantity, setup) {
            placement[unknown.quantity.coordinate()] = *value;
        }
    }
    placement
}

/// Moves a ball by a placement, which a spindle that is turned round counts the other way.
pub(crate) fn move_ball(ball: &mut Ball, placement: &Vector3<f64>) {
    for coordinate in 0..3 {
        ball.at[coordinate] += ball.sign(coordinate) * placement[coordinate];
    }
}

/// What a test says of the place of one of its balls on a link, by the nominal machine.
pub(crate) fn sights(session: &Session, chain: &Chain, test: &Test, end: End, link: &str) -> Sights {
    let geometry = Geometry::nominal(chain);
    let other = end.other().of(test);
    let links = (chain.link(link), chain.link(&other.link));
    let (Some(own), Some(across)) = links else { return Vec::new() };
    let (Ok(motion), Some(recording)) = (Motion::of(session, chain, test), &test.recording) else { return Vec::new() };
    let rows = motion.rows().min(recording.len());
    (0..rows)
        .filter(|&row| recording.length_mm[row].is_finite())
        .map(|row| {
            let pose = geometry.pose(own, motion.row(row), None);
            let seen = geometry.point(across, &other.at, motion.row(row), None);
            let length_mm = recording.length_mm[row] - test.bar_error_mm;
            (pose.rotation.transpose() * (seen - pose.translation_mm), length_mm)
        })
        .collect()
}

/// Misses beyond this count linearly, mm: one recording that does not belong must not pull the place.
const ROBUST_MM: f64 = 0.3;

/// Steps of one solution.
const STEPS: usize = 60;

/// A step smaller than this ends it, mm.
const SETTLED_MM: f64 = 1e-5;

/// Place that the sights say, from a start, with its robust misfit, mm.
///
/// `sights` hold the points relative to where the ball would stand without a shift: one shift may then be common to several balls.
pub(crate) fn solved(sights: &Sights, start: Vector3<f64>) -> (Vector3<f64>, f64) {
    let mut at = start;
    let mut damping = 1e-3;
    let mut cost = robust_cost(sights, &at);
    for _ in 0..STEPS {
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for (seen, length) in sights {
            let arm = at - seen;
            let distance = arm.norm().max(1e-6);
            let (direction, miss) = (arm / distance, length - distance);
            let weight = (ROBUST_MM / miss.abs().max(ROBUST_MM)).min(1.0);
            normal += weight * direction * direction.transpose();
            right += weight * miss * direction;
        }
        // places that the sights leave open stay where they started
        let scale = normal.trace().max(1e-9);
        let damped = normal + Matrix3::identity() * (damping * scale);
        let Some(step) = damped.try_inverse().map(|inverse| inverse * right) else { break };
        let next = robust_cost(sights, &(at + step));
        if next < cost {
            (at, cost, damping) = (at + step, next, (0.2 * damping).max(1e-9));
            if step.norm() < SETTLED_MM {
                break;
            }
        } else if damping > 1e3 {
            break;
        } else {
            damping *= 8.0;
        }
    }
    (at, misfit_mm(sights, &at))
}

fn robust_cost(sights: &Sights, at: &Vector3<f64>) -> f64 {
    let loss = |miss: f64| match miss.abs() {
        size if size <= ROBUST_MM => size * size,
        size => ROBUST_MM * (2.0 * size - ROBUST_MM),
    };
    sights.iter().map(|(seen, length)| loss(length - (at - seen).norm())).sum()
}

/// Root of the mean robust cost, mm.
pub(crate) fn misfit_mm(sights: &Sights, at: &Vector3<f64>) -> f64 {
    (robust_cost(sights, at) / sights.len().max(1) as f64).sqrt()
}

/// How a person writes a place wrongly: coordinates exchanged, or signs turned. The place as stated comes first.
pub(crate) fn written_otherwise(at: &Vector3<f64>) -> Vec<(Vector3<f64>, String)> {
    const ORDERS: [([usize; 3], &str); 6] = [
        ([0, 1, 2], ""),
        ([1, 0, 2], "x and y are exchanged"),
        ([2, 1, 0], "x and z are exchanged"),
        ([0, 2, 1], "y and z are exchanged"),
        ([1, 2, 0], "x, y and z are exchanged in turn"),
        ([2, 0, 1], "x, y and z are exchanged in turn"),
    ];
    let mut places: Vec<(Vector3<f64>, String)> = Vec::new();
    for signs in 0..8u8 {
        for (order, words) in ORDERS {
            let sign = |k: usize| if signs & (1 << k) == 0 { 1.0 } else { -1.0 };
            let place = Vector3::from_fn(|k, _| sign(k) * at[order[k]]);
            if places.iter().any(|(other, _)| (other - place).norm() < 1e-9) {
                continue;
            }
            let turned: Vec<&str> =
                (0..3).filter(|&k| sign(k) < 0.0 && place[k] != 0.0).map(|k| ["x", "y", "z"][k]).collect();
            let sign_words = match turned.len() {
                0 => String::new(),
                1 => format!("the sign of {} is turned", turned[0]),
                _ => format!("the signs of {} are turned", turned.join(" and ")),
            };
            let parts: Vec<&str> = [words, &sign_words].into_iter().filter(|part| !part.is_empty()).collect();
            places.push((place, parts.join(", ")));
        }
    }
    places
}

/// Places closer than this are one solution, mm.
const SAME_MM: f64 = 0.5;

/// Solutions kept of a ball.
const MOST_SOLUTIONS: usize = 4;

/// Places that explain the sights about as well as the best one does, those near `stated` first.
pub(crate) fn solutions(sights: &Sights, stated: &Vector3<f64>) -> Vec<(Vector3<f64>, f64)> {
    if sights.is_empty() {
        return Vec::new();
    }
    let mut starts: Vec<Vector3<f64>> = written_otherwise(stated).into_iter().map(|(place, _)| place).collect();
    let count = sights.len() as f64;
    let centre = sights.iter().map(|(seen, _)| seen).sum::<Vector3<f64>>() / count;
    let reach = sights.iter().map(|(_, length)| length).sum::<f64>() / count;
    for (x, y, z) in (-1..=1).flat_map(|x| (-1..=1).flat_map(move |y| (-1..=1).map(move |z| (x, y, z)))) {
        let direction = Vector3::new(f64::from(x), f64::from(y), f64::from(z));
        starts.extend(direction.try_normalize(1e-9).map(|direction| centre + reach * direction));
    }
    let mut solved: Vec<(Vector3<f64>, f64)> = starts.into_iter().map(|start| solved(sights, start)).collect();
    solved.sort_by(|a, b| a.1.total_cmp(&b.1));
    let best = solved.first().map_or(0.0, |(_, misfit)| *misfit);
    solved.retain(|(_, misfit)| *misfit < NEARLY * best.max(NOMINAL_MM));
    solved.sort_by(|a, b| (a.0 - stated).norm().total_cmp(&(b.0 - stated).norm()));
    let mut kept: Vec<(Vector3<f64>, f64)> = Vec::new();
    for one in solved {
        if kept.len() < MOST_SOLUTIONS && kept.iter().all(|other| (other.0 - one.0).norm() > SAME_MM) {
            kept.push(one);
        }
    }
    kept
}

/// Solutions are kept up to so many times the misfit of the best one, or of what location errors of a machine leave, mm.
const NEARLY: f64 = 2.0;
pub(crate) const NOMINAL_MM: f64 = 0.1;
