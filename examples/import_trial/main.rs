//! Places simulated captures of whole sessions, compares what is identified from them with ideal recordings, and tries captures
//! that are to be refused. Programs are the plan's own; control, machine and gauge share no code with the library.
//!
//! `cargo run --release --example import_trial -- [SEED] [CAPTURES] [plain | habits | FOLDER]`; `plain`: programs without marks;
//! `habits`: controls and operators that do more than run a program as written, with marks and without; FOLDER: where LinuxCNC's traces of the programs lie or are put (LinuxCNC and the reference data's `control-loop/run` are needed for
//! those that are not there; it runs in real time).

#[path = "../../tests/captured/mod.rs"]
mod captured;
#[path = "../../tests/nc_reader/mod.rs"]
#[allow(dead_code, reason = "programs without captures are for the tests")]
mod nc_reader;
#[path = "../../tests/plain_machine/mod.rs"]
mod plain_machine;

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use captured::{Drawn, Erring, HABITS, Habit, Kind, Planned, Trace, planned};
use fiveaxis::identify::{Options, identify};
use fiveaxis::import::{Feeds, Placement, SessionTimes, WhyPlanned, place, split_session};
use fiveaxis::machine::AxisKind;
use fiveaxis::session::{Recording, Session};

/// Plans that are tried in turn: machine and feed, mm/min.
const PLANS: [(&str, f64); 4] = [
    ("hermle-c600u.yaml", 1500.0),
    ("fig-1-1-table-head-ca.yaml", 500.0),
    ("head-head-ab-profiler.yaml", 800.0),
    ("hermle-c600u.yaml", 500.0),
];
/// Axis positions that a placement must reach where the readings tell more, deg.
const REACH_DEG: f64 = 0.05;

#[derive(Default)]
struct Count {
    captures: usize,
    placed: usize,
    within: usize,
    within_005: usize,
    misplaced: usize,
    wrong_test: usize,
    off: Vec<f64>,
    /// Differences of location errors between captures and ideal recordings, in sigma.
    differences: Vec<f64>,
    refused: [usize; 2],
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let seed: u64 = arguments.next().map_or(1, |text| text.parse().expect("a seed"));
    let captures: usize = arguments.next().map_or(24, |text| text.parse().expect("a number of captures"));
    let third = arguments.next();
    let marks = third.as_deref() != Some("plain");
    let habits = third.as_deref() == Some("habits");
    let planned_all =
        |marks: bool| PLANS.iter().map(move |(machine, feed)| planned(machine, *feed, marks)).collect::<Vec<Planned>>();
    let mut plans = planned_all(marks);
    if habits {
        plans.extend(planned_all(false));
    }
    let mut count = Count::default();
    if let Some(folder) = third.filter(|_| marks && !habits) {
        by_linuxcnc(&plans, Path::new(&folder), seed, captures, &mut count);
        return summary(&mut count);
    }
    let mut session = 0;
    while count.captures < captures {
        let plan = &plans[session as usize % plans.len()];
        let seed = 1000 * seed + session;
        let all: Vec<usize> = (0..plan.pairs.len()).collect();
        let draw = |erring: &mut Erring, pair: usize| {
            let habit = if habits { HABITS[(pair + session as usize) % HABITS.len()] } else { Habit::Plain };
            plan.drawn_by(erring, pair, 100 * seed + pair as u64, Kind::Sound, habit)
        };
        whole_session(plan, &all, seed, &draw, &mut count);
        session += 1;
    }
    for k in 0..(captures as u64 / 10).max(2) {
        let plan = &plans[k as usize % plans.len()];
        what_is_to_be_refused(plan, 1_000_000 + 1000 * seed + k, &mut count);
    }
    summary(&mut count);
}

