//! A real control in the loop: a plan's programs run on LinuxCNC's planner, a hidden machine errs along what the axes did, a
//! gauge records, and the commands of a user find the errors, correct the programs and look again.
//!
//! `cargo run --example control_loop -- [SEED] [FOLDER]`; LinuxCNC and the reference data's `control-loop/run` are needed
//! (`FIVEAXIS_SHARED` names the reference data). The plan is that of `examples/captures`. Files stay in FOLDER if it is named;
//! traces that lie there are not run again.
//!
//! The hidden machine's kinematics are those of `tests/plain_machine`, which share nothing with the library.

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
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut balls = BTreeMap::new();
    let first = folder.join("before");
    std::fs::create_dir_all(&first).expect("folder");
    let mut import = Command::new(fiveaxis());
    import.arg("import");
    let mut seen = Vec::new();
    for program in programs(&plan.join("programs")) {
        let trace = traced(&control, &program, &first);
        let test = test_of(&session, &program);
        let offs = readings(&truth, true, test, &trace, &mut balls, &mut random);
        let ideal = readings(&truth, false, test, &trace, &mut balls, &mut random);
        let capture = trace.with_file_name(format!("{}.csv", name_of(&program)));
        std::fs::write(&capture, capture_text(&offs)).expect("written");
        import.arg(capture);
        seen.push((name_of(&program), spread_um(&offs), spread_um(&ideal)));
    }
    let imported = first.join("imported");
    run(import.arg("--session").arg(plan.join("session.yaml")).args(["--force", "--out"]).arg(&imported));
    let found = identified(&imported.join("session.yaml"), &first.join("fitted"));
    table(&session.machine, &truth, &found);
    let (corrected, second) = (folder.join("corrected"), folder.join("after"));
    [&corrected, &second].iter().for_each(|folder| std::fs::create_dir_all(folder).expect("folder"));
    println!("{:<16} {:>8} {:>8} {:>24}", "readings, µm rms", "before", "after", "machine without errors");
    for (program, (name, before, ideal)) in programs(&plan.join("programs")).iter().zip(&seen) {
        let out = corrected.join(format!("{name}.ngc"));
        run(Command::new(fiveaxis())
            .arg("compensate")
            .arg(program)
            .arg(plan.join("machine.yaml"))
            .arg("--errors")
            .arg(first.join("fitted/machine.yaml"))
            .args(["--initial", "G54", "--offset", "G54:", "--force", "--out"])
            .arg(&out));
        let trace = traced(&control, &out, &second);
        let after = readings(&truth, true, test_of(&session, program), &trace, &mut balls, &mut random);
        std::fs::write(trace.with_file_name(format!("{name}.csv")), capture_text(&after)).expect("written");
        println!("{name:<16} {before:>8.2} {:>8.2} {ideal:>24.2}", spread_um(&after));
    }
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

fn name_of(program: &Path) -> String {
    program.file_stem().expect("name").to_string_lossy().into_owned()
}

fn test_of<'s>(session: &'s Session, program: &Path) -> &'s Test {
    let name = format!("{}-ccw", name_of(program));
    session.tests.iter().find(|test| test.name == name).expect("the program's test")
}

/// Runs a program on the control, once.
fn traced(control: &Path, program: &Path, folder: &Path) -> PathBuf {
    let trace = folder.join(format!("{}-trace.csv", name_of(program)));
    if !trace.is_file() {
        run(Command::new(control).arg(program).arg(&trace).env("ROTARY", "AC").env("MOST_SECONDS", "400"));
    }
    trace
}

/// Fits a session: values and standard deviations by name; the fitted machine goes into a folder.
fn identified(session: &Path, folder: &Path) -> BTreeMap<String, (f64, f64)> {
    let text =
        run(Command::new(fiveaxis()).arg("identify").arg(session).args(["--json", "--force", "--save"]).arg(folder));
    let value: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    println!("residual {:.3} µm rms", value["rms_um"].as_f64().unwrap_or(f64::NAN));
    let errors = value["location_errors"].as_object().expect("errors");
    errors
        .iter()
        .map(|(name, error)| {
            let number = |key: &str| error[key].as_f64().unwrap_or(f64::NAN);
            (name.clone(), (number("value"), number("sigma")))
        })
        .collect()
}

/// Root mean square of readings about their mean, µm.
fn spread_um(offs: &[(f64, f64)]) -> f64 {
    let count = offs.len() as f64;
    let mean = offs.iter().map(|(_, off)| off).sum::<f64>() / count;
    1e3 * (offs.iter().map(|(_, off)| (off - mean).powi(2)).sum::<f64>() / count).sqrt()
}

/// As a gauge writes it.
fn capture_text(offs: &[(f64, f64)]) -> String {
    let mut text = format!("Ball bar recorder\nSample rate: {RATE} Hz\ntime_s;deviation_um\n");
    for (time, off) in offs {
        let _ = writeln!(text, "{time:.3};{:.2}", 1e3 * off);
    }
    text
}

/// Times and deviations from when the bar is mounted until it is taken off, s and mm.
fn readings(
    truth: &Machine,
    errs: bool,
    test: &Test,
    trace: &Path,
    balls: &mut BTreeMap<String, [f64; 3]>,
    random: &mut ChaCha8Rng,
) -> Vec<(f64, f64)> {
    let plain = Plain { machine: truth, errs, tip: [0.0; 3], axis: [0.0, 0.0, 1.0] };
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
    let begin = on.first().map_or(0.0, |(time, ..)| *time);
    on.iter().map(|(time, off, _)| (time - begin, off + noise.sample(random))).collect()
}

/// The truth beside what was found.
fn table(machine: &Machine, truth: &Machine, found: &BTreeMap<String, (f64, f64)>) {
    println!("{:<6} {:>9} {:>9} {:>7}", "error", "true", "found", "sigma");
    for slot in machine.slots() {
        let name = slot.to_string();
        let axis = machine.axis_index(&slot.axis).expect("axis");
        let real = slot.component.measure().to_output(truth.axes[axis].location_errors[slot.component.index()]);
        let Some((value, sigma)) = found.get(&name) else { continue };
        println!("{name:<6} {real:>9.2} {value:>9.2} {sigma:>7.2}");
    }
}
