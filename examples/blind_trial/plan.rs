//! A session as planned: machine, setups, tests and where every axis is at any time; no errors and no noise.

use super::kinematics::{AXES, Ball, Machine, Quaternion, V3, scale};

/// Degrees or mm by which a capture is approached and left outside its arc.
pub const OVERSHOOT: f64 = 4.0;

/// A bar and what its calibration missed.
#[derive(Clone, Debug)]
pub struct Bar {
    pub nominal_mm: f64,
    pub calibrated_mm: f64,
    pub reading_error_mm: f64,
}

/// How the axes move in a test.
#[derive(Clone, Debug)]
pub enum Path {
    /// One axis turns, the others stand at `standing`.
    Turn { axis: usize, standing: [f64; AXES] },
    /// One joint turns and the slides keep the bar's direction in its turning frame.
    Follow { axis: usize, standing: [f64; AXES], relative: V3 },
    /// Two slides carry the balls about each other in the plane of `u` and `w`.
    Circle { standing: [f64; AXES], u: V3, w: V3, radius_mm: f64 },
}

/// One recording to be made.
#[derive(Clone, Debug)]
pub struct Test {
    pub name: String,
    pub started_at_s: f64,
    pub pivot: usize,
    pub ball: usize,
    pub bar: usize,
    pub feed: f64,
    pub path: Path,
    /// Sweep variable in degrees at the first row and where the arc ends.
    pub from_deg: f64,
    pub to_deg: f64,
    pub rate_deg_s: f64,
    pub step_s: f64,
    pub rows: usize,
    /// Axes with a column of their own.
    pub moving: Vec<usize>,
}

/// A ball place with its unknown placement error.
#[derive(Clone, Debug)]
pub struct Placed {
    pub ball: Ball,
    pub offset_mm: V3,
    /// Placement one sigma, mm.
    pub spread_mm: f64,
}

/// Room or spindle temperature: a rise with one time constant and a slow wobble.
#[derive(Clone, Debug)]
pub struct Temperature {
    pub start_degc: f64,
    pub rise_k: f64,
    pub tau_s: f64,
    pub wobble_k: f64,
    pub period_s: f64,
}

impl Temperature {
    pub fn at(&self, t_s: f64) -> f64 {
        self.start_degc
            + self.rise_k * (1.0 - (-t_s / self.tau_s).exp())
            + self.wobble_k * (std::f64::consts::TAU * t_s / self.period_s).sin()
    }
}

#[derive(Clone, Debug)]
pub struct Plan {
    pub machine: Machine,
    pub design: String,
    pub tests: Vec<Test>,
    pub pivots: Vec<Placed>,
    pub balls: Vec<Placed>,
    pub bars: Vec<Bar>,
    /// Written as a channel when present.
    pub temperature: Option<Temperature>,
}

/// One instant of the session's motion.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    pub t_s: f64,
    pub q: [f64; AXES],
    /// Test and row when this instant is recorded.
    pub row: Option<(usize, usize)>,
}

impl Plan {
    pub fn end_s(&self) -> f64 {
        self.tests.iter().map(|t| t.started_at_s + t.rows as f64 * t.step_s).fold(0.0, f64::max)
    }

    pub fn pivot(&self, test: &Test) -> Ball {
        self.pivots[test.pivot].ball
    }

    pub fn ball(&self, test: &Test) -> Ball {
        self.balls[test.ball].ball
    }

    /// Commanded positions `t_s` after the first row; negative and late times are the approach and the run-out.
    pub fn axes_at(&self, test: &Test, t_s: f64) -> [f64; AXES] {
        let sense = (test.to_deg - test.from_deg).signum();
        self.axes_on(test, test.from_deg + sense * test.rate_deg_s * t_s)
    }

