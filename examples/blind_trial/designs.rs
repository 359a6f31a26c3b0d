//! Test designs: which recordings a session consists of, on any machine drawn; no errors and no noise.

use super::draw::Draw;
use super::kinematics::{AXES, Ball, Link, Machine, V3, add, cross, dot, norm, scale, sub, unit};
use super::plan::{Bar, Path, Placed, Plan, Test};

/// Designs and how often each is drawn.
pub const DESIGNS: &[(&str, f64)] = &[
    ("full", 3.0),
    ("bidirectional", 2.0),
    ("synchronous", 2.0),
    ("planar", 2.0),
    ("thesis4", 1.0),
    ("mixed", 1.0),
];

/// Choices within a design that do not change what it is called.
pub struct Manner {
    /// Clockwise before counter-clockwise.
    pub cw_first: bool,
    /// Multiplies the number of rows.
    pub density: f64,
    /// Radius at which the table ball stands from the turning joint, mm.
    pub table_radius_mm: f64,
}

impl Manner {
    pub fn usual() -> Self {
        Manner {
            cw_first: false,
            density: 1.0,
            table_radius_mm: 100.0,
        }
    }

    pub fn draw(rng: &mut Draw) -> Self {
        let usual = Manner::usual();
        Manner {
            cw_first: rng.chance(0.2),
            density: if rng.chance(0.6) {
                usual.density
            } else {
                rng.between(0.6, 1.1)
            },
            table_radius_mm: if rng.chance(0.6) {
                usual.table_radius_mm
            } else {
                rng.between(85.0, 140.0).round()
            },
        }
    }
}

/// Builds the tests one after another, keeping setups and bars that several share.
struct Builder<'a> {
    plan: Plan,
    manner: &'a Manner,
    rng: &'a mut Draw,
    clock_s: f64,
    turning: usize,
    tilting: usize,
}

/// Which of the orbiting ball's setups a test uses.
#[derive(Clone, Copy, PartialEq)]
enum Seat {
    Main,
    Inner,
}

/// Plans a session of a design on a machine.
pub fn build(machine: &Machine, design: &str, manner: &Manner, rng: &mut Draw) -> Plan {
    let turning = machine.axis("C");
    let tilting = (0..AXES)
        .find(|&j| machine.joints[j].rotary && j != turning)
        .unwrap_or(turning);
    let plan = Plan {
        machine: machine.clone(),
        design: design.to_string(),
        tests: vec![],
        pivots: vec![],
        balls: vec![],
        bars: vec![],
        temperature: None,
    };
    let clock_s = rng.between(200.0, 650.0);
    let mut b = Builder {
        plan,
        manner,
        rng,
        clock_s,
        turning,
        tilting,
    };
    match design {
        "full" => {
            b.stationary(true);
            b.synchronous();
            b.planar();
            b.again();
        }
        "bidirectional" => {
            b.stationary(true);
            b.again();
        }
        "synchronous" => b.synchronous(),
        "planar" => b.planar(),
        "thesis4" => b.stationary(false),
        _ => {
            b.stationary(false);
            b.synchronous();
            if b.rng.chance(0.5) {
                b.planar();
            }
        }
    }
    b.plan
}

