//! Tests that could be run next on the machine of a session, with its balls as they are mounted. Reach and collision are the planner's.

use crate::chain::{Chain, Geometry};
use crate::machine::AxisKind;
use crate::session::{CirclePlane, Follow, Motion, Path, Session, Test};

/// A test not yet run.
#[derive(Debug, Clone)]
pub struct Candidate {
    pub motion: Motion,
    /// Index of the session's test whose balls and bar it uses.
    pub like: usize,
    /// For people: `C from -180° to 180° with the linear axes following tangentially, A at 45°`.
    pub says: String,
}

/// Positions of the other rotary axes that are tried, degrees.
const STANDING_DEG: [f64; 5] = [0.0, 90.0, -90.0, 45.0, -45.0];
/// Samples of a candidate's sweep: enough for its harmonics, few enough to try many.
const SAMPLES: f64 = 48.0;

/// Sweeps of every rotary axis with the linear axes following, other rotary axes at several positions.
pub fn candidate_tests(session: &Session, chain: &Chain) -> Vec<Candidate> {
    let machine = &session.machine;
    let rotary: Vec<usize> = machine.axes_of(AxisKind::Rotary).collect();
    let mut list = Vec::new();
    let mut seen_balls: Vec<(usize, usize)> = Vec::new();
    let setups = crate::session::Setups::of(session);
    for (like, test) in session.tests.iter().enumerate() {
        let balls = (setups.pivot_of[like], setups.spindle_ball_of[like]);
        if seen_balls.contains(&balls) {
            continue;
        }
        seen_balls.push(balls);
        for &axis in &rotary {
            let Ok(links) = test.links(chain) else { continue };
            if chain.carries(axis, links.0) == chain.carries(axis, links.1) {
                continue;
            }
            for follow in [Follow::Tangential, Follow::Radial, Follow::Axial] {
                for standing in standings(session, &rotary, axis) {
                    list.extend(candidate(session, chain, (like, test), axis, follow, &standing));
                }
            }
        }
    }
    list
}

/// Circles of every pair of linear axes about the pivot, rotary axes at zero: they show how square the linear axes are.
pub fn candidate_circles(session: &Session, chain: &Chain) -> Vec<Candidate> {
    let machine = &session.machine;
    let linear: Vec<usize> = machine.axes_of(AxisKind::Linear).collect();
    let pairs = linear
        .iter()
        .enumerate()
        .flat_map(|(place, &first)| linear[place + 1..].iter().map(move |&second| CirclePlane { first, second }));
    let mut seen: Vec<&Test> = Vec::new();
    let mut list = Vec::new();
    let pairs: Vec<CirclePlane> = pairs.collect();
    for (like, test) in session.tests.iter().enumerate() {
        let is_same = |other: &&Test| other.pivot == test.pivot && other.spindle_ball == test.spindle_ball;
        if seen.iter().any(is_same) {
            continue;
        }
        seen.push(test);
        list.extend(pairs.iter().filter_map(|plane| circle(session, chain, (like, test), plane.clone())));
    }
    list
}

fn circle(session: &Session, chain: &Chain, (like, test): (usize, &Test), plane: CirclePlane) -> Option<Candidate> {
    let mut planned = test.clone();
    planned.recording = None;
    // bars differ by micrometres from their nominal length, and a gauge takes that up
    let radius_mm = test.bar_length_mm?.round();
    planned.path = Some(Path::Circle { plane: plane.clone(), radius_mm, from: 0.0, to: 360.0, step: 360.0 / SAMPLES });
    planned.positions = vec![Some(0.0); session.machine.axes.len()];
    // the third axis brings both balls into the plane
    let third = (0..session.machine.axes.len())
        .find(|&k| session.machine.axes[k].kind == AxisKind::Linear && k != plane.first && k != plane.second)?;
    planned.positions[third] = Some(level(session, chain, &planned, third)?);
    let motion = Motion::of(session, chain, &planned).ok()?;
    let name = |axis: usize| &session.machine.axes[axis].name;
    let says = format!("a circle of {} and {} about the pivot", name(plane.first), name(plane.second));
    is_inside(session, &motion).then_some(Candidate { motion, like, says })
}

/// Position of a linear axis at which the balls stand level along it, the other axes at zero.
fn level(session: &Session, chain: &Chain, test: &Test, axis: usize) -> Option<f64> {
    let links = test.links(chain).ok()?;
    let geometry = Geometry::nominal(chain);
    let gap = |position: f64| {
        let mut q = vec![0.0; session.machine.axes.len()];
        q[axis] = position;
        -test.bar(&geometry, links, &q)
    };
    let along = gap(1.0) - gap(0.0);
    (along.norm() > 0.5).then(|| -gap(0.0).dot(&along))
}

fn is_inside(session: &Session, motion: &Motion) -> bool {
    (0..motion.axis_count).all(|k| {
        let range = session.machine.axes[k].range;
        range.is_none_or(|(from, to)| motion.axis(k).all(|q| q >= from - 1e-9 && q <= to + 1e-9))
    })
}

/// Positions (axis, degrees) of the other rotary axes, within their ranges; one axis at a time leaves zero.
fn standings(session: &Session, rotary: &[usize], swept: usize) -> Vec<Vec<(usize, f64)>> {
    let others: Vec<usize> = rotary.iter().copied().filter(|&k| k != swept).collect();
    let mut list = vec![others.iter().map(|&k| (k, 0.0)).collect::<Vec<_>>()];
    for &turned in &others {
        for degrees in STANDING_DEG.into_iter().skip(1) {
            let inside = session.machine.axes[turned]
                .range
                .is_none_or(|(from, to)| (from..=to).contains(&f64::to_radians(degrees)));
            if inside {
                list.push(others.iter().map(|&k| (k, if k == turned { degrees } else { 0.0 })).collect());
            }
        }
    }
    list
}

fn candidate(
    session: &Session,
    chain: &Chain,
    (like, test): (usize, &Test),
    axis: usize,
    follow: Follow,
    standing: &[(usize, f64)],
) -> Option<Candidate> {
    let swept = &session.machine.axes[axis];
    let (from, to) =
        swept.range.map_or((-180.0, 180.0), |(from, to)| (from.to_degrees().max(-180.0), to.to_degrees().min(180.0)));
    let mut planned = test.clone();
    planned.recording = None;
    planned.path = Some(Path::Sweep { axis, from, to, step: (to - from) / SAMPLES, follow, length_mm: None });
    for &(other, degrees) in standing {
        planned.positions[other] = Some(degrees.to_radians());
    }
    let motion = Motion::of(session, chain, &planned).ok()?;
    if !is_inside(session, &motion) {
        return None;
    }
    let word = match follow {
        Follow::Tangential => "tangentially",
        Follow::Radial => "radially",
        Follow::Axial => "axially",
        Follow::None => "not at all",
    };
    let others: Vec<String> = standing
        .iter()
        .map(|&(other, degrees)| format!("{} at {degrees}°", session.machine.axes[other].name))
        .collect();
    let says = format!(
        "{} from {from:.0}° to {to:.0}° with the linear axes following {word}{}{}",
        swept.name,
        if others.is_empty() { "" } else { ", " },
        others.join(", ")
    );
    Some(Candidate { motion, like, says })
}
