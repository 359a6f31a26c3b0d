//! The text of a program in a control's language: head, steps, end.

use super::coordinates::Coordinates;
use super::dialect::{Dialect, Title};
use super::dry_run::dry_run_steps;
use super::head::{dry_run_head, test_head};
use super::heidenhain;
use super::iso;
use super::step::Step;
use super::test_steps::steps;
use crate::machine::Machine;
use crate::plan::{Plan, PlannedTest};

/// The program of a planned test; `zero` says where the zero of the machine file is, as [`super::zero_words`] does.
pub fn program(machine: &Machine, planned: &PlannedTest, zero: &[String], dialect: Dialect) -> String {
    let coordinates = dialect.coordinates(machine);
    let steps = steps(machine, planned, &coordinates, dialect.curves());
    let name = planned.test.name.to_uppercase().replace(|c: char| !c.is_ascii_alphanumeric(), "_");
    let number = FIRST_NUMBER + planned.number;
    let head = test_head(machine, planned, zero, dialect, &coordinates);
    write(&Title { name, number }, &head, &steps, &coordinates, dialect)
}

/// The program that goes through a whole plan without the bar; `zero` as [`program`].
pub fn dry_run_program(machine: &Machine, plan: &Plan, zero: &[String], dialect: Dialect) -> String {
    let coordinates = dialect.coordinates(machine);
    let steps = dry_run_steps(machine, plan, &coordinates, dialect.curves());
    let head = dry_run_head(machine, zero, dialect, &coordinates);
    write(&Title { name: "DRY_RUN".into(), number: FIRST_NUMBER }, &head, &steps, &coordinates, dialect)
}

/// Number of the dry run; tests are counted on from it. Users' programs have 1 to 7999, makers' 8000 and more.
const FIRST_NUMBER: usize = 7000;

fn write(title: &Title, head: &[String], steps: &[Step], coordinates: &Coordinates, dialect: Dialect) -> String {
    match dialect {
        Dialect::Heidenhain => heidenhain::program(&title.name, head, steps, coordinates),
        _ => iso::program(title, head, steps, coordinates, dialect),
    }
}
