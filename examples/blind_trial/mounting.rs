//! How one test is mounted: seats of the balls, the bar, where the slides stand and when it runs; picks no tests.

use super::designs::Manner;
use super::draw::Draw;
use super::kinematics::{AXES, Ball, Link, V3, add, cross, dot, norm, scale, sub, unit};
use super::plan::{Bar, Path, Placed, Plan, Test};

/// Builds the tests one after another, keeping setups and bars that several share.
pub struct Builder<'a> {
    pub plan: Plan,
    pub manner: &'a Manner,
    pub rng: &'a mut Draw,
    pub clock_s: f64,
    pub turning: usize,
    pub tilting: usize,
}

/// Which of the orbiting ball's setups a test uses.
#[derive(Clone, Copy, PartialEq)]
pub enum Seat {
    Main,
    Inner,
}

impl Builder<'_> {
    /// One joint turns; the other ball stands `along_mm` off the centre of the orbit.
    pub fn turn(&mut self, name: &str, axis: usize, arc: (f64, f64), along_mm: f64, feed: f64, seat: Seat) {
        let (pivot, ball, radius, outward) = self.orbit(axis, seat);
        let k = self.plan.machine.joints[axis].direction;
        let to_centre = if self.plan.machine.on_tool_side(axis) { 1.0 } else { -1.0 };
        // "neg" and "pos" name the side by the slide's own reading, which a moving table counts the other way
        let carried = |j: usize| dot(self.plan.machine.joints[j].direction, k).abs() > 0.9;
        let table_slide = self.plan.machine.work.iter().any(|&j| !self.plan.machine.joints[j].rotary && carried(j));
        let along_mm = if table_slide && axis == self.tilting { -along_mm } else { along_mm };
        let relative = add(scale(outward, to_centre * radius), scale(k, along_mm));
        let mut standing = [0.0; AXES];
        let (p, s) = (self.plan.pivots[pivot].ball, self.plan.balls[ball].ball);
        self.plan.machine.slides_for(p, s, &mut standing, relative);
        for q in &mut standing {
            *q = (*q * 1e6).round() / 1e6;
        }
        let bar = (radius * radius + along_mm * along_mm).sqrt();
        let path = Path::Turn { axis, standing };
        self.both_ways(name, path, arc, (pivot, ball), bar, feed, feed / 60.0 / radius);
    }

    /// One joint turns and the slides follow, the bar fixed in the turning frame.
    pub fn follow(&mut self, name: &str, axis: usize, arc: (f64, f64), follow: &str, feed: f64, tilt_deg: f64) {
        let (pivot, ball, radius, outward) = self.orbit_from(axis, Seat::Main, None);
        let k = self.plan.machine.joints[axis].direction;
        let bar = 100.0;
        let along = match follow {
            "radial" => outward,
            "tangential" => unit(cross(k, outward)),
            _ => k,
        };
        let mut standing = [0.0; AXES];
        if axis != self.tilting {
            standing[self.tilting] = tilt_deg;
        }
        let path = Path::Follow { axis, standing, relative: scale(along, bar) };
        self.both_ways(name, path, arc, (pivot, ball), bar, feed, feed / 60.0 / radius);
    }

    /// Pivot, ball, orbit radius and outward direction (all axes at zero) of the ball that a joint carries around.
    pub fn orbit(&mut self, axis: usize, seat: Seat) -> (usize, usize, f64, V3) {
        self.orbit_from(axis, seat, Some(axis))
    }

    /// The same from the pivot seat for the tests of `beside`, or from the usual one.
    fn orbit_from(&mut self, axis: usize, seat: Seat, beside: Option<usize>) -> (usize, usize, f64, V3) {
        let tool_side = self.plan.machine.on_tool_side(axis);
        let pivot = self.pivot(seat, beside);
        let ball = self.ball(seat, Some(axis));
        let moving = if tool_side { self.plan.balls[ball].ball.at } else { self.plan.pivots[pivot].ball.at };
        let joint = &self.plan.machine.joints[axis];
        let arm = sub(moving, joint.origin);
        let outward = sub(arm, scale(joint.direction, dot(arm, joint.direction)));
        (pivot, ball, norm(outward), unit(outward))
    }

    /// The pivot seat on the last workpiece-side part.
    pub fn pivot(&mut self, seat: Seat, axis: Option<usize>) -> usize {
        let link = self.plan.machine.work.last().map_or(Link::Bed, |&j| Link::Axis(j));
        let turns = self.plan.machine.work.iter().any(|&j| self.plan.machine.joints[j].rotary);
        let tool_axis = axis.is_some_and(|j| self.plan.machine.on_tool_side(j));
        // on the table beside both joints' lines
        let aside =
            if self.plan.machine.joints[self.tilting].direction[1] > 0.9 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        let at = match (turns, tool_axis, seat) {
            (false, ..) => [0.0; 3],
            (true, true, _) => [0.0, 0.0, 150.0],
            (true, false, Seat::Main) => scale(aside, self.manner.table_radius_mm),
            (true, false, Seat::Inner) => scale(aside, -60.0),
        };
        placed(&mut self.plan.pivots, Ball { link, at }, 0.020)
    }

    /// The ball in the spindle: on its centre where that orbits the joint, else on an arm.
    pub fn ball(&mut self, seat: Seat, axis: Option<usize>) -> usize {
        let link = self.plan.machine.tool.last().map_or(Link::Bed, |&j| Link::Axis(j));
        let on_spindle = axis.is_some_and(|j| self.plan.machine.on_tool_side(j) && j == self.turning);
        let (at, spread) = match (on_spindle, seat) {
            (false, _) => ([0.0; 3], 0.003),
            (true, Seat::Main) => ([self.manner.table_radius_mm, 0.0, 0.0], 0.020),
            (true, Seat::Inner) => ([60.0, 0.0, 0.0], 0.020),
        };
        placed(&mut self.plan.balls, Ball { link, at }, spread)
    }

    /// Adds the test counter-clockwise and clockwise from one setup; `rate` is the joint's in rad/s.
    #[allow(clippy::too_many_arguments)]
    pub fn both_ways(
        &mut self,
        name: &str,
        path: Path,
        arc: (f64, f64),
        seats: (usize, usize),
        bar_mm: f64,
        feed: f64,
        rate: f64,
    ) {
        let bar = self.bar(bar_mm);
        let rate_deg_s = rate.to_degrees();
        let remounted = self.plan.tests.last().is_none_or(|t| (t.pivot, t.ball, t.bar) != (seats.0, seats.1, bar));
        let pause = if remounted { self.rng.between(110.0, 200.0) } else { self.rng.between(15.0, 60.0) };
        self.clock_s += pause;
        let ways = if self.manner.cw_first { ["cw", "ccw"] } else { ["ccw", "cw"] };
        for way in ways {
            let (from_deg, to_deg) = if way == "ccw" { arc } else { (arc.1, arc.0) };
            let duration_s = (arc.1 - arc.0) / rate_deg_s;
            let step_s = step_for(duration_s, 700.0 * self.manner.density);
            let mut test = Test {
                name: format!("{name}-{way}"),
                started_at_s: (self.clock_s * 10.0).round() / 10.0,
                pivot: seats.0,
                ball: seats.1,
                bar,
                feed,
                path: path.clone(),
                from_deg,
                to_deg,
                rate_deg_s,
                step_s,
                rows: (duration_s / step_s + 1e-9).floor() as usize + 1,
                moving: vec![],
            };
            test.moving = self.moving(&test);
            self.clock_s += duration_s + self.rng.between(7.0, 18.0);
            self.plan.tests.push(test);
        }
    }

    fn moving(&self, test: &Test) -> Vec<usize> {
        let at = |f: f64| self.plan.axes_on(test, test.from_deg + f * (test.to_deg - test.from_deg));
        let first = at(0.0);
        (0..AXES).filter(|&j| (1..9).any(|k| (at(f64::from(k) / 9.7)[j] - first[j]).abs() > 1e-9)).collect()
    }

    fn bar(&mut self, length_mm: f64) -> usize {
        let nominal_mm = (length_mm * 100.0).round() / 100.0;
        if let Some(i) = self.plan.bars.iter().position(|b| (b.nominal_mm - nominal_mm).abs() < 0.02) {
            return i;
        }
        let calibrated_mm = ((nominal_mm + 0.012 * self.rng.normal()) * 1e4).round() / 1e4;
        let reading_error_mm = 0.0005 * self.rng.normal();
        self.plan.bars.push(Bar { nominal_mm, calibrated_mm, reading_error_mm });
        self.plan.bars.len() - 1
    }
}

/// The seat at a place, made when it is new.
fn placed(seats: &mut Vec<Placed>, ball: Ball, spread_mm: f64) -> usize {
    if let Some(i) = seats.iter().position(|s| s.ball == ball) {
        return i;
    }
    seats.push(Placed { ball, offset_mm: [0.0; 3], spread_mm });
    seats.len() - 1
}

/// Sampling interval of a usual recorder rate that gives about `rows` rows.
fn step_for(duration_s: f64, rows: f64) -> f64 {
    const RATES_HZ: &[f64] =
        &[1.0, 2.0, 3.0, 4.0, 5.0, 8.0, 10.0, 12.0, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0, 80.0, 100.0, 125.0];
    let best = RATES_HZ
        .iter()
        .min_by(|a, b| ((duration_s * **a / rows).ln().abs()).total_cmp(&(duration_s * **b / rows).ln().abs()))
        .unwrap_or(&25.0);
    1.0 / best
}
