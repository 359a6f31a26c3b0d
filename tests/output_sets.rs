//! Results are written as whole sets: never mixed, never over inputs or files of others, whatever stops a run.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const MACHINE: &str =
    "name: mill\ncode: \"[wCAbYXZt]\"\naxes:\n  X: {range: [-300, 300]}\n  C: {errors: {EX0C: 20 um}}\n";

/// Name of a test, and of its file where it has one of its own.
type Named<'a> = (&'a str, Option<&'a str>);

/// A planned session of one test for each name.
fn session(tests: &[Named]) -> String {
    let test = |(name, recording): &Named| {
        let recording = recording.map(|file| format!("    recording: \"{file}\"\n")).unwrap_or_default();
        format!(
            "  - name: \"{name}\"\n{recording}    bar_length: 100\n    pivot: {{link: C, at: [0, 60, 0]}}\n    spindle_ball: {{link: Z, at: [0, 0, 0]}}\n    positions: {{X: 0, Y: 160, Z: 0, A: 0}}\n    sweep: {{axis: C, from: 0, to: 10, step: 0.5}}\n"
        )
    };
    // a sweep of ten degrees stays within the stroke
    format!("machine: machine.yaml\ntests:\n{}", tests.iter().map(test).collect::<String>())
}

/// A folder with a machine and a session.
fn folder_with(session: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("machine.yaml"), MACHINE).unwrap();
    fs::write(folder.path().join("session.yaml"), session).unwrap();
    folder
}

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fiveaxis"));
    command.current_dir(folder).args(arguments).stdout(Stdio::null()).stderr(Stdio::piped());
    command
}

/// Exit code and standard error.
fn run(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let output = command(folder, arguments).output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

fn succeed(folder: &Path, arguments: &[&str]) {
    assert_eq!(run(folder, arguments), (Some(0), String::new()), "{arguments:?}");
}

fn refused(folder: &Path, arguments: &[&str], message: &str) {
    let (code, error) = run(folder, arguments);
    assert_eq!(code, Some(2), "{arguments:?}: {error}");
    assert!(error.contains(message), "{error}");
}

/// Every file below a folder with its content, links by where they lead.
fn content(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(&next).unwrap() {
            let path = entry.unwrap().path();
            let found = path.symlink_metadata().unwrap();
            if found.is_dir() {
                folders.push(path);
            } else if found.is_symlink() {
                files.insert(path.clone(), fs::read_link(&path).unwrap().into_os_string().into_encoded_bytes());
            } else {
                files.insert(path.clone(), fs::read(&path).unwrap());
            }
        }
    }
    files.into_iter().map(|(path, bytes)| (path.strip_prefix(folder).unwrap().to_path_buf(), bytes)).collect()
}

/// Runs a command that is refused and changes nothing.
fn refused_unchanged(folder: &Path, arguments: &[&str], message: &str) {
    let before = content(folder);
    refused(folder, arguments, message);
    assert!(content(folder) == before, "{arguments:?} changed files");
}

#[test]
fn measured_files_are_not_overwritten() {
    let folder = folder_with(&session(&[("a", None)]));
    let home = folder.path();
    fs::write(home.join("a.csv"), "time_s,C_deg,length_mm\n0,0,100\n1,1,100\n").unwrap();
    fs::create_dir(home.join("out")).unwrap();
    fs::write(home.join("out/report.html"), "mine").unwrap();
    fs::write(home.join("out/session.yaml"), "mine").unwrap();
    let not_ours = "was not written by fiveaxis, or was changed since, and is not overwritten";
    refused_unchanged(home, &["simulate", "session.yaml", "--out", "."], not_ours);
    // a recording of our own is replaced, unless somebody changed it
    succeed(home, &["simulate", "session.yaml", "--out", "out"]);
    succeed(home, &["simulate", "session.yaml", "--out", "out", "--draw-setups"]);
    fs::write(home.join("out/a.csv"), "time_s,C_deg,length_mm\n0,0,100\n").unwrap();
    refused_unchanged(home, &["simulate", "session.yaml", "--out", "out"], not_ours);
    succeed(home, &["simulate", "session.yaml", "--out", "out", "--force"]);
    // the readings of one test for identify
    fs::write(home.join("measured.yaml"), session(&[("a", Some("out/a.csv"))])).unwrap();
    refused_unchanged(home, &["identify", "measured.yaml", "--save", "out"], not_ours);
    refused_unchanged(home, &["identify", "measured.yaml", "--report", "out"], not_ours);
    // two sets are written or neither
    refused_unchanged(home, &["identify", "measured.yaml", "--save", "new", "--report", "out"], not_ours);
    refused_unchanged(home, &["diagnose", "measured.yaml", "--save", "new", "--report", "out"], not_ours);
    succeed(home, &["identify", "measured.yaml", "--save", "both", "--report", "both"]);
    assert!(home.join("both/report.html").is_file() && home.join("both/session.yaml").is_file());
    succeed(home, &["identify", "measured.yaml", "--save", "both", "--report", "both", "--free", "EX0C"]);
    // an input never, whatever is asked for
    fs::write(home.join("own.yaml"), session(&[("a", Some("a.csv"))])).unwrap();
    refused_unchanged(home, &["simulate", "own.yaml", "--out", ".", "--force"], "is an input of this command");
}

