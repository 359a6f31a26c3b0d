//! The ball-bar kit: lengths it can make, balls, cups with the cone of the bar, stands. Places are chosen in `plan`.

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
        lengths.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
        lengths
    }
}
