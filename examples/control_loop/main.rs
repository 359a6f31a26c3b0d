//! A real control in the loop: a plan's programs run on LinuxCNC's planner, a hidden machine errs along what the axes did, a
//! gauge records, and the commands of a user find the errors, correct the programs and look again.
//!
//! `cargo run --example control_loop -- [SEED] [FOLDER]`; LinuxCNC and the reference data's `control-loop/run` are needed
//! (`FIVEAXIS_SHARED` names the reference data). The plan is that of `examples/captures`. Files stay in FOLDER if it is named;
//! traces that lie there are not run again.
//!
//! The hidden machine's kinematics are those of `tests/plain_machine`, which share nothing with the library; balls are mounted
//! anew before the second look.

#[path = "../../tests/plain_machine/mod.rs"]
mod plain_machine;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use fiveaxis::load::load_session;
use fiveaxis::machine::{AxisKind, Machine};
use fiveaxis::session::{Session, Test};
use plain_machine::{Plain, distance};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

/// Readings a second.
const RATE: usize = 100;
/// Noise of a reading, mm.
const NOISE_MM: f64 = 0.2e-3;
/// Standard deviation with which pivots and the spindle ball are mounted, mm.
const MOUNTED_MM: [f64; 2] = [20e-3, 1e-3];
/// The gauge's stroke to either side, mm.
const STROKE_MM: f64 = 0.9;
fn main() {
    let mut arguments = std::env::args().skip(1);
    let seed: u64 = arguments.next().map_or(1, |text| text.parse().expect("a seed"));
    let scratch = tempfile::tempdir().expect("folder");
    let folder = arguments.next().map_or_else(|| scratch.path().to_path_buf(), PathBuf::from);
    let Some(control) = control() else {
        println!("LinuxCNC is not on the PATH, or control-loop not in the reference data: nothing to run");
        return;
    };
    let plan = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/captures");
    let session = load_session(&plan.join("session.yaml")).expect("the shipped plan");
    let truth = truth(&session.machine, seed);
    let before = look(&control, &session, &truth, &plan.join("programs"), &folder.join("before"), &plan, seed);
    let corrected = folder.join("corrected");
    std::fs::create_dir_all(&corrected).expect("folder");
    for program in programs(&plan.join("programs")) {
        let out = corrected.join(program.file_name().expect("name"));
        let fitted = folder.join("before/fitted/machine.yaml");
        run(Command::new(fiveaxis())
            .arg("compensate")
            .arg(&program)
            .arg(plan.join("machine.yaml"))
            .arg("--errors")
            .arg(&fitted)
            .args(["--initial", "G54", "--offset", "G54:", "--force", "--out"])
            .arg(&out));
    }
    let after = look(&control, &session, &truth, &corrected, &folder.join("after"), &plan, seed + 1000);
    table(&session.machine, &truth, &before, &after);
}

/// The reference data's script and LinuxCNC, if both are there.
fn control() -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
    let script = std::env::var_os("FIVEAXIS_SHARED").map_or_else(beside, PathBuf::from).join("control-loop/run");
    let path = std::env::var_os("PATH")?;
    let is_there = std::env::split_paths(&path).any(|folder| folder.join("linuxcnc").is_file());
    (is_there && script.is_file()).then_some(script)
}

/// The binary of the same build.
fn fiveaxis() -> PathBuf {
    let own = std::env::current_exe().expect("own place");
    own.parent().and_then(Path::parent).expect("target").join("fiveaxis")
}

fn run(command: &mut Command) -> String {
    let output = command.output().expect("it starts");
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Two circles that move alike: a capture does not tell which of them it is, and only one capture at a time can be named.
const ALIKE: [&str; 2] = ["yz-100-1.ngc", "zx-100-1.ngc"];

fn programs(folder: &Path) -> Vec<PathBuf> {
    let mut list: Vec<PathBuf> = std::fs::read_dir(folder)
        .expect("programs")
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|file| file.extension().is_some_and(|extension| extension == "ngc") && !file.ends_with("dry-run.ngc"))
        .filter(|file| ALIKE.iter().all(|name| !file.ends_with(name)))
        .collect();
    list.sort();
    list
}

/// The machine as it really is: some tens of micrometres and arc seconds on the rotary axes.
fn truth(machine: &Machine, seed: u64) -> Machine {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut truth = machine.clone();
    for axis in truth.axes.iter_mut().filter(|axis| axis.kind == AxisKind::Rotary) {
        for component in axis.slots() {
            let size = if component.is_angle() { 1e-4 } else { 0.05 };
            axis.location_errors[component.index()] = size * random.random_range(-1.0..1.0);
        }
    }
    truth
}