#[test]
fn names_that_meet_are_refused() {
    let cases: [(&[Named], &str); 4] = [
        (&[("a", Some("b.csv")), ("b", None)], "two different files would be called b.csv"),
        (&[("a", Some("x")), ("b", Some("x/y.csv"))], "x would be a file and the folder of x/y.csv"),
        (&[("a", Some(".fiveaxis-files"))], "begins like files of this program itself"),
        (&[("a", Some("../a.csv"))], "leaves the session's folder"),
    ];
    for (tests, message) in cases {
        // at different positions, so that no two recordings are alike
        let text = session(tests).replacen("Y: 160", "Y: 160.001", 1);
        let folder = folder_with(&text);
        refused_unchanged(folder.path(), &["simulate", "session.yaml", "--out", "out"], message);
    }
    // a name that looks like a temporary one is a name like any other
    let folder = folder_with(&session(&[("a", Some("x.csv.part")), ("b", Some("x.csv")), ("c", Some("./y.csv"))]));
    succeed(folder.path(), &["simulate", "session.yaml", "--out", "out"]);
    let names: Vec<PathBuf> = content(&folder.path().join("out")).into_keys().collect();
    assert_eq!(names, [".fiveaxis-files", "x.csv", "x.csv.part", "y.csv"].map(PathBuf::from));
}

#[cfg(unix)]
#[test]
fn links_are_not_followed() {
    use std::os::unix::fs::symlink;
    let folder = folder_with(&session(&[("a", Some("x/a.csv")), ("b", None)]));
    let home = folder.path();
    fs::write(home.join("precious"), "mine").unwrap();
    fs::create_dir_all(home.join("elsewhere")).unwrap();
    fs::create_dir_all(home.join("out")).unwrap();
    // temporary names of old
    symlink(home.join("precious"), home.join("out/b.csv.part")).unwrap();
    succeed(home, &["simulate", "session.yaml", "--out", "out"]);
    fs::remove_file(home.join("out/b.csv")).unwrap();
    symlink(home.join("precious"), home.join("out/b.csv")).unwrap();
    refused_unchanged(home, &["simulate", "session.yaml", "--out", "out"], "was not written by fiveaxis");
    // replaced on request, not followed
    succeed(home, &["simulate", "session.yaml", "--out", "out", "--force"]);
    assert!(home.join("out/b.csv").symlink_metadata().unwrap().is_file());
    fs::remove_dir_all(home.join("out/x")).unwrap();
    symlink(home.join("elsewhere"), home.join("out/x")).unwrap();
    refused_unchanged(home, &["simulate", "session.yaml", "--out", "out", "--force"], "nothing is written through it");
    assert_eq!(fs::read(home.join("precious")).unwrap(), b"mine");
    assert_eq!(fs::read_dir(home.join("elsewhere")).unwrap().count(), 0);
    // a folder that the user names by a link is that folder
    symlink(home.join("elsewhere"), home.join("link")).unwrap();
    succeed(home, &["simulate", "session.yaml", "--out", "link"]);
    assert!(home.join("elsewhere/b.csv").is_file() && home.join("link").is_symlink());
}

