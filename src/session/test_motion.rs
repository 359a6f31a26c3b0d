//! Positions of all axes, row by row, for a test: from its recording, or along its planned path. Nominal geometry only.

use nalgebra::{DMatrix, DVector, Matrix3x2, Vector3};

use super::motion::Motion;
use super::path::{Follow, Path};
use super::recording::Clock;
use super::test::{Session, Test};
use crate::chain::{Chain, Geometry, LinkId};
use crate::machine::AxisKind;

/// Why the positions of a test are not known.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MotionError {
    #[error(
        "test '{test}': axis {axis} has neither a column in the recording nor a place in 'positions'; add it to positions"
    )]
    AxisUnknown { test: String, axis: String },
    #[error("test '{test}' has neither a recording nor a sweep or circle; add one")]
    NoPath { test: String },
    #[error(
        "test '{test}' follows {axis}, but the linear axes cannot bring the bar there (off by {miss_mm:.3} mm); choose another place for the pivot or 'follow: none'"
    )]
    CannotFollow { test: String, axis: String, miss_mm: f64 },
    #[error(
        "test '{test}' follows {axis}, but that axis carries neither ball, or carries one on its own line: the bar has no direction to keep; choose another place for the pivot or 'follow: none'"
    )]
    NothingToFollow { test: String, axis: String },
    #[error("test '{test}': the two slides of its circle move the balls the same way; name slides of a plane")]
    NoPlane { test: String },
    #[error("test '{test}': no link is called '{link}'; links are {known}")]
    NoLink { test: String, link: String, known: String },
}

impl Motion {
    /// Motion of a test: its recording's positions, or its path's.
    pub fn of(session: &Session, chain: &Chain, test: &Test) -> Result<Motion, MotionError> {
        match (&test.recording, &test.path) {
            (Some(recording), _) if !matches!(recording.clock, Clock::Absent) => {
                let columns = recording.axes.iter().copied().zip(recording.positions.iter().map(Vec::as_slice));
                let time_s = recording.time_s().map(<[f64]>::to_vec);
                assemble(session, test, recording.len(), columns, time_s)
            }
            (recording, Some(path)) => {
                let mut along = along_path(session, chain, test, path)?;
                if let Some(recording) = recording {
                    along = resample(session, chain, test, path, recording.len())?;
                }
                Ok(along)
            }
            (_, None) => Err(MotionError::NoPath { test: test.name.clone() }),
        }
    }
}

/// Rows from columns of moving axes and the test's standing positions.
fn assemble<'a>(
    session: &Session,
    test: &Test,
    rows: usize,
    columns: impl Iterator<Item = (usize, &'a [f64])>,
    time_s: Option<Vec<f64>>,
) -> Result<Motion, MotionError> {
    let axis_count = session.machine.axes.len();
    let mut standing = test.positions.clone();
    standing.resize(axis_count, None);
    let mut positions = vec![0.0; rows * axis_count];
    let mut moving = Vec::new();
    for (axis, column) in columns {
        moving.push(axis);
        for (row, &value) in column.iter().enumerate() {
            positions[row * axis_count + axis] = value;
        }
    }
    for axis in (0..axis_count).filter(|axis| !moving.contains(axis)) {
        let Some(value) = standing[axis] else {
            return Err(MotionError::AxisUnknown {
                test: test.name.clone(),
                axis: session.machine.axes[axis].name.clone(),
            });
        };
        for row in 0..rows {
            positions[row * axis_count + axis] = value;
        }
    }
    Ok(Motion { axis_count, positions, time_s, moving })
}

/// A path with as many samples as the recording has rows, uniform in the swept parameter (thesis section 4.2).
fn resample(session: &Session, chain: &Chain, test: &Test, path: &Path, rows: usize) -> Result<Motion, MotionError> {
    along_path(session, chain, test, &path.in_steps((rows.max(2) - 1) as f64))
}

