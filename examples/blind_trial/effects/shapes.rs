//! Slides that are not straight, not square or not to scale.

use super::super::draw::Draw;
use super::super::kinematics::V3;
use super::super::nuisance::ARCSEC;
use super::super::plan::Plan;
use super::{Cause, Law, Rows, along, component, draw_axis};
use serde_json::json;
use std::f64::consts::PI;

/// A worn stretch of a guideway, felt through a carriage of finite length, or a bow of the whole way.
pub struct Wear {
    pub axis: usize,
    pub across: V3,
    pub about: V3,
    pub bow: bool,
    pub centre_mm: f64,
    pub width_mm: f64,
    pub skew: f64,
    /// Share of the slope that the carriage turns by.
    pub slope_share: f64,
    pub sign: f64,
}

impl Wear {
    fn height(&self, x: f64) -> f64 {
        let u = (x - self.centre_mm) / (self.width_mm / 2.0);
        if self.bow {
            return 1.0 - u * u;
        }
        if u.abs() >= 1.0 {
            return 0.0;
        }
        let v = u + self.skew * (1.0 - u * u);
        0.5 * (1.0 + (PI * v.clamp(-1.0, 1.0)).cos())
    }
}

impl Law for Wear {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        // a worn stretch is what it is; a bow is counted from position 0
        let zero = if self.bow { self.height(0.0) } else { 0.0 };
        for (test, list) in plan.tests.iter().zip(rows.iter_mut()) {
            for (row, d) in list.iter_mut().enumerate() {
                let q = plan.axes_at(test, row as f64 * test.step_s)[self.axis];
                let mm = self.sign * size * 1e-3;
                along(d, self.axis, self.across, false, mm * (self.height(q) - zero));
                let slope = (self.height(q + 0.5) - self.height(q - 0.5)) * mm;
                along(d, self.axis, self.about, true, self.slope_share * slope);
            }
        }
    }
}

pub fn wear(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    let axis = draw_axis(rng, plan, false)?;
    let joint = plan.machine.joints[axis].clone();
    let own = "XYZ".find(&joint.name)?;
    let aside = (own + 1 + rng.below(2)) % 3;
    let turns = 3 - own - aside;
    let (low, high) = plan.travel(axis);
    let span = (high - low).max(20.0);
    let bow = rng.chance(0.2);
    let mut across = [0.0; 3];
    across[aside] = 1.0;
    // moving along `own` up a slope towards `aside` turns about their cross product
    let mut about = [0.0; 3];
    about[turns] = if (own + 1) % 3 == aside { 1.0 } else { -1.0 };
    let slope_share = if rng.chance(0.5) { rng.between(0.0, 0.6) } else { 0.0 };
    let law = Wear {
        axis,
        across,
        about,
        bow,
        centre_mm: if bow { 0.5 * (low + high) } else { rng.between(low + 0.15 * span, high - 0.15 * span) },
        width_mm: if bow { span } else { rng.log_between(35.0, 180.0).min(1.2 * span) },
        skew: rng.between(-0.3, 0.3),
        slope_share,
        sign: rng.sign(),
    };
    let mut components = vec![component(aside, &joint.name)];
    if slope_share > 0.0 {
        components.push(component(3 + turns, &joint.name));
    }
    let (from, to) = (law.centre_mm - law.width_mm / 2.0, law.centre_mm + law.width_mm / 2.0);
    Some(Cause {
        effect: "straightness",
        id: "straightness",
        driver: "position",
        place: joint.name.clone(),
        components,
        unit: "um",
        meaning: if bow { "height of the bow" } else { "height of the bump" },
        sizes: (0.3, 15.0),
        range: json!({"axis": joint.name, "from": from, "to": to}),
        params: json!({"form": if bow { "bow" } else { "bump" }, "centre_mm": law.centre_mm,
            "width_mm": law.width_mm, "skew": law.skew, "slope_share": slope_share, "sign": law.sign}),
        law: Box::new(law),
    })
}

/// A slide out of square with another: it drifts sideways in proportion to its position.
pub struct Lean {
    pub axis: usize,
    pub aside: V3,
}

impl Law for Lean {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        for (test, list) in plan.tests.iter().zip(rows.iter_mut()) {
            for (row, d) in list.iter_mut().enumerate() {
                let q = plan.axes_at(test, row as f64 * test.step_s)[self.axis];
                along(d, self.axis, self.aside, false, size * ARCSEC * q);
            }
        }
    }
}

pub fn squareness(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    let sign = rng.sign();
    // turning the direction of Y about z leans it to −x, of Z about y to +x, of Z about x to −y
    let (axis, slot, aside): (&str, &str, V3) =
        *rng.pick(&[("Y", "EC0Y", [-1.0, 0.0, 0.0]), ("Z", "EB0Z", [1.0, 0.0, 0.0]), ("Z", "EA0Z", [0.0, -1.0, 0.0])]);
    let index = plan.machine.axis(axis);
    let (from, to) = plan.travel(index);
    Some(Cause {
        effect: "squareness",
        id: "squareness",
        driver: "position",
        place: axis.into(),
        components: vec![slot.into()],
        unit: "arcsec",
        meaning: "angle",
        sizes: (0.3, 40.0),
        range: json!({"axis": axis, "from": from, "to": to}),
        params: json!({"sign": sign}),
        law: Box::new(Lean { axis: index, aside: aside.map(|x| x * sign) }),
    })
}

/// A slide's scale with a little curvature.
struct Scale {
    axis: usize,
    sign: f64,
    curvature: f64,
}

impl Law for Scale {
    fn disturb(&self, plan: &Plan, size: f64, rows: &mut Rows) {
        for (test, list) in plan.tests.iter().zip(rows.iter_mut()) {
            for (row, d) in list.iter_mut().enumerate() {
                let q = plan.axes_at(test, row as f64 * test.step_s)[self.axis];
                d.own[self.axis] += self.sign * size * 1e-6 * q * (1.0 + self.curvature * q / 300.0);
            }
        }
    }
}

pub fn scale(rng: &mut Draw, plan: &mut Plan) -> Option<Cause> {
    let axis = draw_axis(rng, plan, false)?;
    let name = plan.machine.joints[axis].name.clone();
    let (from, to) = plan.travel(axis);
    let law = Scale { axis, sign: rng.sign(), curvature: rng.between(-0.1, 0.1) };
    Some(Cause {
        effect: "linear-scale",
        id: "linear-scale",
        driver: "position",
        place: name.clone(),
        components: vec![component("XYZ".find(&name)?, &name)],
        unit: "um/m",
        meaning: "scale error",
        sizes: (1.0, 120.0),
        range: json!({"axis": name, "from": from, "to": to}),
        params: json!({"sign": law.sign, "curvature": law.curvature}),
        law: Box::new(law),
    })
}