/// Captures of programs as LinuxCNC's planner ran them: plans in turn, other machines, rates and noise each time.
fn by_linuxcnc(plans: &[Planned], folder: &Path, seed: u64, captures: usize, count: &mut Count) {
    let traces: Vec<Vec<Option<Trace>>> = plans
        .iter()
        .enumerate()
        .map(|(k, plan)| {
            plan.linuxcnc.iter().map(|(name, text)| trace(plan, folder, &format!("{k}-{name}"), text)).collect()
        })
        .collect();
    let mut session = 0;
    while count.captures < captures && traces.iter().flatten().any(Option::is_some) {
        let k = session as usize % plans.len();
        let (plan, of_plan) = (&plans[k], &traces[k]);
        let seed = 1000 * seed + session;
        let there: Vec<usize> = (0..plan.pairs.len()).filter(|&pair| of_plan[pair].is_some()).collect();
        let draw = |erring: &mut Erring, pair: usize| {
            let trace = of_plan[pair].as_ref().expect("only those that are there");
            plan.drawn_of(trace, erring, pair, 100 * seed + pair as u64)
        };
        whole_session(plan, &there, seed, &draw, count);
        session += 1;
    }
}

/// The trace of a program in the folder; run now where it is not there and can be.
fn trace(plan: &Planned, folder: &Path, name: &str, text: &str) -> Option<Trace> {
    let machine = &plan.session.machine;
    let (file, program) = (folder.join(format!("{name}.csv")), folder.join(format!("{name}.ngc")));
    if !file.is_file() {
        std::fs::create_dir_all(folder).expect("folder");
        std::fs::write(&program, text).expect("written");
        let shared = std::env::var_os("FIVEAXIS_SHARED")?;
        let mut rotary: Vec<&str> =
            machine.axes.iter().filter(|axis| axis.kind == AxisKind::Rotary).map(|axis| axis.name.as_str()).collect();
        rotary.sort_unstable();
        let run = Path::new(&shared).join("control-loop/run");
        let output = Command::new(run)
            .args([&program, &file])
            .env("ROTARY", rotary.concat())
            .env("MOST_SECONDS", "900")
            .stdin(std::process::Stdio::null())
            .output()
            .ok()?;
        println!("{name}: {}", if output.status.success() { "run" } else { "LinuxCNC did not run it" });
    }
    file.is_file().then(|| Trace::read(&file, machine))
}

/// Captures of tests of a plan, each placed among all tests; then what is identified.
fn whole_session(
    plan: &Planned,
    tests: &[usize],
    seed: u64,
    draw: &dyn Fn(&mut Erring, usize) -> Drawn,
    count: &mut Count,
) {
    let mut erring = Erring::drawn(&plan.session.machine, seed);
    let mut found: Vec<(Placement, [(Recording, f64); 2])> = Vec::new();
    let mut ideal = Vec::new();
    for &pair in tests {
        let drawn = draw(&mut erring, pair);
        let begun = Instant::now();
        count.captures += 1;
        let placed = place(&plan.session, &plan.pairs, &drawn.capture, Feeds::Programmed);
        let seconds = begun.elapsed().as_secs_f64();
        let placement = match placed {
            Ok(placement) if placement.pair == plan.pairs[pair] => placement,
            Ok(placement) => {
                count.wrong_test += 1;
                let as_test = &plan.session.tests[placement.pair.tests[0]].name;
                println!("{seed} {}: PLACED AS {as_test} odds {:.1} {seconds:.1} s", drawn.says, placement.odds_tests);
                continue;
            }
            Err(why) => {
                println!("{seed} {}: REFUSED {why} {seconds:.1} s", drawn.says);
                continue;
            }
        };
        let bar_mm = plan.session.tests[placement.pair.tests[0]].bar_length_mm.expect("planned");
        let (off, truth) = plan.compared(&drawn, &placement);
        let limit = REACH_DEG.max(3.0 * placement.position_sigma);
        count.placed += 1;
        count.within += usize::from(off < limit);
        count.within_005 += usize::from(off < REACH_DEG);
        count.misplaced += usize::from(off > f64::max(0.25, 6.0 * placement.position_sigma));
        count.off.push(off);
        println!(
            "{seed} {}: off {off:.4} sigma {:.4} left {:.2} um noise {:.2} pace {:+.5} marks {} {seconds:.1} s {}",
            drawn.says,
            placement.position_sigma,
            1e3 * placement.left_mm,
            1e3 * placement.noise_mm,
            placement.timing.pace() - drawn.pace,
            placement.by_marks,
            if off < limit { "" } else { "<<<<" }
        );
        let column = fiveaxis::session::LengthColumn::DeviationMm;
        let recordings = fiveaxis::import::recordings(&placement, &drawn.capture, bar_mm, column);
        ideal.push((placement.clone(), truth));
        found.push((placement, recordings));
    }
    let planned = SessionTimes::Planned(WhyPlanned::NoneStated);
    let split = |recordings: &[_]| split_session(&plan.session, recordings, &planned);
    compare(&split(&found), &split(&ideal), seed, count);
}