fn along_path(session: &Session, chain: &Chain, test: &Test, path: &Path) -> Result<Motion, MotionError> {
    let samples = path.samples();
    let columns = match path {
        Path::Circle { plane, radius_mm, .. } => {
            circle_columns(session, chain, test, plane.first, plane.second, *radius_mm, &samples)?
        }
        Path::Sweep { axis, follow: Follow::None, .. } => {
            let kind = session.machine.axes[*axis].kind;
            vec![(*axis, samples.iter().map(|&s| kind.from_file_unit(s)).collect())]
        }
        Path::Sweep { axis, follow, .. } => follow_columns(session, chain, test, *axis, *follow, &samples)?,
    };
    let time_s = path_times(session, chain, test, &columns, samples.len());
    let columns = columns.iter().map(|(axis, column)| (*axis, column.as_slice()));
    assemble(session, test, samples.len(), columns, Some(time_s))
}

/// Columns of the two linear axes of a circle about the pivot ball's nominal place.
fn circle_columns(
    session: &Session,
    chain: &Chain,
    test: &Test,
    first: usize,
    second: usize,
    radius_mm: f64,
    samples: &[f64],
) -> Result<Vec<(usize, Vec<f64>)>, MotionError> {
    let mut rest = standing(session, test, &[first, second])?;
    let geometry = Geometry::nominal(chain);
    let links = ball_links(chain, test)?;
    let gap = |q: &[f64]| -test.bar(&geometry, links, q);
    // a linear axis moves the gap along one direction: steps of 1 mm give it
    let base = gap(&rest);
    let mut step = |axis: usize| {
        rest[axis] = 1.0;
        let moved = gap(&rest) - base;
        rest[axis] = 0.0;
        moved
    };
    let (along_first, along_second) = (step(first), step(second));
    // about the place at which the balls are nearest; slides need not stand at right angles
    let ways = Matrix3x2::from_columns(&[along_first, along_second]);
    let normal = ways.transpose() * ways;
    let Some(centre) = normal.try_inverse().map(|inverse| inverse * ways.transpose() * -base) else {
        return Err(MotionError::NoPlane { test: test.name.clone() });
    };
    // a control runs the circle in its coordinates
    let coordinate = |about: f64, value: fn(f64) -> f64| {
        samples.iter().map(|s| about + radius_mm * value(s.to_radians())).collect::<Vec<f64>>()
    };
    Ok(vec![(first, coordinate(centre.x, f64::cos)), (second, coordinate(centre.y, f64::sin))])
}

/// Columns of a sweep whose linear axes keep the bar's direction in the turning frame.
fn follow_columns(
    session: &Session,
    chain: &Chain,
    test: &Test,
    axis: usize,
    follow: Follow,
    samples: &[f64],
) -> Result<Vec<(usize, Vec<f64>)>, MotionError> {
    let linear: Vec<usize> = session.machine.axes_of(AxisKind::Linear).collect();
    let mut moving = linear.clone();
    moving.push(axis);
    let mut q = standing(session, test, &moving)?;
    let geometry = Geometry::nominal(chain);
    let (pivot, spindle) = ball_links(chain, test)?;
    let kind = session.machine.axes[axis].kind;
    let mut columns: Vec<(usize, Vec<f64>)> = linear.iter().map(|&k| (k, Vec::with_capacity(samples.len()))).collect();
    let mut swept = Vec::with_capacity(samples.len());
    for &sample in samples {
        q[axis] = kind.from_file_unit(sample);
        let miss = bring_bar(&geometry, test, (pivot, spindle), axis, follow, &linear, &mut q);
        let name = || session.machine.axes[axis].name.clone();
        let Some(miss_mm) = miss else {
            return Err(MotionError::NothingToFollow { test: test.name.clone(), axis: name() });
        };
        if miss_mm.is_nan() || miss_mm > 1e-6 {
            return Err(MotionError::CannotFollow { test: test.name.clone(), axis: name(), miss_mm });
        }
        for (axis, column) in &mut columns {
            column.push(q[*axis]);
        }
        swept.push(q[axis]);
    }
    // an axis that does not move stands still at the place found
    columns.push((axis, swept));
    Ok(columns)
}

