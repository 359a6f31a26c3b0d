//! What effects may depend on: positions, speeds, session time and the way by which every test was reached. No effect values.

use std::sync::OnceLock;

use nalgebra::Vector3;

use crate::chain::{Chain, Geometry, sines_and_cosines};
use crate::machine::{AxisKind, Effect, Machine, Place};
use crate::session::{APPROACHED_OVER, Clock, Motion, MotionError, RunEnd, Session, Test, beyond, marked};

/// Values of one function: by test in the order of the session file, then by row.
pub type Profile = Vec<Vec<f64>>;

/// Places on the approach between its start and the first row, as shares of the overshoot.
const APPROACH_SHARES: [f64; 4] = [1.0, 0.75, 0.5, 0.25];

/// mm in a metre.
const MM_PER_M: f64 = 1e3;
/// Rows through which speeds are taken.
const SPEED_ROWS: usize = 5;
/// Two bars are one when their calibrated lengths differ by less, mm.
pub(super) const SAME_BAR_MM: f64 = 0.5;

/// Motions of all tests of a session, with the history between them.
#[derive(Debug, Clone)]
pub struct Context<'a> {
    session: &'a Session,
    chain: &'a Chain,
    motions: Vec<Motion>,
    /// Tests by time; ties in the order of the file.
    order: Vec<usize>,
    /// Positions passed before the first row of each test, row by row.
    approaches: Vec<Vec<f64>>,
    /// By axis, once asked for: see [`Context::squared_arm_m2`].
    squared_arms_m2: Vec<OnceLock<Profile>>,
    /// From the pivot ball and from the spindle ball, once asked for: see [`Context::bar_directions`].
    bar_directions: [OnceLock<Vec<Vec<Vector3<f64>>>>; 2],
    /// Once asked for: see [`Context::bar_sines`].
    bar_sines: OnceLock<Profile>,
}

/// One step of the history of an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Travel {
    /// Distance moved in the mechanical positive sense, mm or rad.
    pub distance: f64,
    /// Time it took, s; `None` between tests and on approaches.
    pub seconds: Option<f64>,
    /// Distance to the row after, mm or rad; zero where none follows.
    pub next: f64,
    /// Position reached as commanded, mm or rad.
    pub at: f64,
}

