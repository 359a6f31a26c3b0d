//! The path that a block asks for: a line or an arc in the coordinates of the program, over a share 0 … 1 of its time.

use std::f64::consts::TAU;

/// Coordinates by letter (X Y Z A B C U V W), mm and deg.
pub type Place = [f64; 9];

/// One move.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    pub from: Place,
    pub to: Place,
    pub arc: Option<Arc>,
}

/// A circle or helix; the other coordinates run along evenly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arc {
    /// First and second coordinate of the plane.
    pub plane: [usize; 2],
    pub centre: [f64; 2],
    pub start_radius: f64,
    pub end_radius: f64,
    pub start_angle: f64,
    /// Counter-clockwise positive, rad.
    pub sweep: f64,
}

/// How far apart the radii of both ends may be: rounding of programs, mm; a twentieth of a percent of large arcs.
const RADII_APART: (f64, f64) = (0.02, 5e-4);
/// Ends nearer than this are one point, mm: a full circle.
const SAME_POINT: f64 = 1e-7;
/// Angles below this are none, rad: LinuxCNC drives a full circle then.
const SAME_ANGLE: f64 = 1e-6;

/// How an arc was said.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ArcWords {
    /// Centre in the plane, mm.
    Centre([f64; 2]),
    /// Radius, mm; a negative one takes the longer way.
    Radius(f64),
}

/// Which way an arc turns, seen from the positive end of the third axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ArcSense {
    Clockwise,
    CounterClockwise,
}

impl ArcSense {
    /// +1 counter-clockwise.
    fn sign(self) -> f64 {
        match self {
            ArcSense::Clockwise => -1.0,
            ArcSense::CounterClockwise => 1.0,
        }
    }
}

impl Arc {
    /// The arc between two places.
    pub fn new(
        from: &Place,
        to: &Place,
        plane: [usize; 2],
        words: ArcWords,
        sense: ArcSense,
        turns: f64,
    ) -> Result<Arc, String> {
        let of = |place: &Place| [place[plane[0]], place[plane[1]]];
        let (start, end) = (of(from), of(to));
        let centre = match words {
            ArcWords::Centre(centre) => centre,
            ArcWords::Radius(radius) => centre_of(start, end, radius, sense)?,
        };
        let polar = |point: [f64; 2]| {
            let (u, v) = (point[0] - centre[0], point[1] - centre[1]);
            (u.hypot(v), v.atan2(u))
        };
        let ((start_radius, start_angle), (end_radius, end_angle)) = (polar(start), polar(end));
        let apart = (start_radius - end_radius).abs();
        if apart > RADII_APART.0.max(RADII_APART.1 * start_radius) {
            return Err(format!(
                "has an arc whose start is {start_radius:.4} mm and whose end is {end_radius:.4} mm from its centre; check I, J, K"
            ));
        }
        if start_radius < SAME_POINT {
            return Err("has an arc without a radius".into());
        }
        let sign = sense.sign();
        let angle = (sign * (end_angle - start_angle)).rem_euclid(TAU);
        // an end in the direction of the start is a full turn: the rounding of its words may lie along the radius
        let is_full = (start[0] - end[0]).hypot(start[1] - end[1]) < SAME_POINT;
        let once = match is_full {
            true => TAU,
            false if angle < SAME_ANGLE => TAU + angle,
            false => angle,
        };
        let sweep = sign * (once + TAU * (turns - 1.0));
        Ok(Arc { plane, centre, start_radius, end_radius, start_angle, sweep })
    }
}

/// Centre of an arc that is said by its radius.
fn centre_of(start: [f64; 2], end: [f64; 2], radius: f64, sense: ArcSense) -> Result<[f64; 2], String> {
    let (u, v) = (end[0] - start[0], end[1] - start[1]);
    let chord = u.hypot(v);
    if chord < SAME_POINT {
        return Err("has a full circle said by R, whose centre is not known; say I, J, K".into());
    }
    let square = radius * radius - 0.25 * chord * chord;
    // rounding of a half circle
    if square < -RADII_APART.0 * radius.abs() {
        return Err(format!(
            "has an arc of radius {radius} mm over a chord of {chord:.4} mm; that radius is too small"
        ));
    }
    // left of the way from start to end for a short counter-clockwise arc
    let side = if radius > 0.0 { sense.sign() } else { -sense.sign() };
    let along = side * square.max(0.0).sqrt() / chord;
    Ok([0.5 * (start[0] + end[0]) - v * along, 0.5 * (start[1] + end[1]) + u * along])
}

impl Path {
    /// Coordinates at a share of the way.
    pub fn at(&self, share: f64) -> Place {
        let mut place: Place = std::array::from_fn(|k| self.from[k] + share * (self.to[k] - self.from[k]));
        if let Some(arc) = &self.arc {
            let angle = arc.start_angle + share * arc.sweep;
            let radius = arc.start_radius + share * (arc.end_radius - arc.start_radius);
            place[arc.plane[0]] = arc.centre[0] + radius * angle.cos();
            place[arc.plane[1]] = arc.centre[1] + radius * angle.sin();
        }
        // the end is as it was said
        if share == 1.0 { self.to } else { place }
    }

    /// Length along X, Y, Z, mm.
    pub fn length_mm(&self) -> f64 {
        let mut step: [f64; 3] = std::array::from_fn(|k| self.to[k] - self.from[k]);
        let mut arc_length = 0.0;
        if let Some(arc) = &self.arc {
            arc.plane.iter().for_each(|&k| step[k] = 0.0);
            arc_length = arc.sweep * 0.5 * (arc.start_radius + arc.end_radius);
        }
        step.iter().map(|step| step * step).sum::<f64>().sqrt().hypot(arc_length)
    }

    /// Length along the rotary coordinates, deg.
    pub fn turn_deg(&self) -> f64 {
        (3..6).map(|k| (self.to[k] - self.from[k]).powi(2)).sum::<f64>().sqrt()
    }

    /// Length along all coordinates, a degree counting as a millimetre.
    pub fn whole(&self) -> f64 {
        self.length_mm().hypot(self.turn_deg())
    }
}
