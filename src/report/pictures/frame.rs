//! Where residuals lie in a picture over the position: round numbers on both axes. It draws nothing.

/// Width of the picture and room at its right and below, px.
pub(crate) const WIDTH: f64 = 600.0;
pub(crate) const RIGHT: f64 = 16.0;
pub(crate) const BOTTOM: f64 = 44.0;

/// Height of a picture, and its room at the left and above, px.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Edges {
    pub height: f64,
    pub left: f64,
    pub top: f64,
}

/// Where positions and residuals lie in the picture.
#[derive(Debug)]
pub(crate) struct Frame {
    edges: Edges,
    /// First and last position of the picture.
    low: f64,
    high: f64,
    /// Residual at the upper edge, a whole number of steps, and that between two lines, µm.
    pub reach_um: f64,
    step_um: f64,
}

/// Smallest residual that fills a picture, µm.
const SMALLEST_UM: f64 = 1e-3;

impl Frame {
    /// Holds all positions and residuals up to the largest, µm.
    pub fn of(edges: Edges, abscissa: &[f64], largest_um: f64) -> Frame {
        let step_um = round_step(largest_um.max(SMALLEST_UM) / 2.0);
        let reach_um = step_um * (largest_um / step_um).ceil().max(1.0);
        let (low, high) = abscissa.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| (l.min(v), h.max(v)));
        let (low, high) = if high > low { (low, high) } else { (low - 1.0, low + 1.0) };
        Frame { edges, low, high, reach_um, step_um }
    }

    /// Where a position lies, px.
    pub fn x(&self, position: f64) -> f64 {
        let left = self.edges.left;
        left + (position - self.low) / (self.high - self.low) * (WIDTH - left - RIGHT)
    }

    /// Where a residual lies, px.
    pub fn y(&self, um: f64) -> f64 {
        let Edges { height, top, .. } = self.edges;
        top + (1.0 - um / self.reach_um) * (height - top - BOTTOM) / 2.0
    }

    /// Values of the lines across, µm; zero is one of them.
    pub fn levels(&self) -> Vec<f64> {
        let count = (self.reach_um / self.step_um).round() as i64;
        (-count..=count).map(|k| k as f64 * self.step_um).collect()
    }

    /// Positions with a number.
    pub fn ticks(&self) -> Vec<f64> {
        let across = position_step(self.high - self.low);
        let (first, last) = ((self.low / across - 1e-9).ceil() as i64, (self.high / across + 1e-9).floor() as i64);
        (first..=last).map(|k| k as f64 * across).collect()
    }
}

/// Smallest step of the series 1, 2, 5 × 10ⁿ not below `wanted`.
pub(crate) fn round_step(wanted: f64) -> f64 {
    let decade = 10f64.powf(wanted.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|k| k * decade).find(|step| *step >= wanted * (1.0 - 1e-9)).unwrap_or(wanted)
}

/// Step of the position axis: round numbers, for degrees those of a protractor.
fn position_step(span: f64) -> f64 {
    let wanted = span / 8.0;
    let protractor = [10.0, 15.0, 30.0, 45.0, 60.0, 90.0, 180.0, 360.0];
    protractor.into_iter().find(|step| *step >= wanted && wanted > 5.0).unwrap_or_else(|| round_step(wanted))
}

/// A number without needless zeros.
pub(crate) fn plain(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.replace('-', "−") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round_and_cover() {
        assert_eq!(round_step(0.3), 0.5);
        assert_eq!(position_step(360.0), 45.0);
        assert_eq!(position_step(1000.0), 180.0);
    }
}