impl<'a> Context<'a> {
    /// Motions and history of a session.
    pub fn of(session: &'a Session, chain: &'a Chain) -> Result<Context<'a>, MotionError> {
        let motions =
            session.tests.iter().map(|test| Motion::of(session, chain, test)).collect::<Result<Vec<_>, _>>()?;
        let mut order: Vec<usize> = (0..motions.len()).collect();
        order.sort_by(|&a, &b| session.tests[a].started_at_s.total_cmp(&session.tests[b].started_at_s));
        let approaches = (0..motions.len()).map(|test| approach(session, &motions[test], test)).collect();
        let squared_arms_m2 = session.machine.axes.iter().map(|_| OnceLock::new()).collect();
        let bar_directions = Default::default();
        let bar_sines = OnceLock::new();
        Ok(Context { session, chain, motions, order, approaches, squared_arms_m2, bar_directions, bar_sines })
    }

    /// The session.
    pub fn session(&self) -> &Session {
        self.session
    }

    /// The machine.
    pub fn machine(&self) -> &Machine {
        &self.session.machine
    }

    /// The nominal chain.
    pub fn chain(&self) -> &Chain {
        self.chain
    }

    /// Motion of a test.
    pub fn motion(&self, test: usize) -> &Motion {
        &self.motions[test]
    }

    /// Number of tests.
    pub fn tests(&self) -> usize {
        self.motions.len()
    }

    /// Whether a test is made with the bar of this calibrated length, mm.
    pub fn has_bar(&self, test: usize, bar_mm: f64) -> bool {
        self.session.tests[test].bar_length_mm.is_some_and(|length_mm| (length_mm - bar_mm).abs() < SAME_BAR_MM)
    }

    /// Whether a test has the bar that an effect names; any has where it names none.
    pub fn has_named_bar(&self, test: usize, effect: &Effect) -> bool {
        effect.number("bar").is_none_or(|bar_mm| self.has_bar(test, bar_mm))
    }

    /// Tests by time.
    pub fn order(&self) -> &[usize] {
        &self.order
    }

    /// Seconds since the session began at a row; static poses have the time at which their test began.
    pub fn session_time_s(&self, test: usize, row: usize) -> f64 {
        let within = self.motions[test].time_s.as_ref().map_or(0.0, |time| time[row]);
        self.session.tests[test].started_at_s + within
    }

    /// Number of the pose of a row as its file states it; that of the row where there is none.
    pub fn pose_number(&self, test: usize, row: usize) -> f64 {
        match self.session.tests[test].recording.as_ref().map(|recording| &recording.clock) {
            Some(Clock::Pose(numbers)) => numbers[row],
            _ => row as f64,
        }
    }

    /// Seconds since the session began at the last row of a test.
    pub fn ends_at_s(&self, test: usize) -> f64 {
        match self.motions[test].rows() {
            0 => self.session.tests[test].started_at_s,
            rows => self.session_time_s(test, rows - 1),
        }
    }

    /// A profile from a value per test and row.
    pub fn profile(&self, value: impl Fn(usize, usize) -> f64) -> Profile {
        self.profile_in(|_| true, value)
    }

    /// The same in tests where it acts, and zero in the others.
    pub fn profile_in(&self, acts: impl Fn(usize) -> bool, value: impl Fn(usize, usize) -> f64) -> Profile {
        let in_test = |test: usize| {
            let rows = self.motions[test].rows();
            if acts(test) { (0..rows).map(|row| value(test, row)).collect() } else { vec![0.0; rows] }
        };
        (0..self.tests()).map(in_test).collect()
    }

    /// A profile from the position (mm or rad, as commanded) of one axis.
    pub fn position_profile(&self, axis: usize, value: impl Fn(f64) -> f64) -> Profile {
        let in_test = |motion: &Motion| {
            // an axis at rest keeps its value
            let (mut at, mut there) = (f64::NAN, f64::NAN);
            let of_row = |row| {
                let q = motion.row(row)[axis];
                if q != at {
                    (at, there) = (q, value(q));
                }
                there
            };
            (0..motion.rows()).map(of_row).collect()
        };
        self.motions.iter().map(in_test).collect()
    }

    /// Profiles of the cosine and the sine of so many radians per mm or rad of one axis.
    pub fn position_waves(&self, axis: usize, per_unit: f64) -> [Profile; 2] {
        let in_test = |motion: &Motion| {
            let angles: Vec<f64> = motion.axis(axis).map(|q| per_unit * q).collect();
            let stands = angles.windows(2).all(|pair| pair[0] == pair[1]);
            match angles.first().filter(|_| stands) {
                Some(angle) => (vec![angle.cos(); angles.len()], vec![angle.sin(); angles.len()]),
                None => {
                    let (sines, cosines) = sines_and_cosines(&angles);
                    (cosines, sines)
                }
            }
        };
        let (cosines, sines) = self.motions.iter().map(in_test).unzip();
        [cosines, sines]
    }

    /// Speed of an axis (mm/s or rad/s, as commanded); zero without times.
    ///
    /// The slope of the polynomial through neighbouring rows: where linear axes follow a rotary one, speeds of some mm/s
    /// cancel in the bar's direction down to what location errors leave, which plain differences would drown.
    pub fn speed(&self, test: usize, row: usize, axis: usize) -> f64 {
        let motion = &self.motions[test];
        let Some(time) = &motion.time_s else { return 0.0 };
        let rows = motion.rows();
        let count = rows.min(SPEED_ROWS);
        let first = row.saturating_sub(count / 2).min(rows - count);
        let here = row - first;
        let mut slope = 0.0;
        for j in 0..count {
            if j == here {
                continue;
            }
            // weight of a neighbour in the derivative at this row, in Lagrange's form
            let mut weight = 1.0 / (time[first + j] - time[row]);
            for k in (0..count).filter(|&k| k != j && k != here) {
                weight *= (time[row] - time[first + k]) / (time[first + j] - time[first + k]);
            }
            slope += weight * (motion.row(first + j)[axis] - motion.row(row)[axis]);
        }
        if slope.is_finite() { slope } else { 0.0 }
    }

    /// Acceleration of an axis (mm/s² or rad/s², as commanded) by second differences; the ends repeat their neighbours.
    pub fn acceleration(&self, test: usize, row: usize, axis: usize) -> f64 {
        let motion = &self.motions[test];
        let Some(time) = &motion.time_s else { return 0.0 };
        if motion.rows() < 3 {
            return 0.0;
        }
        let row = row.clamp(1, motion.rows() - 2);
        let q = |row: usize| motion.row(row)[axis];
        let (early, late) = (time[row] - time[row - 1], time[row + 1] - time[row]);
        if early > 0.0 && late > 0.0 {
            2.0 * ((q(row + 1) - q(row)) / late - (q(row) - q(row - 1)) / early) / (early + late)
        } else {
            0.0
        }
    }

    /// Squared distance of the ball that an axis carries from the line of that axis, m²; 0 for a slide.
    pub fn squared_arm_m2(&self, axis: usize) -> &Profile {
        self.squared_arms_m2[axis].get_or_init(|| {
            let geometry = Geometry::nominal(self.chain);
            self.profile(|test, row| self.squared_arm_at(&geometry, axis, test, row))
        })
    }

    /// Unit vectors from the ball of a place to the other one, in the frame that carries it; by test, then by row.
    pub fn bar_directions(&self, place: Place) -> &[Vec<Vector3<f64>>] {
        let from_pivot = place == Place::Pivot;
        self.bar_directions[usize::from(!from_pivot)].get_or_init(|| {
            let geometry = Geometry::nominal(self.chain);
            (0..self.tests()).map(|test| self.bar_directions_in(&geometry, from_pivot, test)).collect()
        })
    }

    fn bar_directions_in(&self, geometry: &Geometry, from_pivot: bool, test: usize) -> Vec<Vector3<f64>> {
        let (motion, balls) = (&self.motions[test], &self.session.tests[test]);
        let (here, there) = match from_pivot {
            true => (&balls.pivot, &balls.spindle_ball),
            false => (&balls.spindle_ball, &balls.pivot),
        };
        let (Some(here_link), Some(there_link)) = (self.chain.link(&here.link), self.chain.link(&there.link)) else {
            return vec![Vector3::z(); motion.rows()];
        };
        let row = |row: usize| {
            let positions = motion.row(row);
            let cup = geometry.pose(here_link, positions, None);
            let way = geometry.pose(there_link, positions, None).point(&there.at) - cup.point(&here.at);
            cup.rotation.tr_mul(&way).try_normalize(0.0).unwrap_or_else(Vector3::z)
        };
        (0..motion.rows()).map(row).collect()
    }

    /// Sine of the bar's angle above the level, from the pivot up to the spindle ball, by test and row.
    pub fn bar_sines(&self) -> &[Vec<f64>] {
        self.bar_sines.get_or_init(|| {
            let geometry = Geometry::nominal(self.chain);
            (0..self.tests()).map(|test| self.bar_sines_in(&geometry, test)).collect()
        })
    }

    fn bar_sines_in(&self, geometry: &Geometry, test: usize) -> Vec<f64> {
        let (motion, balls) = (&self.motions[test], &self.session.tests[test]);
        let (pivot, ball) = (&balls.pivot, &balls.spindle_ball);
        let (Some(below), Some(above)) = (self.chain.link(&pivot.link), self.chain.link(&ball.link)) else {
            return vec![0.0; motion.rows()];
        };
        let gravity = self.machine().gravity;
        let sine = |row: usize| {
            let place = |link, at| geometry.pose(link, motion.row(row), None).point(at);
            let way = place(above, &ball.at) - place(below, &pivot.at);
            way.try_normalize(0.0).map_or(0.0, |way| -way.dot(&gravity))
        };
        (0..motion.rows()).map(sine).collect()
    }

    fn squared_arm_at(&self, geometry: &Geometry, axis: usize, test: usize, row: usize) -> f64 {
        if self.machine().axes[axis].kind == AxisKind::Linear {
            return 0.0;
        }
        let chain = self.chain;
        let test_of = &self.session.tests[test];
        let link = |name: &str| chain.link(name).unwrap_or(chain.carried_by(axis));
        let carried =
            if chain.carries(axis, link(&test_of.spindle_ball.link)) { &test_of.spindle_ball } else { &test_of.pivot };
        let positions = self.motions[test].row(row);
        let joint = geometry.pose(chain.carried_by(axis), positions, None);
        let ball = geometry.pose(link(&carried.link), positions, None).point(&carried.at);
        let direction = joint.rotation * chain.joint(axis).direction;
        let arm = ball - joint.point(&chain.joint(axis).origin);
        (arm - direction * arm.dot(&direction)).norm_squared() / (MM_PER_M * MM_PER_M)
    }

    /// Runs a state along everything an axis has done in the session and reads it at every row.
    ///
    /// The axis is followed through tests by time, over the approach of each; `sign` of a reversed axis is applied,
    /// so that distances are those of the mechanism.
    pub fn along<S>(
        &self,
        axis: usize,
        mut state: S,
        mut advance: impl FnMut(&mut S, Travel),
        read: impl Fn(&S) -> f64,
    ) -> Profile {
        let sign = self.chain.joint(axis).sign;
        let axis_count = self.machine().axes.len();
        let mut profile = vec![Vec::new(); self.tests()];
        let mut last: Option<f64> = None;
        for &test in &self.order {
            let motion = &self.motions[test];
            for q in self.approaches[test].iter().skip(axis).step_by(axis_count) {
                let distance = sign * (q - last.unwrap_or(*q));
                advance(&mut state, Travel { distance, seconds: None, next: 0.0, at: *q });
                last = Some(*q);
            }
            profile[test] = (0..motion.rows())
                .map(|row| {
                    let q = motion.row(row)[axis];
                    let distance = sign * (q - last.unwrap_or(q));
                    let seconds = motion.time_s.as_ref().filter(|_| row > 0).map(|time| time[row] - time[row - 1]);
                    let next = if row + 1 < motion.rows() { motion.row(row + 1)[axis] - q } else { 0.0 };
                    advance(&mut state, Travel { distance, seconds, next: sign * next, at: q });
                    last = Some(q);
                    read(&state)
                })
                .collect();
        }
        profile
    }
}

