//! `init`: a data sheet becomes a machine file that loads, stands clear and plans; what a sheet cannot say is refused in words.

use std::path::Path;
use std::process::{Command, Output};

use fiveaxis::chain::Chain;
use fiveaxis::collision::World;
use fiveaxis::load::{load_kit, load_machine_and_bodies};
use fiveaxis::machine::AxisKind;
use fiveaxis::plan::{Settings, plan};

fn init(folder: &Path, options: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_fiveaxis"))
        .current_dir(folder)
        .args(["init", "mill.yaml"])
        .args(options)
        .output()
        .expect("the program runs")
}

/// Table 1.1's codes and those of Fig. 1.1, with the C600U's.
const CODES: [&str; 14] = [
    "[wCAXYbZt]",
    "[wCBXYbZt]",
    "[wCAYXbZt]",
    "[wCBYXbZt]",
    "[wCXYbZAt]",
    "[wCXYbZBt]",
    "[wXYbZCAt]",
    "[wXYbZCBt]",
    "[wXYbZABt]",
    "[wXYbZBAt]",
    "[wXbYZCBt]",
    "[wCXbYZAt]",
    "[wCAYbXZt]",
    "[wCAbYXZt]",
];

fn options(code: &str) -> Vec<String> {
    let mut list: Vec<String> = [
        "--travels",
        "650,520,475",
        "--nose-to-table",
        "120..595",
        "--table",
        "400",
        "--directions",
        "iso841",
        "--code",
        code,
    ]
    .map(str::to_string)
    .to_vec();
    let (table, head) = code.split_once('b').expect("a bed");
    if table.contains(['A', 'B']) {
        list.extend(["--tilt-above-table".into(), "-60".into()]);
    }
    if head.contains(['A', 'B']) {
        list.extend(["--pivot-to-nose".into(), "220".into()]);
    }
    list
}

#[test]
fn every_code_gives_a_file_that_loads_and_whose_bodies_stand_clear_at_zero() {
    for code in CODES {
        let scratch = tempfile::tempdir().expect("a folder");
        let given = options(code);
        let words: Vec<&str> = given.iter().map(String::as_str).collect();
        let output = init(scratch.path(), &words);
        assert!(output.status.success(), "{code}: {}", String::from_utf8_lossy(&output.stderr));
        let (machine, bodies) = load_machine_and_bodies(&scratch.path().join("mill.yaml")).expect(code);
        assert_eq!(machine.code.to_string(), code);
        let world = World::new(&Chain::of(&machine), &bodies).expect(code);
        assert_eq!(world.meetings_at_zero(&machine), vec![], "{code}");
        // nose to table as the sheet says, at both ends of Z's travel
        let table = bodies.mounts[0].middle.z;
        let z = &machine.axes[machine.axis_index("Z").expect("Z")];
        let (low, high) = z.range.expect("a range");
        let nose = bodies.spindle.as_ref().expect("a spindle").nose.z;
        assert!((nose - table + low - 120.0).abs() < 1e-9 && (nose - table + high - 595.0).abs() < 1e-9, "{code}");
        let tilting = machine.axes.iter().filter(|axis| axis.kind == AxisKind::Rotary && axis.name != "C");
        for axis in tilting {
            let is_on_table = machine.code.workpiece_side.contains(&axis.name);
            let height = if is_on_table { axis.origin.z - table } else { axis.origin.z - nose };
            assert!((height - if is_on_table { -60.0 } else { 220.0 }).abs() < 1e-9, "{code}");
        }
    }
}

#[test]
fn a_trunnion_mill_from_its_sheet_is_planned_with_all_eight_errors() {
    let scratch = tempfile::tempdir().expect("a folder");
    let given = options("[wCAXbYZt]");
    let words: Vec<&str> = given.iter().map(String::as_str).collect();
    assert!(init(scratch.path(), &words).status.success());
    let (machine, bodies) = load_machine_and_bodies(&scratch.path().join("mill.yaml")).expect("it loads");
    let kit = load_kit(&Path::new(env!("CARGO_MANIFEST_DIR")).join("kits/ballbar.yaml")).expect("the kit");
    let found = plan(&machine, &bodies, &kit, &Settings::default()).expect("a plan");
    assert_eq!(found.errors.iter().filter(|error| error.determined).count(), 8);
}

#[test]
fn what_a_sheet_cannot_say_is_refused_and_writes_nothing() {
    let good = ["--travels", "650,520,475", "--nose-to-table", "110..585", "--table", "320", "--directions", "iso841"];
    for (extra, says) in [
        (vec!["--code", "[wCAXbYZt]"], "--tilt-above-table is missing"),
        (vec!["--code", "[wXbYZCBt]"], "--pivot-to-nose is missing"),
        (vec!["--code", "[wCAXbYt]", "--tilt-above-table", "0"], "X, Y, Z and two of A, B, C"),
        (vec!["--code", "[wQAXbYt]"], "no axis"),
        (vec!["--code", "[wCAXbYZt]", "--tilt-above-table", "0", "--range", "B=-1..1"], "has no axis 'B'"),
        (vec!["--code", "[wCAXbYZt]", "--tilt-above-table", "0", "--range", "A=30..-120"], "runs backwards"),
        (vec!["--code", "[wCAXbYZt]", "--tilt-above-table", "nan"], "tilting axis above the table"),
    ] {
        let scratch = tempfile::tempdir().expect("a folder");
        let output = init(scratch.path(), &[&good[..], &extra].concat());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{extra:?}: {message}");
        assert!(message.contains(says), "{extra:?}: {message}");
        assert!(!scratch.path().join("mill.yaml").exists());
    }
    let scratch = tempfile::tempdir().expect("a folder");
    let wrong = ["--travels", "650,520,600", "--nose-to-table", "110..585", "--table", "320", "--directions", "iso841"];
    let output = init(scratch.path(), &[&wrong[..], &["--code", "[wXbYZCBt]", "--pivot-to-nose", "200"]].concat());
    assert!(String::from_utf8_lossy(&output.stderr).contains("which is a travel of 475 mm"));
}

#[test]
fn a_file_that_someone_wrote_is_kept() {
    let scratch = tempfile::tempdir().expect("a folder");
    std::fs::write(scratch.path().join("mill.yaml"), "mine").expect("written");
    let given = options("[wCAXbYZt]");
    let words: Vec<&str> = given.iter().map(String::as_str).collect();
    assert_eq!(init(scratch.path(), &words).status.code(), Some(2));
    assert_eq!(std::fs::read_to_string(scratch.path().join("mill.yaml")).expect("still there"), "mine");
}