#[test]
fn a_set_that_cannot_be_written_leaves_the_old_one() {
    let folder = folder_with(&session(&[("a", None), ("b", None)]));
    let home = folder.path();
    succeed(home, &["simulate", "session.yaml", "--out", "out"]);
    fs::remove_file(home.join("out/b.csv")).unwrap();
    fs::create_dir(home.join("out/b.csv")).unwrap();
    let arguments = ["simulate", "session.yaml", "--out", "out", "--draw-setups"];
    refused_unchanged(home, &arguments, "is a folder where a file is to be written");
    refused_unchanged(home, &["simulate", "session.yaml", "--out", "machine.yaml"], "is a file; name a folder");
}

/// Tests of a set that is written by runs that are killed or meet each other.
const MANY: usize = 40;

/// A session of many tests, in its folder.
fn many() -> tempfile::TempDir {
    let names: Vec<String> = (0..MANY).map(|k| format!("test-{k:02}")).collect();
    let tests: Vec<Named> = names.iter().map(|name| (name.as_str(), None)).collect();
    folder_with(&session(&tests))
}

fn simulate<'a>(out: &'a str, seed: &'a str) -> [&'a str; 7] {
    ["simulate", "session.yaml", "--out", out, "--draw-setups", "--seed", seed]
}

/// What a folder holds after one undisturbed run beside a file of the user, if there is one.
fn reference(home: &Path, seed: &str, users: Option<&str>) -> BTreeMap<PathBuf, Vec<u8>> {
    let out = format!("reference-{seed}");
    fs::create_dir(home.join(&out)).unwrap();
    if let Some(name) = users {
        fs::write(home.join(&out).join(name), "mine").unwrap();
    }
    succeed(home, &simulate(&out, seed));
    content(&home.join(out))
}

#[test]
fn a_killed_run_leaves_the_old_set_or_the_new_one() {
    let seed = 20_261_123;
    println!("seed {seed}");
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    // a folder that is the set's alone changes places as a whole; beside a file of the user the next reader or writer completes
    for users in [None, Some("notes.txt")] {
        let folder = many();
        let home = folder.path();
        let sets = ["1", "2"].map(|seed| reference(home, seed, users));
        let out = home.join("out");
        fs::create_dir(&out).unwrap();
        users.iter().for_each(|name| fs::write(out.join(name), "mine").unwrap());
        succeed(home, &simulate("out", "1"));
        let begun = Instant::now();
        succeed(home, &simulate("out", "2"));
        let whole = begun.elapsed();
        let (mut killed, mut there) = (0, [0, 0]);
        for round in 0..25 {
            let mut child = command(home, &simulate("out", ["1", "2"][round % 2])).spawn().unwrap();
            std::thread::sleep(whole.mul_f64(random.random_range(0.1..1.1)));
            child.kill().unwrap();
            killed += usize::from(!child.wait().unwrap().success());
            if users.is_some() {
                // reading from the folder completes what is in its place in part
                fs::copy(home.join("machine.yaml"), home.join("m.yaml")).unwrap();
                let _ = run(home, &["check", "out/none.yaml"]);
            }
            let mut found = content(&out);
            found.retain(|name, _| !name.to_string_lossy().starts_with(".fiveaxis-part-"));
            let which = sets.iter().position(|set| *set == found);
            there[which.unwrap_or_else(|| panic!("round {round}: mixed: {:?}", found.keys()))] += 1;
        }
        println!("{killed} of 25 runs killed, sets there {there:?}");
        assert!(killed > 5, "{killed}");
        succeed(home, &simulate("out", "1"));
        assert!(content(&out) == sets[0], "{:?}", content(&out).keys());
        let mut names: Vec<_> = fs::read_dir(home).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        names.retain(|name| name.to_string_lossy().starts_with('.'));
        assert!(names.is_empty(), "left: {names:?}");
    }
}

#[test]
fn runs_that_write_at_once_do_not_mix() {
    for users in [None, Some("notes.txt")] {
        let folder = many();
        let home = folder.path();
        let sets = ["1", "2"].map(|seed| reference(home, seed, users));
        fs::create_dir(home.join("out")).unwrap();
        users.iter().for_each(|name| fs::write(home.join("out").join(name), "mine").unwrap());
        for _ in 0..10 {
            let pair = ["1", "2"].map(|seed| command(home, &simulate("out", seed)).spawn().unwrap());
            for child in pair {
                let output = child.wait_with_output().unwrap();
                assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            }
            let found = content(&home.join("out"));
            assert!(sets.contains(&found), "mixed: {:?}", found.keys());
        }
    }
}