/// Positions passed on the way to the first row: from where standing axes came, then the mark of the program, out along the bar and
/// back, which moves slides that may stand in the run, then the run-in.
fn approach(session: &Session, motion: &Motion, test: usize) -> Vec<f64> {
    let test = &session.tests[test];
    if motion.rows() == 0 {
        return Vec::new();
    }
    let run_in = beyond(session, motion, test, RunEnd::Start, &APPROACH_SHARES);
    let axes = &session.machine.axes;
    let start = run_in.get(..axes.len()).unwrap_or(motion.row(0)).to_vec();
    let marked = (!run_in.is_empty()).then(|| marked(&session.machine, test, &start, test.marks?.move_mm)).flatten();
    let marked = marked.map_or(Vec::new(), |out| [start.clone(), out].concat());
    [came_from(session, test, &start), marked, run_in].concat()
}

/// A place from which the axes come to a start in the senses that a test states; none where it states none.
fn came_from(session: &Session, test: &Test, start: &[f64]) -> Vec<f64> {
    if test.approached.iter().all(Option::is_none) {
        return Vec::new();
    }
    let axes = session.machine.axes.iter().zip(&test.approached).zip(start);
    axes.map(|((axis, sense), q)| q - sense.unwrap_or(0.0) * axis.kind.from_file_unit(APPROACHED_OVER)).collect()
}
