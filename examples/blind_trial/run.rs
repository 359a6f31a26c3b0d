//! Runs the built binary on sessions, several at a time; draws and scores nothing.

use super::score::Answer;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Does `work` for every item on so many threads; the first failure ends it.
pub fn each<I: Sync, T: Send>(
    threads: usize,
    items: &[I],
    work: impl Fn(&I) -> Result<T, String> + Sync,
) -> Result<Vec<T>, String> {
    let next = AtomicUsize::new(0);
    let done: Mutex<Vec<T>> = Mutex::new(vec![]);
    let trouble: Mutex<Option<String>> = Mutex::new(None);
    std::thread::scope(|scope| {
        for _ in 0..threads.max(1) {
            scope.spawn(|| {
                while let Some(item) = items.get(next.fetch_add(1, Ordering::Relaxed)) {
                    match work(item) {
                        Ok(value) => done.lock().unwrap_or_else(|e| e.into_inner()).push(value),
                        Err(message) => {
                            *trouble.lock().unwrap_or_else(|e| e.into_inner()) = Some(message);
                            next.store(items.len(), Ordering::Relaxed);
                        }
                    }
                }
            });
        }
    });
    match trouble.into_inner().unwrap_or_else(|e| e.into_inner()) {
        Some(message) => Err(message),
        None => Ok(done.into_inner().unwrap_or_else(|e| e.into_inner())),
    }
}

/// The crate's own binary, built as the user would, or another one.
pub fn own_binary(given: Option<&Path>) -> Result<PathBuf, String> {
    if let Some(path) = given {
        return if path.is_file() { Ok(path.to_path_buf()) } else { Err(format!("no binary at {}", path.display())) };
    }
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    let built = Command::new(cargo)
        .args(["build", "--release", "--quiet", "--bin", "fiveaxis", "--manifest-path"])
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"))
        .status();
    if !built.is_ok_and(|s| s.success()) {
        return Err("could not build the binary; build it and pass --binary PATH".into());
    }
    let own = std::env::current_exe().map_err(|e| e.to_string())?;
    let folder = own.parent().and_then(Path::parent).ok_or("no folder above this example")?;
    Ok(folder.join(format!("fiveaxis{}", std::env::consts::EXE_SUFFIX)))
}

/// Runs the binary on a folder alone, on one thread.
pub fn diagnose(binary: &Path, place: &Path, patience_s: u64) -> Answer {
    let start = Instant::now();
    let name = place.file_name().map_or(String::new(), |n| n.to_string_lossy().into_owned());
    let out = std::env::temp_dir().join(format!("blind-answer-{}-{name}.json", std::process::id()));
    let answer = |failed: String| Answer { json: None, failed: Some(failed), seconds: start.elapsed().as_secs_f64() };
    let Ok(file) = std::fs::File::create(&out) else {
        return answer(format!("cannot write {}", out.display()));
    };
    let child = Command::new(binary)
        .arg("diagnose")
        .arg(place.join("session.yaml"))
        .arg("--json")
        .env("RAYON_NUM_THREADS", "1")
        .stdout(file)
        .stderr(Stdio::null())
        .spawn();
    let mut child = match child {
        Ok(child) => child,
        Err(e) => return answer(format!("cannot start: {e}")),
    };
    let status = loop {
        match child.try_wait() {
            Ok(Some(status)) => break status,
            Ok(None) if start.elapsed() > Duration::from_secs(patience_s) => {
                let _ = child.kill();
                let _ = child.wait();
                return answer(format!("no answer in {patience_s} s"));
            }
            Ok(None) => std::thread::sleep(Duration::from_millis(5)),
            Err(e) => return answer(e.to_string()),
        }
    };
    let seconds = start.elapsed().as_secs_f64();
    let text = std::fs::read_to_string(&out).unwrap_or_default();
    let _ = std::fs::remove_file(&out);
    match serde_json::from_str::<serde_json::Value>(&text) {
        Ok(json) if json["findings"].is_array() => Answer { json: Some(json), failed: None, seconds },
        _ => Answer { json: None, failed: Some(format!("no findings on stdout, {status}")), seconds },
    }
}