    /// Commanded positions at a value of the sweep variable.
    pub fn axes_on(&self, test: &Test, s_deg: f64) -> [f64; AXES] {
        match &test.path {
            Path::Turn { axis, standing } => {
                let mut q = *standing;
                q[*axis] = s_deg;
                q
            }
            Path::Follow { axis, standing, relative } => {
                let mut q = *standing;
                q[*axis] = s_deg;
                let now = self.turned(*axis, s_deg, standing, *relative);
                self.machine.slides_for(self.pivot(test), self.ball(test), &mut q, now);
                q
            }
            Path::Circle { standing, u, w, radius_mm } => {
                let (s, c) = s_deg.to_radians().sin_cos();
                let mut q = *standing;
                let r = *radius_mm;
                let relative = [0, 1, 2].map(|i| r * (c * u[i] + s * w[i]));
                self.machine.slides_for(self.pivot(test), self.ball(test), &mut q, relative);
                q
            }
        }
    }

    /// A vector fixed in the frame behind `axis` at zero, seen in the reference frame with the axis at `s_deg`.
    pub fn turned(&self, axis: usize, s_deg: f64, standing: &[f64; AXES], x: V3) -> V3 {
        let mut q = *standing;
        q[axis] = s_deg;
        let mut x = x;
        for &j in self.machine.branch(super::kinematics::Link::Axis(axis)).iter().rev() {
            let joint = &self.machine.joints[j];
            if joint.rotary {
                let sense = if joint.reversed { -1.0 } else { 1.0 };
                x = Quaternion::about(joint.direction, (sense * q[j]).to_radians()).turn(x);
            }
        }
        x
    }

    /// The whole session's motion in order of time: straight moves between tests, approach, rows, run-out.
    pub fn walk(&self) -> Vec<Step> {
        let mut order: Vec<usize> = (0..self.tests.len()).collect();
        order.sort_by(|&a, &b| self.tests[a].started_at_s.total_cmp(&self.tests[b].started_at_s));
        let mut steps = vec![Step { t_s: 0.0, q: [0.0; AXES], row: None }];
        for i in order {
            let test = &self.tests[i];
            let lead_s = OVERSHOOT / test.rate_deg_s;
            let start_s = test.started_at_s - lead_s;
            self.straight_to(&mut steps, start_s, self.axes_at(test, -lead_s));
            let mut at = |t: f64, row| steps.push(Step { t_s: test.started_at_s + t, q: self.axes_at(test, t), row });
            for k in (1..20).rev() {
                at(-lead_s * f64::from(k) / 20.0, None);
            }
            for row in 0..test.rows {
                at(row as f64 * test.step_s, Some((i, row)));
            }
            let last_s = (test.rows - 1) as f64 * test.step_s;
            for k in 1..=10 {
                at(last_s + lead_s * f64::from(k) / 10.0, None);
            }
        }
        steps
    }

    fn straight_to(&self, steps: &mut Vec<Step>, t_s: f64, q: [f64; AXES]) {
        let from = steps[steps.len() - 1];
        for k in 1..=10 {
            let f = f64::from(k) / 10.0;
            let mut at = from.q;
            for j in 0..AXES {
                at[j] += f * (q[j] - at[j]);
            }
            steps.push(Step { t_s: from.t_s + f * (t_s - from.t_s).max(0.01), q: at, row: None });
        }
    }

    /// Smallest and largest commanded position of an axis over all rows.
    pub fn travel(&self, axis: usize) -> (f64, f64) {
        let mut span = (f64::INFINITY, f64::NEG_INFINITY);
        for test in &self.tests {
            for row in (0..test.rows).step_by(5) {
                let q = self.axes_at(test, row as f64 * test.step_s)[axis];
                span = (span.0.min(q), span.1.max(q));
            }
        }
        span
    }

    /// Gravity, in the frame of the part that carries `axis` (behind it when `behind`), for positions `q`.
    pub fn gravity_in(&self, axis: usize, q: &[f64; AXES], behind: bool) -> V3 {
        let mut g = [0.0, 0.0, -1.0];
        for &j in self.machine.branch(super::kinematics::Link::Axis(axis)) {
            let joint = &self.machine.joints[j];
            if joint.rotary && (j != axis || behind) {
                let sense = if joint.reversed { 1.0 } else { -1.0 };
                g = Quaternion::about(joint.direction, (sense * q[j]).to_radians()).turn(g);
            }
        }
        scale(g, 1.0)
    }
}