impl Builder<'_> {
    /// Sweeps of one joint with the slides standing; `extended` adds longer bars, feeds and heights.
    fn stationary(&mut self, extended: bool) {
        let (a, c) = (self.tilting, self.turning);
        let arc = if self.plan.machine.on_tool_side(a) {
            (-30.0, 60.0)
        } else {
            (-20.0, 70.0)
        };
        let letter = |b: &Self, j: usize| b.plan.machine.joints[j].name.to_lowercase();
        let (an, cn) = (letter(self, a), letter(self, c));
        let ra = self.orbit(a, Seat::Main).2;
        let rc = self.orbit(c, Seat::Main).2;
        let full = (-180.0, 180.0);
        self.turn(&format!("{an}-short"), a, arc, 0.0, 500.0, Seat::Main);
        if extended {
            self.turn(
                &format!("{an}-short-f2000"),
                a,
                arc,
                0.0,
                2000.0,
                Seat::Main,
            );
        }
        let ext = |r: f64, bar: f64| (bar * bar - r * r).max(0.0).sqrt();
        let short_ext = ext(ra, rounded(ra) + 50.0);
        self.turn(
            &format!("{an}-ext-neg"),
            a,
            arc,
            -short_ext,
            500.0,
            Seat::Main,
        );
        if extended {
            self.turn(
                &format!("{an}-ext-pos"),
                a,
                arc,
                short_ext,
                500.0,
                Seat::Main,
            );
            let long = ext(ra, (rounded(ra) + 100.0).max(300.0));
            self.turn(&format!("{an}-long-neg"), a, arc, -long, 500.0, Seat::Main);
            self.turn(&format!("{an}-long-pos"), a, arc, long, 500.0, Seat::Main);
        }
        self.turn(&format!("{cn}-short"), c, full, 0.0, 500.0, Seat::Main);
        if extended {
            self.turn(
                &format!("{cn}-short-f2000"),
                c,
                full,
                0.0,
                2000.0,
                Seat::Main,
            );
        }
        let reach = rounded(rc);
        self.turn(
            &format!("{cn}-ext"),
            c,
            full,
            ext(rc, reach + 50.0),
            500.0,
            Seat::Main,
        );
        if extended {
            self.turn(
                &format!("{cn}-high1"),
                c,
                full,
                ext(rc, reach + 100.0),
                500.0,
                Seat::Main,
            );
            self.turn(
                &format!("{cn}-high2"),
                c,
                full,
                ext(rc, reach + 200.0),
                500.0,
                Seat::Main,
            );
            let ri = self.orbit(c, Seat::Inner).2;
            self.turn(
                &format!("{cn}-inner"),
                c,
                full,
                ext(ri, reach),
                500.0,
                Seat::Inner,
            );
        }
    }

    fn again(&mut self) {
        let a = self.tilting;
        let arc = if self.plan.machine.on_tool_side(a) {
            (-30.0, 60.0)
        } else {
            (-20.0, 70.0)
        };
        let name = self.plan.machine.joints[a].name.to_lowercase();
        self.turn(
            &format!("{name}-short-again"),
            a,
            arc,
            0.0,
            500.0,
            Seat::Main,
        );
    }

    fn synchronous(&mut self) {
        let (a, c) = (self.tilting, self.turning);
        let arc = if self.plan.machine.on_tool_side(a) {
            (-30.0, 60.0)
        } else {
            (5.0, 80.0)
        };
        for (axis, arc, feed) in [(c, (-180.0, 180.0), 1000.0), (a, arc, 500.0)] {
            let name = self.plan.machine.joints[axis].name.to_lowercase();
            for follow in ["radial", "tangential", "axial"] {
                self.follow(
                    &format!("sync-{name}-{follow}"),
                    axis,
                    arc,
                    follow,
                    feed,
                    0.0,
                );
            }
        }
        let tilt = if self.plan.machine.on_tool_side(a) && self.plan.machine.on_tool_side(c) {
            20.0
        } else {
            30.0
        };
        let name = self.plan.machine.joints[c].name.to_lowercase();
        self.follow(
            &format!("sync-{name}-tilted"),
            c,
            (-180.0, 180.0),
            "axial",
            1000.0,
            tilt,
        );
    }

    fn planar(&mut self) {
        const X: V3 = [1.0, 0.0, 0.0];
        const Y: V3 = [0.0, 1.0, 0.0];
        const Z: V3 = [0.0, 0.0, 1.0];
        for feed in [500.0, 2000.0] {
            let planes = [
                ("xy", X, Y, (-180.0, 180.0)),
                ("yz", Y, Z, (-20.0, 200.0)),
                ("zx", Z, X, (-110.0, 110.0)),
            ];
            for (name, u, w, arc) in planes {
                let (pivot, ball) = (self.pivot(Seat::Main, None), self.ball(Seat::Main, None));
                let path = Path::Circle {
                    standing: [0.0; AXES],
                    u,
                    w,
                    radius_mm: 100.0,
                };
                let rate = feed / 60.0 / 100.0;
                self.both_ways(
                    &format!("{name}-f{feed:.0}"),
                    path,
                    arc,
                    (pivot, ball),
                    100.0,
                    feed,
                    rate,
                );
            }
        }
    }

    /// One joint turns; the other ball stands `along_mm` off the centre of the orbit.
    fn turn(
        &mut self,
        name: &str,
        axis: usize,
        arc: (f64, f64),
        along_mm: f64,
        feed: f64,
        seat: Seat,
    ) {
        let (pivot, ball, radius, outward) = self.orbit(axis, seat);
        let k = self.plan.machine.joints[axis].direction;
        let to_centre = if self.plan.machine.on_tool_side(axis) {
            1.0
        } else {
            -1.0
        };
        // "neg" and "pos" name the side by the slide's own reading, which a moving table counts the other way
        let carried = |j: usize| dot(self.plan.machine.joints[j].direction, k).abs() > 0.9;
        let table_slide = self
            .plan
            .machine
            .work
            .iter()
            .any(|&j| !self.plan.machine.joints[j].rotary && carried(j));
        let along_mm = if table_slide && axis == self.tilting {
            -along_mm
        } else {
            along_mm
        };
        let relative = add(scale(outward, to_centre * radius), scale(k, along_mm));
        let mut standing = [0.0; AXES];
        let (p, s) = (self.plan.pivots[pivot].ball, self.plan.balls[ball].ball);
        self.plan.machine.slides_for(p, s, &mut standing, relative);
        for q in &mut standing {
            *q = (*q * 1e6).round() / 1e6;
        }
        let bar = (radius * radius + along_mm * along_mm).sqrt();
        let path = Path::Turn { axis, standing };
        self.both_ways(
            name,
            path,
            arc,
            (pivot, ball),
            bar,
            feed,
            feed / 60.0 / radius,
        );
    }

    /// One joint turns and the slides follow, the bar fixed in the turning frame.
    fn follow(
        &mut self,
        name: &str,
        axis: usize,
        arc: (f64, f64),
        follow: &str,
        feed: f64,
        tilt_deg: f64,
    ) {
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
        let path = Path::Follow {
            axis,
            standing,
            relative: scale(along, bar),
        };
        self.both_ways(
            name,
            path,
            arc,
            (pivot, ball),
            bar,
            feed,
            feed / 60.0 / radius,
        );
    }

    /// Pivot, ball, orbit radius and outward direction (all axes at zero) of the ball that a joint carries around.
    fn orbit(&mut self, axis: usize, seat: Seat) -> (usize, usize, f64, V3) {
        self.orbit_from(axis, seat, Some(axis))
    }

    /// The same from the pivot seat for the tests of `beside`, or from the usual one.
    fn orbit_from(
        &mut self,
        axis: usize,
        seat: Seat,
        beside: Option<usize>,
    ) -> (usize, usize, f64, V3) {
        let tool_side = self.plan.machine.on_tool_side(axis);
        let pivot = self.pivot(seat, beside);
        let ball = self.ball(seat, Some(axis));
        let moving = if tool_side {
            self.plan.balls[ball].ball.at
        } else {
            self.plan.pivots[pivot].ball.at
        };
        let joint = &self.plan.machine.joints[axis];
        let arm = sub(moving, joint.origin);
        let outward = sub(arm, scale(joint.direction, dot(arm, joint.direction)));
        (pivot, ball, norm(outward), unit(outward))
    }

    /// The pivot seat on the last workpiece-side part.
    fn pivot(&mut self, seat: Seat, axis: Option<usize>) -> usize {
        let link = self
            .plan
            .machine
            .work
            .last()
            .map_or(Link::Bed, |&j| Link::Axis(j));
        let turns = self
            .plan
            .machine
            .work
            .iter()
            .any(|&j| self.plan.machine.joints[j].rotary);
        let tool_axis = axis.is_some_and(|j| self.plan.machine.on_tool_side(j));
        // on the table beside both joints' lines
        let aside = if self.plan.machine.joints[self.tilting].direction[1] > 0.9 {
            [1.0, 0.0, 0.0]
        } else {
            [0.0, 1.0, 0.0]
        };
        let at = match (turns, tool_axis, seat) {
            (false, ..) => [0.0; 3],
            (true, true, _) => [0.0, 0.0, 150.0],
            (true, false, Seat::Main) => scale(aside, self.manner.table_radius_mm),
            (true, false, Seat::Inner) => scale(aside, -60.0),
        };
        placed(&mut self.plan.pivots, Ball { link, at }, 0.020)
    }

    /// The ball in the spindle: on its centre where that orbits the joint, else on an arm.
    fn ball(&mut self, seat: Seat, axis: Option<usize>) -> usize {
        let link = self
            .plan
            .machine
            .tool
            .last()
            .map_or(Link::Bed, |&j| Link::Axis(j));
        let on_spindle =
            axis.is_some_and(|j| self.plan.machine.on_tool_side(j) && j == self.turning);
        let (at, spread) = match (on_spindle, seat) {
            (false, _) => ([0.0; 3], 0.003),
            (true, Seat::Main) => ([self.manner.table_radius_mm, 0.0, 0.0], 0.020),
            (true, Seat::Inner) => ([60.0, 0.0, 0.0], 0.020),
        };
        placed(&mut self.plan.balls, Ball { link, at }, spread)
    }

    /// Adds the test counter-clockwise and clockwise from one setup; `rate` is the joint's in rad/s.
    #[allow(clippy::too_many_arguments)]
    fn both_ways(
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
        let remounted = self
            .plan
            .tests
            .last()
            .is_none_or(|t| (t.pivot, t.ball, t.bar) != (seats.0, seats.1, bar));
        let pause = if remounted {
            self.rng.between(110.0, 200.0)
        } else {
            self.rng.between(15.0, 60.0)
        };
        self.clock_s += pause;
        let ways = if self.manner.cw_first {
            ["cw", "ccw"]
        } else {
            ["ccw", "cw"]
        };
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
        let at = |f: f64| {
            self.plan
                .axes_on(test, test.from_deg + f * (test.to_deg - test.from_deg))
        };
        let first = at(0.0);
        (0..AXES)
            .filter(|&j| (1..9).any(|k| (at(f64::from(k) / 9.7)[j] - first[j]).abs() > 1e-9))
            .collect()
    }

    fn bar(&mut self, length_mm: f64) -> usize {
        let nominal_mm = (length_mm * 100.0).round() / 100.0;
        if let Some(i) = self
            .plan
            .bars
            .iter()
            .position(|b| (b.nominal_mm - nominal_mm).abs() < 0.02)
        {
            return i;
        }
        let calibrated_mm = ((nominal_mm + 0.012 * self.rng.normal()) * 1e4).round() / 1e4;
        let reading_error_mm = 0.0005 * self.rng.normal();
        self.plan.bars.push(Bar {
            nominal_mm,
            calibrated_mm,
            reading_error_mm,
        });
        self.plan.bars.len() - 1
    }
}

fn rounded(length_mm: f64) -> f64 {
    (length_mm / 50.0).round() * 50.0
}

/// The seat at a place, made when it is new.
fn placed(seats: &mut Vec<Placed>, ball: Ball, spread_mm: f64) -> usize {
    if let Some(i) = seats.iter().position(|s| s.ball == ball) {
        return i;
    }
    seats.push(Placed {
        ball,
        offset_mm: [0.0; 3],
        spread_mm,
    });
    seats.len() - 1
}

/// Sampling interval of a usual recorder rate that gives about `rows` rows.
fn step_for(duration_s: f64, rows: f64) -> f64 {
    const RATES_HZ: &[f64] = &[
        5.0, 8.0, 10.0, 12.0, 15.0, 20.0, 25.0, 30.0, 40.0, 50.0, 80.0, 100.0, 125.0,
    ];
    let best = RATES_HZ
        .iter()
        .min_by(|a, b| {
            ((duration_s * **a / rows).ln().abs()).total_cmp(&(duration_s * **b / rows).ln().abs())
        })
        .unwrap_or(&25.0);
    1.0 / best
}
