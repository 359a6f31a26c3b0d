//! A real control in the loop: a plan's programs run on LinuxCNC's planner, a hidden machine errs along what the axes did, a
//! gauge records, and the commands of a user find the errors, correct the programs and look again.
//!
//! ```text
//! cargo run --example control_loop -- FOLDER [all | coverage | NUMBER] [exact] [known]
//! ```
//!
//! `all` runs the twelve machines of [`case`] and prints their table, a NUMBER one of them, `coverage` forty machines of the first
//! kind whose slides err as those of new machines do. `exact` drives programs exactly in LinuxCNC's place, `known` corrects for
//! the machine as it is in place of the machine as found. LinuxCNC and the reference data's `control-loop/run` are needed
//! (`FIVEAXIS_SHARED` names the reference data). Traces of the same program that lie in FOLDER are not run again. `FIVEAXIS_BIN`
//! names another binary than that of the same build, `FIVEAXIS_CONTROL_SPEED` runs the control's clock faster (see `faster`).
//!
//! The hidden machine's kinematics are those of `tests/plain_machine`, which share nothing with the library.

#[path = "../../tests/plain_machine/mod.rs"]
mod plain_machine;
#[path = "../../tests/plain_program/mod.rs"]
mod plain_program;

mod case;
mod control;
mod course;
mod exact;
mod gauge;
mod left;
mod physics;
mod user;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use fiveaxis::load::load_session;
use fiveaxis::report::machine_yaml;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use case::{CASES, Case};
use control::Control;
use course::Course;
use gauge::{Gauge, NOISE_MM, RATE};
use left::Seen;
use physics::Hidden;
use user::Answer;

/// Machines of the coverage.
const COVERAGE: u64 = 40;

/// How a case is run.
#[derive(Clone, Copy)]
struct Way {
    /// Programs are driven exactly, without LinuxCNC.
    is_exact: bool,
    /// The machine as it is, in place of the machine as found.
    is_known: bool,
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(arguments.next().expect("a folder for traces and captures"));
    let what = arguments.next().unwrap_or_else(|| "all".into());
    let words: Vec<String> = arguments.collect();
    assert!(words.iter().all(|word| matches!(word.as_str(), "exact" | "known")), "exact, known or nothing");
    let has = |word: &str| words.iter().any(|other| other == word);
    let way = Way { is_exact: has("exact"), is_known: has("known") };
    let folder = folder.join(words.join("-"));
    let traces = folder.join("traces");
    let control = if way.is_exact { Some(Control::exact(&traces)) } else { Control::found(&traces) };
    let Some(control) = control else {
        println!("LinuxCNC is not on the PATH, or control-loop not in the reference data: nothing to run");
        return;
    };
    let run = |number: usize| run_case(&control, &folder, number, number as u64, way);
    match what.as_str() {
        "coverage" => coverage(&control, &folder),
        "all" => {
            println!("{}", Row::head());
            (1..=CASES.len()).for_each(|number| println!("{}", run(number)));
        }
        number => {
            let number: usize = number.parse().expect("all, coverage or the number of a case");
            println!("{}\n{}", Row::head(), run(number));
        }
    }
}

/// What one case gave.
struct Row {
    number: usize,
    case: &'static Case,
    /// None where the machine was known.
    answer: Option<Answer>,
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
        let (first, rank, told) = self.answer.as_ref().map_or_else(
            || ("known".to_owned(), "–".to_owned(), f64::NAN),
            |answer| (answer.first(), answer.rank(self.case.name), answer.noise_um),
        );
        write!(
            f,
            "| {} | {} | {} | {first} | {rank} | {} of {} | {noise:.2}, {told:.2} | {:.2} | {:.2} | {:.2} | {:.2} → {:.2} |",
            self.number,
            self.case.machine,
            self.case.concealed,
            self.within.0,
            self.within.1,
            self.before.fitted_um,
            self.after.fitted_um,
            self.after.fitted_um / noise,
            self.before.raw_um,
            self.after.raw_um,
        )?;
        for (before, after) in self.before.by_program.iter().zip(&self.after.by_program) {
            write!(
                f,
                "\n    {}: {:.2} µm before (largest {:.2}), {:.2} after (largest {:.2}; {:.2} by the control)",
                after.program, before.rms_um, before.largest_um, after.rms_um, after.largest_um, after.control_um
            )?;
        }
        Ok(())
    }
}