/// Runs programs, records and identifies: values and standard deviations by name.
fn look(
    control: &Path,
    session: &Session,
    truth: &Machine,
    programs_in: &Path,
    folder: &Path,
    plan: &Path,
    seed: u64,
) -> BTreeMap<String, (f64, f64)> {
    std::fs::create_dir_all(folder).expect("folder");
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut balls: BTreeMap<String, [f64; 3]> = BTreeMap::new();
    let mut import = Command::new(fiveaxis());
    import.arg("import");
    for program in programs(programs_in) {
        let name = program.file_stem().expect("name").to_string_lossy().into_owned();
        let trace = folder.join(format!("{name}-trace.csv"));
        if !trace.is_file() {
            run(Command::new(control).arg(&program).arg(&trace).env("ROTARY", "AC").env("MOST_SECONDS", "400"));
        }
        let test = session.tests.iter().find(|test| test.name == format!("{name}-ccw")).expect("the program's test");
        let capture = folder.join(format!("{name}.csv"));
        std::fs::write(&capture, recorded(truth, test, &trace, &mut balls, &mut random)).expect("written");
        import.arg(capture);
    }
    let imported = folder.join("imported");
    run(import.arg("--session").arg(plan.join("session.yaml")).args(["--force", "--out"]).arg(&imported));
    let fitted = folder.join("fitted");
    let text = run(Command::new(fiveaxis())
        .arg("identify")
        .arg(imported.join("session.yaml"))
        .arg("--json")
        .args(["--force", "--save"])
        .arg(&fitted));
    let value: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    println!("{}: residual {} µm rms", folder.display(), value["rms_um"]);
    let errors = value["location_errors"].as_object().expect("errors");
    errors
        .iter()
        .map(|(name, error)| {
            let number = |key: &str| error[key].as_f64().unwrap_or(f64::NAN);
            (name.clone(), (number("value"), number("sigma")))
        })
        .collect()
}

/// What the gauge writes from when the bar is mounted until it is taken off.
fn recorded(
    truth: &Machine,
    test: &Test,
    trace: &Path,
    balls: &mut BTreeMap<String, [f64; 3]>,
    random: &mut ChaCha8Rng,
) -> String {
    let plain = Plain { machine: truth, errs: true, tip: [0.0; 3], axis: [0.0, 0.0, 1.0] };
    let mut placed = |ball: &fiveaxis::session::Ball, spread: f64| -> [f64; 3] {
        let normal = Normal::new(0.0, spread).expect("normal");
        let off = balls
            .entry(format!("{} {:?}", ball.link, ball.at))
            .or_insert_with(|| std::array::from_fn(|_| normal.sample(random)));
        std::array::from_fn(|k| ball.at[k] + off[k])
    };
    let (pivot, spindle) = (placed(&test.pivot, MOUNTED_MM[0]), placed(&test.spindle_ball, MOUNTED_MM[1]));
    let bar = test.bar_length_mm.expect("bar");
    let text = std::fs::read_to_string(trace).expect("trace");
    let mut lines = text.lines();
    let names: Vec<usize> = lines
        .next()
        .expect("head")
        .split(',')
        .filter_map(|name| truth.axis_index(name.split('_').next().expect("axis")))
        .collect();
    let step = 1000 / RATE;
    let lengths: Vec<(f64, f64, Vec<f64>)> = lines
        .step_by(step)
        .map(|line| {
            let values: Vec<f64> = line.split(',').map(|value| value.parse().expect("number")).collect();
            let mut q = vec![0.0; truth.axes.len()];
            names.iter().zip(&values[1..]).for_each(|(&k, value)| q[k] = truth.axes[k].kind.from_file_unit(*value));
            let ends = [(&test.pivot.link, pivot), (&test.spindle_ball.link, spindle)];
            let [one, other] = ends.map(|(link, at)| plain.ball(link, at, &q));
            (values[0], distance(one, other) - bar, q)
        })
        .collect();
    // the bar is on while it fits: the longest stretch
    let stretches = lengths.split(|(_, off, _)| off.abs() > STROKE_MM);
    let fits = stretches.max_by_key(|stretch| stretch.len()).expect("a stretch");
    // it is mounted and taken off while the axes stand
    let stands = |k: &usize| fits[*k].2 == fits[k + RATE].2;
    let first = (0..fits.len() - RATE).find(stands).expect("a standstill");
    let last = (0..fits.len() - RATE).rev().find(stands).expect("a standstill") + RATE;
    let on = &fits[first..=last];
    let noise = Normal::new(0.0, NOISE_MM).expect("normal");
    let mut capture = format!("Ball bar recorder\nSample rate: {RATE} Hz\ntime_s;deviation_um\n");
    let begin = on.first().map_or(0.0, |(time, ..)| *time);
    for (time, off, _) in on {
        let _ = writeln!(capture, "{:.3};{:.2}", time - begin, 1e3 * (off + noise.sample(random)));
    }
    capture
}

/// The truth beside what was found.
fn table(
    machine: &Machine,
    truth: &Machine,
    before: &BTreeMap<String, (f64, f64)>,
    after: &BTreeMap<String, (f64, f64)>,
) {
    println!("{:<6} {:>9} {:>9} {:>7}   {:>15} {:>7}", "error", "true", "found", "sigma", "after correction", "sigma");
    for slot in machine.slots() {
        let name = slot.to_string();
        let axis = machine.axis_index(&slot.axis).expect("axis");
        let real = slot.component.measure().to_output(truth.axes[axis].location_errors[slot.component.index()]);
        let (Some(one), Some(other)) = (before.get(&name), after.get(&name)) else { continue };
        println!("{name:<6} {real:>9.2} {:>9.2} {:>7.2}   {:>15.2} {:>7.2}", one.0, one.1, other.0, other.1);
    }
}
