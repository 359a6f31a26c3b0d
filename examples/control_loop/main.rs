//! A real control in the loop: a plan's programs run on LinuxCNC's planner, a hidden machine errs along what the axes did, a
//! gauge records, and the commands of a user find the errors, correct the programs and look again.
//!
//! ```text
//! cargo run --example control_loop -- FOLDER [all | coverage | NUMBER]
//! ```
//!
//! `all` runs the twelve machines of [`case`] and prints their table, a NUMBER one of them, `coverage` forty machines of the first
//! kind. LinuxCNC and the reference data's `control-loop/run` are needed (`FIVEAXIS_SHARED` names the reference data). Traces
//! that lie in FOLDER are not run again. `FIVEAXIS_BIN` names another binary than that of the same build,
//! `FIVEAXIS_CONTROL_SPEED` runs the control's clock faster (see `faster`).
//!
//! The hidden machine's kinematics are those of `tests/plain_machine`, which share nothing with the library.

#[path = "../../tests/plain_machine/mod.rs"]
mod plain_machine;

mod case;
mod control;
mod gauge;
mod left;
mod physics;
mod user;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use fiveaxis::load::load_session;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use case::{CASES, Case};
use control::Control;
use gauge::{Gauge, NOISE_MM, RATE};
use left::Seen;
use physics::Hidden;
use user::Answer;

/// Machines of the coverage.
const COVERAGE: u64 = 40;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(arguments.next().expect("a folder for traces and captures"));
    let what = arguments.next().unwrap_or_else(|| "all".into());
    let Some(control) = Control::found(&folder.join("traces")) else {
        println!("LinuxCNC is not on the PATH, or control-loop not in the reference data: nothing to run");
        return;
    };
    match what.as_str() {
        "coverage" => coverage(&control, &folder),
        "all" => {
            println!("{}", Row::head());
            (1..=CASES.len()).for_each(|number| println!("{}", run_case(&control, &folder, number, number as u64)));
        }
        number => {
            let number: usize = number.parse().expect("all, coverage or the number of a case");
            println!("{}\n{}", Row::head(), run_case(&control, &folder, number, number as u64));
        }
    }
}

/// What one case gave.
struct Row {
    number: usize,
    case: &'static Case,
    answer: Answer,
    within: (usize, usize),
    before: Seen,
    after: Seen,
}

impl Row {
    fn head() -> String {
        "|  | machine | concealed | told first | named | within 2 σ | noise µm: true, told | before µm | after µm | after / noise | told balls, µm |\n|---|---|---|---|---|---|---|---|---|---|---|".into()
    }
}

impl std::fmt::Display for Row {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let noise = 1e3 * NOISE_MM;
        write!(
            f,
            "| {} | {} | {} | {} | {} | {} of {} | {noise:.2}, {:.2} | {:.2} | {:.2} | {:.2} | {:.2} |",
            self.number,
            self.case.machine,
            self.case.concealed,
            self.answer.first(),
            self.answer.rank(self.case.name),
            self.within.0,
            self.within.1,
            self.answer.noise_um,
            self.before.fitted_um,
            self.after.fitted_um,
            self.after.fitted_um / noise,
            self.after.raw_um,
        )?;
        let noise_um = 1e3 * NOISE_MM;
        for (program, um) in self.after.by_program.iter().filter(|(_, um)| *um > 1.2 * noise_um) {
            write!(f, "\n    {program} keeps {um:.2} µm")?;
        }
        Ok(())
    }
}

fn run_case(control: &Control, folder: &Path, number: usize, seed: u64) -> Row {
    let case = &CASES[number - 1];
    let folder = folder.join(format!("{number:02}-{}", case.name));
    let plan = user::planned(case.machine, &folder.join("plan"));
    let session = load_session(&plan.join("session.yaml")).expect("the plan");
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let truth = physics::truth(&session.machine, &mut random);
    let mut gauge = Gauge::new(&session, Hidden { machine: truth.clone(), effect: case.effect }, random);
    let programs = control::programs(&plan.join("nc/linuxcnc"));
    let (mut captures, mut before) = (Vec::new(), Vec::new());
    for program in &programs {
        let trace = control.trace(case.machine, &session.machine, program);
        let look = gauge.look(&control::name_of(program), &trace);
        captures.push((control::name_of(program), look.capture(&folder.join("captures"), &control::name_of(program))));
        before.push((control::name_of(program), trace, look));
    }
    let imported = user::imported(&plan, &captures, &folder.join("imported"));
    let answer = user::diagnosed(&imported, &folder.join("found"));
    let within = answer.within(&truth);
    let mut after = Vec::new();
    for program in &programs {
        let corrected = user::corrected(program, &plan, &folder.join("found"), &folder.join("corrected"));
        let trace = control.trace(&format!("{number:02}-{}", case.name), &session.machine, &corrected);
        let look = gauge.look(&control::name_of(program), &trace);
        look.capture(&folder.join("captures-after"), &control::name_of(program));
        after.push(look);
    }
    let nominal: BTreeMap<&str, &Path> =
        before.iter().map(|(name, trace, _)| (name.as_str(), trace.as_path())).collect();
    let looks: Vec<_> = before.iter().map(|(_, _, look)| look).collect();
    let (before, after) =
        (left::seen(&gauge, &nominal, &looks), left::seen(&gauge, &nominal, &after.iter().collect::<Vec<_>>()));
    Row { number, case, answer, within, before, after }
}

/// Location errors alone, drawn anew for every seed, on the traces of one machine.
fn coverage(control: &Control, folder: &Path) {
    let case = &CASES[0];
    let plan = user::planned(case.machine, &folder.join("coverage/plan"));
    let session = load_session(&plan.join("session.yaml")).expect("the plan");
    let (mut within, mut all, mut alarms, mut failed) = (0, 0, 0, 0);
    for seed in 1001..1001 + COVERAGE {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let truth = physics::truth(&session.machine, &mut random);
        let mut gauge = Gauge::new(&session, Hidden { machine: truth.clone(), effect: None }, random);
        let folder = folder.join(format!("coverage/{seed}"));
        let mut captures = Vec::new();
        for program in control::programs(&plan.join("nc/linuxcnc")) {
            let trace = control.trace(case.machine, &session.machine, &program);
            let name = control::name_of(&program);
            captures.push((name.clone(), gauge.look(&name, &trace).capture(&folder, &name)));
        }
        let imported = user::imported(&plan, &captures, &folder.join("imported"));
        let answer = user::diagnosed(&imported, &folder.join("found"));
        let (good, count) = answer.within(&truth);
        (within, all) = (within + good, all + count);
        alarms += usize::from(answer.first() != "–");
        failed += usize::from(count == 0);
        println!("{seed}: {good} of {count} within 2 σ; told: {}; so far {within} of {all}", answer.first());
    }
    println!(
        "{within} of {all} within 2 σ ({:.1} %), {alarms} of {COVERAGE} with a finding, {failed} without an answer; {RATE} readings a second",
        100.0 * within as f64 / all as f64
    );
}