fn run_case(control: &Control, folder: &Path, number: usize, seed: u64, way: Way) -> Row {
    let case = &CASES[number - 1];
    let folder = folder.join(format!("{number:02}-{}", case.name));
    let plan = user::planned(case.machine, &folder.join("plan"));
    let session = load_session(&plan.join("session.yaml")).expect("the plan");
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let truth = physics::truth(&session.machine, &mut random);
    let hidden = Hidden { machine: truth.clone(), effect: case.effect, slides: Vec::new() };
    let mut gauge = Gauge::new(&session, hidden.clone(), random);
    let programs = control::programs(&plan.join("nc/linuxcnc"));
    let (mut captures, mut before) = (Vec::new(), Vec::new());
    for program in &programs {
        let trace = control.trace(case.machine, &session.machine, program);
        let look = gauge.look(&control::name_of(program), &trace);
        captures.push((control::name_of(program), look.capture(&folder.join("captures"), &control::name_of(program))));
        before.push(look);
    }
    let truth_file = folder.join("truth.yaml");
    std::fs::write(&truth_file, machine_yaml(&hidden.as_machine_file())).expect("written");
    let (answer, errors) = match way.is_known {
        true => (None, truth_file),
        false => {
            let imported = user::imported(&plan, &captures, &folder.join("imported"));
            (Some(user::diagnosed(&imported, &folder.join("found"))), folder.join("found/session.yaml"))
        }
    };
    let within = answer.as_ref().map_or((0, 0), |answer| answer.within(&truth, "sigma"));
    let (mut after, mut courses) = (Vec::new(), BTreeMap::new());
    for program in &programs {
        let name = control::name_of(program);
        let planned = user::numbered(program, &folder.join("numbered"));
        let corrected = user::corrected(&planned, &plan, &errors, &folder.join("corrected"));
        let trace = control.trace(&format!("{number:02}-{}", case.name), &session.machine, &corrected);
        let look = gauge.look(&name, &trace);
        look.capture(&folder.join("captures-after"), &name);
        after.push(look);
        courses.insert(name, Course::new(&session.machine, &planned, &corrected));
    }
    let before = left::seen(&gauge, &BTreeMap::new(), &before.iter().collect::<Vec<_>>());
    let after = left::seen(&gauge, &courses, &after.iter().collect::<Vec<_>>());
    Row { number, case, answer, within, before, after }
}

/// Location errors and slides of a new machine, drawn anew for every seed, on the traces of one machine.
fn coverage(control: &Control, folder: &Path) {
    let case = &CASES[0];
    let plan = user::planned(case.machine, &folder.join("coverage/plan"));
    let session = load_session(&plan.join("session.yaml")).expect("the plan");
    let (mut within, mut all, mut identified, mut by_noise, mut alarms, mut failed) = (0, 0, 0, 0, 0, 0);
    for seed in 1001..1001 + COVERAGE {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut truth = physics::truth(&session.machine, &mut random);
        let slides = physics::erring_slides(&mut truth, &mut random);
        let mut gauge = Gauge::new(&session, Hidden { machine: truth.clone(), effect: None, slides }, random);
        let folder = folder.join(format!("coverage/{seed}"));
        let mut captures = Vec::new();
        for program in control::programs(&plan.join("nc/linuxcnc")) {
            let trace = control.trace(case.machine, &session.machine, &program);
            let name = control::name_of(&program);
            captures.push((name.clone(), gauge.look(&name, &trace).capture(&folder, &name)));
        }
        let imported = user::imported(&plan, &captures, &folder.join("imported"));
        let answer = user::diagnosed(&imported, &folder.join("found"));
        let (good, count) = answer.within(&truth, "sigma");
        (within, all) = (within + good, all + count);
        let plain = user::identified(&imported);
        identified += plain.within(&truth, "sigma").0;
        by_noise += plain.within(&truth, "sigma_noise").0;
        alarms += usize::from(answer.first() != "–");
        failed += usize::from(count == 0);
        println!(
            "{seed}: {good} of {count} within 2 σ; told: {}; so far {within}, identify {identified} of {all}",
            answer.first()
        );
    }
    let percent = |within: usize| 100.0 * within as f64 / all as f64;
    println!(
        "{within} of {all} within 2 σ ({:.1} %), by identify {identified} ({:.1} %), with the sigma of noise alone {by_noise} ({:.1} %), {alarms} of {COVERAGE} with a finding, {failed} without an answer; {RATE} readings a second",
        percent(within),
        percent(identified),
        percent(by_noise)
    );
}