/// Sets the linear axes so that the spindle ball stands at bar length in the wanted direction; returns the miss in mm, `None` where
/// there is no such direction.
fn bring_bar(
    geometry: &Geometry,
    test: &Test,
    links: (LinkId, LinkId),
    axis: usize,
    follow: Follow,
    linear: &[usize],
    q: &mut [f64],
) -> Option<f64> {
    let chain = geometry.chain();
    let joint = chain.joint(axis);
    let stated_mm = test.path.as_ref().and_then(Path::kept_mm);
    let radius_mm = stated_mm.unwrap_or_else(|| test.nominal_bar_mm());
    let carrier = LinkId { depth: chain.carried_by(axis).depth - 1, ..chain.carried_by(axis) };
    let (carried, carried_at, other, other_at) = if chain.carries(axis, links.0) {
        (links.0, &test.pivot.at, links.1, &test.spindle_ball.at)
    } else {
        (links.1, &test.spindle_ball.at, links.0, &test.pivot.at)
    };
    let mut miss = f64::NAN;
    // linear axes act linearly on the gap, so the second pass only confirms
    for _ in 0..3 {
        let pose = geometry.pose(carrier, q, None);
        let about = pose.rotation * joint.direction;
        let ball = geometry.point(carried, carried_at, q, None);
        let direction = Path::bar_direction(follow, &about, &(ball - pose.point(&joint.origin)))?;
        let target = ball + direction * radius_mm;
        let gap: Vector3<f64> = target - geometry.point(other, other_at, q, None);
        miss = gap.norm();
        if miss < 1e-9 {
            break;
        }
        let jacobian = DMatrix::from_fn(3, linear.len(), |row, column| {
            let mut stepped = q.to_vec();
            stepped[linear[column]] += 1.0;
            let ball_step = geometry.point(carried, carried_at, &stepped, None) - ball;
            let other_step = geometry.point(other, other_at, &stepped, None) - geometry.point(other, other_at, q, None);
            (other_step - ball_step)[row]
        });
        let normal = &jacobian.transpose() * &jacobian + DMatrix::identity(linear.len(), linear.len()) * 1e-12;
        let right = jacobian.transpose() * DVector::from_column_slice(gap.as_slice());
        if let Some(step) = normal.cholesky().map(|factor| factor.solve(&right)) {
            for (&k, value) in linear.iter().zip(step.iter()) {
                q[k] += value;
            }
        }
    }
    Some(miss)
}

/// Standing positions with the moving axes at zero.
fn standing(session: &Session, test: &Test, moving: &[usize]) -> Result<Vec<f64>, MotionError> {
    (0..session.machine.axes.len())
        .map(|axis| match test.positions.get(axis).copied().flatten() {
            _ if moving.contains(&axis) => Ok(0.0),
            Some(value) => Ok(value),
            None => {
                Err(MotionError::AxisUnknown { test: test.name.clone(), axis: session.machine.axes[axis].name.clone() })
            }
        })
        .collect()
}

fn ball_links(chain: &Chain, test: &Test) -> Result<(LinkId, LinkId), MotionError> {
    let link = |name: &str| {
        chain.link(name).ok_or_else(|| MotionError::NoLink {
            test: test.name.clone(),
            link: name.to_string(),
            known: chain.link_names().join(" "),
        })
    };
    Ok((link(&test.pivot.link)?, link(&test.spindle_ball.link)?))
}

/// Feed of the moving ball when a test states none, mm/min.
const DEFAULT_FEED_MM_PER_MIN: f64 = 500.0;
/// Bar of a planned test that names none, mm: the shortest usual one.
const DEFAULT_BAR_MM: f64 = 100.0;
/// How far before and behind its arc a test runs when it does not say, mm or deg.
pub const DEFAULT_RUN_IN: f64 = 4.0;

/// Part of what the linear axes move below which a ball stands still as seen from the other: rounding.
const STANDS_STILL: f64 = 1e-3;

/// Turn over which a chord stands for its arc, deg: it is shorter by 1.3e-3.
const CHORD_DEG: f64 = 10.0;
/// Most chords between two rows: ten turns.
const MOST_CHORDS: f64 = 360.0;