/// Location errors from captures beside those from the same readings at their true positions.
fn compare(found: &Session, ideal_session: &Session, seed: u64, count: &mut Count) {
    let [found, ideal] = [found, ideal_session].map(|session| identify(session, &Options::default()));
    let (Ok(found), Ok(ideal)) = (found, ideal) else {
        println!("{seed}: identify refused one of the two");
        return;
    };
    let mut worst: (f64, String) = (0.0, String::new());
    for slot in ideal_session.machine.slots().iter().map(ToString::to_string) {
        let (Some(estimate), Some(other)) = (ideal.error(&slot), found.error(&slot)) else { continue };
        if !estimate.determined {
            continue;
        }
        let off = (other.value - estimate.value).abs() / estimate.sigma;
        count.differences.push(off);
        if off > worst.0 {
            worst = (off, slot);
        }
    }
    println!("{seed}: identified, at most {:.2} sigma from ideal recordings ({})", worst.0, worst.1);
}

fn what_is_to_be_refused(plan: &Planned, seed: u64, count: &mut Count) {
    let mut erring = Erring::drawn(&plan.session.machine, seed);
    let pair = seed as usize % plan.pairs.len();
    for kind in [Kind::CutAtStart, Kind::CutAtEnd, Kind::BarOff, Kind::Standing] {
        let drawn = plan.drawn(&mut erring, pair, seed, kind);
        tried(plan, &[plan.pairs[pair]], &drawn, &format!("{kind:?}"), count);
    }
    let drawn = plan.drawn(&mut erring, pair, seed, Kind::Sound);
    let other = plan.pairs[(pair + 1) % plan.pairs.len()];
    let says = format!("as {}", plan.session.tests[other.tests[0]].name);
    tried(plan, &[other], &drawn, &says, count);
}

fn tried(plan: &Planned, among: &[fiveaxis::import::Pair], drawn: &Drawn, says: &str, count: &mut Count) {
    count.refused[1] += 1;
    match place(&plan.session, among, &drawn.capture, Feeds::Programmed) {
        Ok(placement) => println!("{} {says}: PLACED sigma {:.3} <<<<", drawn.says, placement.position_sigma),
        Err(why) => {
            count.refused[0] += 1;
            println!("{} {says}: {why}", drawn.says);
        }
    }
}

fn summary(count: &mut Count) {
    let of = |list: &mut Vec<f64>, share: f64| {
        list.sort_by(f64::total_cmp);
        list.get(((list.len() as f64 * share) as usize).min(list.len().saturating_sub(1))).copied().unwrap_or(f64::NAN)
    };
    println!(
        "{} of {} placed, {} as another test; {} within max(0.05, 3 sigma), {} within 0.05 deg, {} misplaced",
        count.placed, count.captures, count.wrong_test, count.within, count.within_005, count.misplaced
    );
    println!(
        "off: median {:.4}, 95 % {:.4}, largest {:.4} deg",
        of(&mut count.off, 0.5),
        of(&mut count.off, 0.95),
        of(&mut count.off, 1.0)
    );
    let beyond = count.differences.iter().filter(|off| **off > 2.0).count();
    println!(
        "identify: {} errors, {beyond} beyond 2 sigma of ideal recordings, largest {:.2}",
        count.differences.len(),
        of(&mut count.differences, 1.0)
    );
    println!("{} of {} refused", count.refused[0], count.refused[1]);
}
