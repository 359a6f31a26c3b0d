//! What stays of the errors over the volume when a control takes its parameters. It chooses no parameter.

use nalgebra::Vector3;

use super::held::{held_where, left_over, what_stays};
use super::numbers::{Number, What};
use crate::effects::{Signature, is_a};
use crate::identify::Fit;
use crate::inverse::Tool;
use crate::machine::{Effect, Machine};
use crate::session::Session;
use crate::volume::{Figures, poses, spread};

/// Poses over which it is told what stays.
const POSES: usize = 3000;

/// Whether the control takes a number.
pub type Enters<'e> = dyn Fn(&Number) -> bool + 'e;

/// What stays over the travel, and where it was looked at.
pub struct Remaining {
    /// Errors as the machine is, those with what the control takes, and how far machines drawn from the fit stand from it.
    pub figures: [Figures; 3],
    /// The machine as the control has it with its parameters.
    kept: Machine,
    /// The tool as it is, and as the control has it.
    tools: (Tool, Tool),
    /// mm or rad by axis index.
    poses: Vec<Vec<f64>>,
}

/// Effects of a machine that enter the control, by tables of its axes and as lost motion: all but those that `found`, the machine with
/// its effects taken into component errors, still has.
pub fn entered_effects(machine: &Machine, found: &Machine) -> Vec<Effect> {
    let stays = |effect: &Effect| found.effects.contains(effect) && !is_a(&effect.kind, Signature::Reversal);
    machine.effects.iter().filter(|one| !stays(one)).cloned().collect()
}

/// Parameters that make the volume worse.
#[derive(Debug, Clone, PartialEq)]
pub struct Worsening {
    /// Error of the tool tip that 95 % of poses do not exceed, mm: as the machine is.
    pub now_mm: f64,
    /// The same with the parameters.
    pub after_mm: f64,
    /// The cause that makes most of what stays, in words.
    pub stays: String,
}

/// What stays of the errors of a fitted machine, for those numbers that the control takes; `None` where travels or the spindle are
/// not stated.
pub fn remaining(
    session: &Session,
    fitted: &Machine,
    fit: &Fit,
    (numbers, enters): (&[Number], &Enters),
) -> Option<Remaining> {
    let mut tool = Tool::of(fitted, None)?;
    // the tip is where the spindle ball is
    if let Some(ball) =
        session.tests.first().map(|test| &test.spindle_ball).filter(|_| session.machine.carried.is_empty())
    {
        tool.tip_mm = ball.at;
    }
    let poses = poses(fitted, tool, None, POSES).ok()?;
    let pivot = |is_told: &Enters| {
        let told = numbers.iter().filter(|number| number.what == What::Pivot && is_told(number));
        told.fold(tool.tip_mm, |tip, number| tip + Vector3::ith(number.component, number.change))
    };
    let real = Tool { tip_mm: pivot(&|_| true), ..tool };
    let entered = Tool { tip_mm: pivot(enters), ..tool };
    // a zero shift is taken with the workpiece's zero
    let is_left_out = |number: &Number, axis: usize, component: usize| {
        let is_vector = matches!(number.what, What::TableCentre | What::Vector { .. });
        is_vector && (number.axis, number.component) == (axis, component) && !enters(number)
    };
    let kept = held_where(fitted, &|axis, component| !numbers.iter().any(|one| is_left_out(one, axis, component)));
    let nominal = fitted.as_drawn();
    let unsure = spread(fitted, fit, tool, &poses).left;
    let tools = (real, entered);
    let figures = [left_over(fitted, &nominal, (real, tool), &poses), left_over(fitted, &kept, tools, &poses), unsure];
    Some(Remaining { figures, kept, tools, poses })
}

/// Figures of drawn poses that differ by a smaller share are the same: parameters then make the volume no worse.
const SAME_FIGURE: f64 = 0.01;

impl Remaining {
    /// By how much the parameters make the volume of the fitted machine worse, and what stays; `None` where they do not.
    pub fn worsening(&self, fitted: &Machine) -> Option<Worsening> {
        let [now_mm, after_mm] = [0, 1].map(|k| self.figures[k].position_mm.p95);
        (after_mm > (1.0 + SAME_FIGURE) * now_mm).then(|| {
            let stays = what_stays(fitted, &self.kept, self.tools, &self.poses);
            Worsening { now_mm, after_mm, stays }
        })
    }
}