/// Way between two rows that the feed counts, mm: of one ball as seen from the other, whatever carries them. Where a bar
/// keeps its direction (axial following) neither ball moves for the other: there it is the way of the linear axes together,
/// on which the carried ball goes about the turning axis.
pub fn way_mm(geometry: &Geometry, test: &Test, links: (LinkId, LinkId), from: &[f64], to: &[f64]) -> f64 {
    let bar = |q: &[f64]| test.bar(geometry, links, q);
    let kind = |axis: usize| geometry.chain().joint(axis).kind;
    let linear = (0..to.len()).filter(|&axis| kind(axis) == AxisKind::Linear);
    let slides = linear.map(|axis| (to[axis] - from[axis]).powi(2)).sum::<f64>().sqrt();
    // rows may be far apart: a whole turn between two of them is no way of nothing
    let rotary = (0..to.len()).filter(|&axis| kind(axis) == AxisKind::Rotary);
    let turned = rotary.map(|axis| (to[axis] - from[axis]).abs()).fold(0.0, f64::max);
    let parts = (turned.to_degrees() / CHORD_DEG).ceil().clamp(1.0, MOST_CHORDS);
    let at = |part: f64| -> Vec<f64> { from.iter().zip(to).map(|(a, b)| a + (b - a) * part / parts).collect() };
    let mut before = bar(from);
    let mut seen = 0.0;
    for part in 1..=parts as usize {
        let here = if part as f64 == parts { bar(to) } else { bar(&at(part as f64)) };
        seen += (here - before).norm();
        before = here;
    }
    if seen > STANDS_STILL * slides { seen } else { slides }
}

/// Times at which the samples are passed at the stated feed.
fn path_times(session: &Session, chain: &Chain, test: &Test, columns: &[(usize, Vec<f64>)], rows: usize) -> Vec<f64> {
    let speed_mm_per_s = test.feed() / 60.0;
    let links = ball_links(chain, test).ok();
    let moving: Vec<usize> = columns.iter().map(|(axis, _)| *axis).collect();
    let (Some(links), Ok(mut q)) = (links, standing(session, test, &moving)) else {
        return (0..rows).map(|row| row as f64).collect();
    };
    let geometry = Geometry::nominal(chain);
    // rows of a circle may lie at one place, a whole turn apart
    let arc_mm = test.path.as_ref().and_then(|path| path.arc_mm(rows, CHORD_DEG)).unwrap_or(0.0);
    let mut last: Option<Vec<f64>> = None;
    let mut time = 0.0;
    (0..rows)
        .map(|row| {
            for (axis, column) in columns {
                q[*axis] = column[row];
            }
            if let Some(last) = &last {
                time += way_mm(&geometry, test, links, last, &q).max(arc_mm) / speed_mm_per_s;
            }
            last = Some(q.clone());
            time
        })
        .collect()
}

impl Test {
    /// Feed of the moving ball as stated, or as usual, mm/min.
    pub fn feed(&self) -> f64 {
        self.feed_mm_per_min.unwrap_or(DEFAULT_FEED_MM_PER_MIN)
    }

    /// Distance at which a path keeps the balls that says none, mm: the whole number nearest to the bar's calibrated length, 100 without a
    /// bar.
    pub fn nominal_bar_mm(&self) -> f64 {
        self.bar_length_mm.map_or(DEFAULT_BAR_MM, |bar_mm| bar_mm.round().max(1.0))
    }

    /// How far before and behind its arc it runs as stated, or as usual, mm or deg.
    pub fn run_in(&self) -> f64 {
        self.overshoot.unwrap_or(DEFAULT_RUN_IN)
    }

    /// From the pivot ball to the spindle ball, mm, axes standing at `q`; `links` carry the two.
    pub fn bar(&self, geometry: &Geometry, links: (LinkId, LinkId), q: &[f64]) -> Vector3<f64> {
        geometry.point(links.1, &self.spindle_ball.at, q, None) - geometry.point(links.0, &self.pivot.at, q, None)
    }

    /// Links of pivot ball and spindle ball in a chain.
    pub fn links(&self, chain: &Chain) -> Result<(LinkId, LinkId), MotionError> {
        ball_links(chain, self)
    }
}
