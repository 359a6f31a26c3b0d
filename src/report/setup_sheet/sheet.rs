//! What a setup sheet tells of. It is written in `page`.

use super::picture::View;
use crate::bodies::{Bodies, Kit};
use crate::machine::Machine;
use crate::plan::{Plan, Settings};

/// Everything that a sheet tells of.
#[derive(Debug, Clone, Copy)]
pub struct Sheet<'a> {
    pub machine: &'a Machine,
    pub bodies: &'a Bodies,
    pub kit: &'a Kit,
    pub settings: &'a Settings,
    pub plan: &'a Plan,
    /// Two views of each test.
    pub pictures: &'a [[View; 2]],
    /// Program files of each test, relative to the sheet.
    pub programs: &'a [Vec<String>],
    /// Programs that go through the plan without the bar, one for each control.
    pub dry_runs: &'a [String],
}

impl Sheet<'_> {
    pub(super) fn some_test_is_indexed(&self) -> bool {
        self.plan.tests.iter().any(|test| test.test.spindle_ball.indexed_about.is_some())
    }
}
