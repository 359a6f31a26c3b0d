//! Test designs: which recordings a session consists of, on any machine drawn; no errors and no noise.

use super::draw::Draw;
use super::kinematics::{AXES, Machine, V3};
use super::mounting::{Builder, Seat};
use super::plan::{Path, Plan};

/// Designs and how often each is drawn.
pub const DESIGNS: &[(&str, f64)] =
    &[("full", 3.0), ("bidirectional", 2.0), ("synchronous", 2.0), ("planar", 2.0), ("thesis4", 1.0), ("mixed", 1.0)];

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
        Manner { cw_first: false, density: 1.0, table_radius_mm: 100.0 }
    }

    pub fn draw(rng: &mut Draw) -> Self {
        let usual = Manner::usual();
        Manner {
            cw_first: rng.chance(0.2),
            density: if rng.chance(0.6) { usual.density } else { rng.between(0.6, 1.1) },
            table_radius_mm: if rng.chance(0.6) { usual.table_radius_mm } else { rng.between(85.0, 140.0).round() },
        }
    }
}

/// Plans a session of a design on a machine.
pub fn build(machine: &Machine, design: &str, manner: &Manner, rng: &mut Draw) -> Plan {
    let turning = machine.axis("C");
    let tilting = (0..AXES).find(|&j| machine.joints[j].rotary && j != turning).unwrap_or(turning);
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
    let mut b = Builder { plan, manner, rng, clock_s, turning, tilting };
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
        let arc = if self.plan.machine.on_tool_side(a) { (-30.0, 60.0) } else { (-20.0, 70.0) };
        let letter = |b: &Self, j: usize| b.plan.machine.joints[j].name.to_lowercase();
        let (an, cn) = (letter(self, a), letter(self, c));
        let ra = self.orbit(a, Seat::Main).2;
        let rc = self.orbit(c, Seat::Main).2;
        let full = (-180.0, 180.0);
        self.turn(&format!("{an}-short"), a, arc, 0.0, 500.0, Seat::Main);
        if extended {
            self.turn(&format!("{an}-short-f2000"), a, arc, 0.0, 2000.0, Seat::Main);
        }
        let ext = |r: f64, bar: f64| (bar * bar - r * r).max(0.0).sqrt();
        let short_ext = ext(ra, rounded(ra) + 50.0);
        self.turn(&format!("{an}-ext-neg"), a, arc, -short_ext, 500.0, Seat::Main);
        if extended {
            self.turn(&format!("{an}-ext-pos"), a, arc, short_ext, 500.0, Seat::Main);
            let long = ext(ra, (rounded(ra) + 100.0).max(300.0));
            self.turn(&format!("{an}-long-neg"), a, arc, -long, 500.0, Seat::Main);
            self.turn(&format!("{an}-long-pos"), a, arc, long, 500.0, Seat::Main);
        }
        self.turn(&format!("{cn}-short"), c, full, 0.0, 500.0, Seat::Main);
        if extended {
            self.turn(&format!("{cn}-short-f2000"), c, full, 0.0, 2000.0, Seat::Main);
        }
        let reach = rounded(rc);
        self.turn(&format!("{cn}-ext"), c, full, ext(rc, reach + 50.0), 500.0, Seat::Main);
        if extended {
            self.turn(&format!("{cn}-high1"), c, full, ext(rc, reach + 100.0), 500.0, Seat::Main);
            self.turn(&format!("{cn}-high2"), c, full, ext(rc, reach + 200.0), 500.0, Seat::Main);
            let ri = self.orbit(c, Seat::Inner).2;
            self.turn(&format!("{cn}-inner"), c, full, ext(ri, reach), 500.0, Seat::Inner);
        }
    }

    fn again(&mut self) {
        let a = self.tilting;
        let arc = if self.plan.machine.on_tool_side(a) { (-30.0, 60.0) } else { (-20.0, 70.0) };
        let name = self.plan.machine.joints[a].name.to_lowercase();
        self.turn(&format!("{name}-short-again"), a, arc, 0.0, 500.0, Seat::Main);
    }

    fn synchronous(&mut self) {
        let (a, c) = (self.tilting, self.turning);
        let arc = if self.plan.machine.on_tool_side(a) { (-30.0, 60.0) } else { (5.0, 80.0) };
        for (axis, arc, feed) in [(c, (-180.0, 180.0), 1000.0), (a, arc, 500.0)] {
            let name = self.plan.machine.joints[axis].name.to_lowercase();
            for follow in ["radial", "tangential", "axial"] {
                self.follow(&format!("sync-{name}-{follow}"), axis, arc, follow, feed, 0.0);
            }
        }
        let tilt = if self.plan.machine.on_tool_side(a) && self.plan.machine.on_tool_side(c) { 20.0 } else { 30.0 };
        let name = self.plan.machine.joints[c].name.to_lowercase();
        self.follow(&format!("sync-{name}-tilted"), c, (-180.0, 180.0), "axial", 1000.0, tilt);
    }

    fn planar(&mut self) {
        const X: V3 = [1.0, 0.0, 0.0];
        const Y: V3 = [0.0, 1.0, 0.0];
        const Z: V3 = [0.0, 0.0, 1.0];
        for feed in [500.0, 2000.0] {
            let planes = [("xy", X, Y, (-180.0, 180.0)), ("yz", Y, Z, (-20.0, 200.0)), ("zx", Z, X, (-110.0, 110.0))];
            for (name, u, w, arc) in planes {
                let (pivot, ball) = (self.pivot(Seat::Main, None), self.ball(Seat::Main, None));
                let path = Path::Circle { standing: [0.0; AXES], u, w, radius_mm: 100.0 };
                let rate = feed / 60.0 / 100.0;
                self.both_ways(&format!("{name}-f{feed:.0}"), path, arc, (pivot, ball), 100.0, feed, rate);
            }
        }
    }
}

fn rounded(length_mm: f64) -> f64 {
    (length_mm / 50.0).round() * 50.0
}
