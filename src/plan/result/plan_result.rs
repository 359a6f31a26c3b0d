//! A finished plan: tests, forecasts, trade-off curve, advice. How it comes about is in `finish`.

use super::mounting::Mounting;
use super::placing::Placing;
use crate::plan::context::choice::OnePivot;
use crate::plan::reach::approach::Approach;
use crate::plan::reach::little_moves::LittleMove;
use crate::plan::reach::sweep_reach::ClearSweep;
use crate::plan::reasons::forecast::ErrorForecast;
use crate::session::{Follow, Path, Test};

/// One test of a plan, run in both directions.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedTest {
    /// Place in the order of the plan, from 1.
    pub number: usize,
    /// The session test from lower to upper end.
    pub test: Test,
    /// The axis that turns; on a circle the linear axis that carries the cosine.
    pub axis: usize,
    /// Distance of the carried ball from the axis line, mm.
    pub rho_mm: f64,
    /// Distance of the still ball along the axis line from the foot of the other, mm.
    pub h_mm: f64,
    /// Radius on which one ball goes round as seen from the other, mm; of the carried ball about the axis where the bar keeps
    /// its direction.
    pub way_radius_mm: f64,
    pub sweep: ClearSweep,
    /// Both directions, mounting apart, min.
    pub minutes: f64,
    /// Name of the mount.
    pub mount: String,
    /// Ball above the mount, mm.
    pub height_mm: f64,
    /// Positions of all axes along the rising direction, run-in and run-out included, mm and rad.
    pub run: Vec<Vec<f64>>,
    /// The same in the middle of the arc.
    pub middle: Vec<f64>,
    /// From park to the start of the run-in, without the bar.
    pub approach: Approach,
    /// Parts of the kit that are mounted.
    pub mounting: Mounting,
    /// How the pivot's place is found.
    pub placing: Placing,
}

impl PlannedTest {
    /// True when more than one axis moves.
    pub fn is_coupled(&self) -> bool {
        !matches!(self.test.path, Some(Path::Sweep { follow: Follow::None, .. }))
    }

    /// The session tests: counter-clockwise (rising), then clockwise.
    pub fn both_ways(&self) -> [Test; 2] {
        let (from_deg, to_deg) = (self.sweep.from_deg, self.sweep.to_deg);
        [("ccw", from_deg, to_deg), ("cw", to_deg, from_deg)].map(|(way, from, to)| Test {
            name: format!("{}-{way}", self.test.name),
            path: self.test.path.as_ref().map(|path| path.between(from, to)),
            ..self.test.clone()
        })
    }
}

/// A point of the trade-off curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TradeOff {
    pub tests: usize,
    pub minutes: f64,
    pub pivot_setups: usize,
    /// Worst standard deviations of positions, mm, and orientations, rad.
    pub position_mm: f64,
    pub orientation_rad: f64,
}

/// A test plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    pub tests: Vec<PlannedTest>,
    pub errors: Vec<ErrorForecast>,
    pub minutes: f64,
    pub pivot_setups: usize,
    pub curve: Vec<TradeOff>,
    /// Candidates that were reachable.
    pub considered: usize,
    /// Goals reached, absolute or relative to the spindle ball.
    pub goal_reached: bool,
    /// What tests from one pivot setup alone reach; `None` when a method or a limit on pivots was asked for, or without any test.
    pub one_pivot: Option<OnePivot>,
    /// Avoided regions that lie between park positions; what would bring errors below the goal that the linear axes keep above
    /// it, in words with the figures.
    pub advice: Vec<String>,
    /// Little moves from the park position of the first test that show the sense of the axes that the plan moves.
    pub little_moves: Vec<LittleMove>,
}
