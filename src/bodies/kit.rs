//! The ball-bar kit: lengths it can make, balls, cups with the cone of the bar, stands. Places are chosen in `plan`.

use std::f64::consts::FRAC_PI_2;

/// Lengths that differ by less are one, mm.
const SAME_LENGTH_MM: f64 = 1e-9;

/// The bar between its balls.
#[derive(Debug, Clone, PartialEq)]
pub struct Bar {
    /// Length without extension, mm.
    pub length_mm: f64,
    /// Lengths of the extensions, each there once, mm.
    pub extensions_mm: Vec<f64>,
    /// Travel of the sensor about the middle, ± mm.
    pub half_stroke_mm: f64,
    pub radius_mm: f64,
    /// The slim ends next to the balls.
    pub neck_radius_mm: f64,
    /// From the ball's centre to where the bar takes its full radius, mm.
    pub neck_length_mm: f64,
    pub ball_radius_mm: f64,
}

/// A magnetic cup on its stem.
#[derive(Debug, Clone, PartialEq)]
pub struct Cup {
    pub radius_mm: f64,
    /// Rim below the ball's centre, mm.
    pub rim_below_ball_mm: f64,
    pub height_mm: f64,
    /// Largest angle between the cup's axis and the bar, rad.
    pub cone_rad: f64,
    pub stem_radius_mm: f64,
}

impl Cup {
    /// Angle between the cup's axis and the bar at which the bar touches the rim, rad.
    ///
    /// The rim is seen from the ball's centre at π/2 + atan(rim below / radius) and distance d; a bar of radius r
    /// touches it asin(r / d) earlier.
    pub fn rim_angle_rad(&self, bar: &Bar) -> f64 {
        let rim_mm = self.radius_mm.hypot(self.rim_below_ball_mm);
        let bar_mm = if rim_mm < bar.neck_length_mm { bar.neck_radius_mm } else { bar.radius_mm };
        FRAC_PI_2 + self.rim_below_ball_mm.atan2(self.radius_mm) - (bar_mm / rim_mm).min(1.0).asin()
    }
}

/// The stand of the pivot cup on a mounting surface.
#[derive(Debug, Clone, PartialEq)]
pub struct PivotStand {
    pub base_radius_mm: f64,
    pub base_height_mm: f64,
    /// Ball centre above the surface, lowest and highest, mm.
    pub height_mm: [f64; 2],
}

/// Flat fixture in the spindle that carries the ball aside of the tool axis; its cup looks down the tool or outward.
#[derive(Debug, Clone, PartialEq)]
pub struct Fixture {
    /// Distances of the ball from the tool axis, mm.
    pub arms_mm: Vec<f64>,
    pub arm_radius_mm: f64,
}

/// A ball-bar kit.
#[derive(Debug, Clone, PartialEq)]
pub struct Kit {
    pub name: String,
    pub bar: Bar,
    pub pivot_cup: Cup,
    pub spindle_cup: Cup,
    pub pivot_stand: PivotStand,
    /// How much farther than the machine's gauge length the spindle ball's stem reaches, mm.
    pub spindle_reach_mm: f64,
    pub fixture: Option<Fixture>,
    /// Lengths that a calibrator certifies, mm; other lengths are calibrated by their parts.
    pub calibrator_mm: Vec<f64>,
}

impl Kit {
    /// Lengths that bar and extensions make, rising, mm.
    pub fn lengths_mm(&self) -> Vec<f64> {
        let mut lengths = vec![self.bar.length_mm];
        for extension in &self.bar.extensions_mm {
            let longer: Vec<f64> = lengths.iter().map(|length| length + extension).collect();
            lengths.extend(longer);
        }
        lengths.sort_by(f64::total_cmp);
        lengths.dedup_by(|a, b| (*a - *b).abs() < SAME_LENGTH_MM);
        lengths
    }

    /// The bar and the fewest extensions that make a length, longest extension last, mm.
    pub fn parts_mm(&self, length_mm: f64) -> Option<Vec<f64>> {
        let mut made: Vec<Vec<f64>> = vec![vec![self.bar.length_mm]];
        let mut extensions = self.bar.extensions_mm.clone();
        extensions.sort_by(f64::total_cmp);
        for extension in extensions {
            let longer: Vec<Vec<f64>> = made.iter().map(|parts| [parts.as_slice(), &[extension]].concat()).collect();
            made.extend(longer);
        }
        made.retain(|parts| (parts.iter().sum::<f64>() - length_mm).abs() < SAME_LENGTH_MM);
        made.into_iter().min_by_key(Vec::len)
    }

    /// The longest of the lengths that some of these parts make and a calibrator certifies, the bar (first) always in, mm.
    pub fn calibrated_mm(&self, parts_mm: &[f64]) -> Option<f64> {
        let (bar, extensions) = parts_mm.split_first()?;
        let mut made = vec![*bar];
        for extension in extensions {
            let longer: Vec<f64> = made.iter().map(|length| length + extension).collect();
            made.extend(longer);
        }
        let certified = |length: &f64| self.calibrator_mm.iter().any(|other| (other - length).abs() < SAME_LENGTH_MM);
        made.into_iter().filter(certified).max_by(f64::total_cmp)
    }
}
