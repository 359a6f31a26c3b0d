//! What a topology's plan reaches, freely and from one pivot setup. One topology at a time; nothing here draws or writes.

use super::alike::representative;
use super::envelope::envelope;
use crate::bodies::Kit;
use crate::machine::StructuralCode;
use crate::plan::{OnePivot, Plan, PlanError, Settings, plan};

/// On which side of the bed the rotary axes are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Family {
    /// Both carry the workpiece.
    TableTable,
    /// One carries the workpiece, one the tool.
    TableHead,
    /// Both carry the tool.
    HeadHead,
}

impl Family {
    /// Family of a code.
    pub fn of(code: &StructuralCode) -> Family {
        match code.workpiece_side.iter().filter(|name| matches!(name.as_str(), "A" | "B" | "C")).count() {
            0 => Family::HeadHead,
            1 => Family::TableHead,
            _ => Family::TableTable,
        }
    }

    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Family::TableTable => "table-table",
            Family::TableHead => "table-head",
            Family::HeadHead => "head-head",
        }
    }

    /// All, in the order of tables.
    pub const ALL: [Family; 3] = [Family::TableTable, Family::TableHead, Family::HeadHead];
}

/// A row of the survey.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    pub code: StructuralCode,
    pub family: Family,
    /// Location errors of the two rotary axes.
    pub errors: usize,
    /// Errors that clear and reachable tests determine.
    pub determined: usize,
    /// Errors that ball-bar lengths of this topology could determine if nothing were in the way.
    pub visible: usize,
    /// Names of the errors that the plan does not determine.
    pub undetermined: Vec<String>,
    pub tests: usize,
    pub pivot_setups: usize,
    pub minutes: f64,
    /// Worst standard deviation of the determined positions, mm, and orientations, rad; `None` without any.
    pub position_mm: Option<f64>,
    pub orientation_rad: Option<f64>,
    /// The plan from one pivot setup; `None` when there is no test at all.
    pub one_pivot: Option<OnePivot>,
    /// Reachable setups looked at.
    pub considered: usize,
}

impl Outcome {
    /// All that lengths can show is determined from one pivot setup.
    pub fn is_fully_tested_from_one_pivot(&self) -> bool {
        self.visible > 0 && self.one_pivot.is_some_and(|one| one.determined >= self.visible)
    }
}

/// Plans one topology, as the one that stands for it.
pub fn outcome(code: &StructuralCode, kit: &Kit, settings: &Settings) -> Result<Outcome, PlanError> {
    let (machine, bodies) = envelope(&representative(code));
    Ok(outcome_of(code, &plan(&machine, &bodies, kit, settings)?))
}

/// The row of a topology from its plan.
pub fn outcome_of(code: &StructuralCode, free: &Plan) -> Outcome {
    let worst = |angle: bool| {
        let of_kind = free.errors.iter().filter(|error| error.determined && error.is_angle == angle);
        of_kind.map(|error| error.sigma).reduce(f64::max)
    };
    Outcome {
        code: code.clone(),
        family: Family::of(code),
        errors: free.errors.len(),
        determined: free.errors.iter().filter(|error| error.determined).count(),
        visible: free.errors.iter().filter(|error| error.visible).count(),
        undetermined: free.errors.iter().filter(|error| !error.determined).map(|error| error.name.clone()).collect(),
        tests: free.tests.len(),
        pivot_setups: free.pivot_setups,
        minutes: free.minutes,
        position_mm: worst(false),
        orientation_rad: worst(true),
        one_pivot: free.one_pivot,
        considered: free.considered,
    }
}
