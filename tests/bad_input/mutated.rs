//! Shipped files with bytes changed, lines doubled and numbers made huge: every reader takes or refuses them, soon and in words.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use fiveaxis::load::printable::escaped_lines;
use fiveaxis::load::{load_instrument, load_kit, load_machine_and_bodies, load_session, load_shard};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{MACHINE, folder_with, run};

/// Longest time of reading a file of usual size, in an unoptimised program on a busy machine.
const SOON: Duration = Duration::from_secs(30);
/// Words that readers could trip over.
const HUGE: [&str; 10] =
    ["1e308", "-1e308", "1e999", "nan", "inf", "-0", "1e-320", "99999999999999999999", "0x10", "1_000"];

/// A file with a few changes drawn from the seed.
fn mutated(content: &[u8], seed: u64) -> Vec<u8> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut bytes = content.to_vec();
    for _ in 0..random.random_range(1..4) {
        if bytes.is_empty() {
            break;
        }
        let at = random.random_range(0..bytes.len());
        match random.random_range(0..6) {
            0 => bytes.truncate(at),
            1 => bytes[at] ^= 1 << random.random_range(0..8),
            2 => bytes[at] = random.random(),
            3 => {
                let lines: Vec<&[u8]> = bytes.split_inclusive(|&byte| byte == b'\n').collect();
                let doubled = random.random_range(0..lines.len());
                bytes =
                    lines.iter().enumerate().flat_map(|(k, line)| line.repeat(1 + usize::from(k == doubled))).collect();
            }
            4 => {
                // the number at or behind a place
                let is_number = |byte: &u8| byte.is_ascii_digit() || *byte == b'.';
                let Some(from) = bytes[at..].iter().position(is_number).map(|offset| at + offset) else { continue };
                let to =
                    bytes[from..].iter().position(|byte| !is_number(byte)).map_or(bytes.len(), |offset| from + offset);
                bytes.splice(from..to, HUGE[random.random_range(0..HUGE.len())].bytes());
            }
            _ => {
                let to = (at + random.random_range(1..40)).min(bytes.len());
                bytes.drain(at..to);
            }
        }
    }
    bytes
}

/// Reads `cases` mutations of a file in place, beside the files it names.
fn check(file: &Path, cases: u64, read: impl Fn(&Path) -> Result<(), String>) {
    let content = std::fs::read(file).unwrap();
    for seed in 0..cases {
        std::fs::write(file, mutated(&content, seed)).unwrap();
        let start = Instant::now();
        let outcome = read(file);
        let took = start.elapsed();
        let name = format!("{} with seed {seed}", file.display());
        assert!(took < SOON, "{name}: {took:?}");
        if let Err(message) = outcome {
            assert!(escaped_lines(&message) == message && message.len() < 10_000, "{name}: {message:?}");
            // a reader's own number that is none; "'NaN' is not a finite number" says what was found
            assert!(!message.replace("'NaN'", "").contains("NaN"), "{name}: {message}");
        }
    }
    std::fs::write(file, content).unwrap();
}

fn in_words<T, E: ToString>(outcome: Result<T, E>) -> Result<(), String> {
    outcome.map(drop).map_err(|why| why.to_string())
}

fn shipped(folder: &str) -> Vec<PathBuf> {
    let home = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let mut files: Vec<PathBuf> = std::fs::read_dir(home).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| file.is_file());
    files.sort();
    files
}

fn copied(files: &[PathBuf]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for file in files {
        // long recordings are cut: what is read is their form
        let content = std::fs::read(file).unwrap();
        let is_recording = file.extension().is_some_and(|ending| ending == "csv");
        let lines: Vec<&[u8]> = content.split_inclusive(|&byte| byte == b'\n').collect();
        let kept = if is_recording { lines.len().min(60) } else { lines.len() };
        std::fs::write(folder.path().join(file.file_name().unwrap()), lines[..kept].concat()).unwrap();
    }
    folder
}

#[test]
fn machines_and_kits() {
    let folder = copied(&shipped("machines"));
    for file in shipped("machines") {
        let file = folder.path().join(file.file_name().unwrap());
        check(&file, 40, |file| in_words(load_machine_and_bodies(file)));
    }
    let folder = copied(&shipped("kits"));
    check(&folder.path().join("ballbar.yaml"), 100, |file| in_words(load_kit(file)));
    let instrument = "name: bar\nresolution: 0.1 um\nstroke: [-1, 1]\nnoise: {white: 0.15 um, correlated: 0.15 um, correlation_time: 1.2, drift: 0.02 um}\n";
    let folder = folder_with(&[("instrument.yaml", instrument.as_bytes())]);
    check(&folder.path().join("instrument.yaml"), 100, |file| in_words(load_instrument(file)));
}

#[test]
fn meshes() {
    let whole = super::bodies::stl(50.0, 2, 4);
    let text = super::bodies::text_stl(50.0);
    let obj = "v 0 0 0\nv 50 0 0\nv 0 50 0\nv 0 0 50\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n";
    for (name, content) in [("a.stl", whole.as_slice()), ("b.stl", text.as_bytes()), ("c.obj", obj.as_bytes())] {
        let machine = format!("{MACHINE}bodies:\n  - {{name: part, link: b, mesh: {{file: {name}}}}}\n");
        let folder = folder_with(&[("machine.yaml", machine.as_bytes()), (name, content)]);
        let machine = folder.path().join("machine.yaml");
        check(&folder.path().join(name), 150, |_| in_words(load_machine_and_bodies(&machine)));
    }
}

#[test]
fn sessions_and_recordings() {
    for example in ["examples/gallery/03-lost-motion", "examples/thesis/chapter5"] {
        let files = shipped(example);
        let folder = copied(&files);
        let session = folder.path().join("session.yaml");
        check(&session, 60, |file| in_words(load_session(file)));
        let recording = files.iter().find(|file| file.extension().is_some_and(|ending| ending == "csv")).unwrap();
        check(&folder.path().join(recording.file_name().unwrap()), 60, |_| in_words(load_session(&session)));
    }
}

#[test]
fn shards_of_a_survey() {
    let shard = "# any; shard 1/2\ncode,family\n[wXYbZCAt],head-head,8,8,8,,5,1,20,1,1,8,20,yes,100\n";
    let folder = folder_with(&[("shard.csv", shard.as_bytes())]);
    check(&folder.path().join("shard.csv"), 200, |file| in_words(load_shard(file, "code,family")));
}

/// What a reader takes, the verbs take or refuse too.
#[test]
fn verbs_on_mutated_sessions() {
    let files = shipped("examples/gallery/03-lost-motion");
    let folder = copied(&files);
    let names = ["machine.yaml", "session.yaml", "xy-f500-cw.csv", "yz-f2000-ccw.csv"];
    for seed in 0..24u64 {
        let file = folder.path().join(names[seed as usize % names.len()]);
        let content = std::fs::read(&file).unwrap();
        std::fs::write(&file, mutated(&content, seed)).unwrap();
        for arguments in [&["check", "session.yaml"][..], &["identify", "session.yaml"]] {
            let (code, out, error) = run(folder.path(), arguments);
            assert!(matches!(code, Some(0 | 2)), "seed {seed}: {arguments:?} ends with {code:?}\n{error}");
            assert!(!out.contains("NaN") && !error.replace("'NaN'", "").contains("NaN"), "seed {seed}: {out}{error}");
        }
        std::fs::write(&file, content).unwrap();
    }
}
