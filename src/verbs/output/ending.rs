//! How a verb ends when it does not end well: exit codes, and a refusal as JSON. It prints nothing.

use std::fmt;
use std::path::{Path, PathBuf};

use fiveaxis::diagnose::Examination;
use fiveaxis::identify::FitError;
use fiveaxis::load::LoadError;
use serde_json::{Value, json};

use crate::verbs::Refusal;

/// Exit code of an alarm that `--fail-on` asked for.
const ALARM: u8 = 1;
/// Exit code of wrong input.
const WRONG_INPUT: u8 = 2;
/// Exit code of recordings that are not to be believed: a mistake in the files, or readings that cannot be judged.
const DATA_FAULT: u8 = 3;
/// Exit code of a fit that did not converge.
const NO_CONVERGENCE: u8 = 4;

/// An end with a code of its own.
#[derive(Debug)]
pub struct Ending {
    code: u8,
    says: String,
    /// The file that it is about.
    file: Option<PathBuf>,
    /// The result on standard output says it already.
    is_told: bool,
}

impl Ending {
    /// What `--fail-on` asked for is so; the result tells it.
    pub fn alarm() -> Refusal {
        Box::new(Ending { code: ALARM, says: String::new(), file: None, is_told: true })
    }

    /// No test of what is to be determined can be planned; the result says why, and is all that is said where it is JSON.
    pub fn without_plan(is_told: bool) -> Refusal {
        let says = "no test can be planned; the table says why".into();
        Box::new(Ending { code: WRONG_INPUT, says, file: None, is_told })
    }

    /// The recordings are not to be believed, as the result tells.
    pub fn unbelievable() -> Refusal {
        Box::new(Ending { code: DATA_FAULT, says: String::new(), file: None, is_told: true })
    }

    /// The recordings are not to be believed, and there is no result.
    pub fn data_fault(says: impl Into<String>) -> Refusal {
        Box::new(Ending { code: DATA_FAULT, says: says.into(), file: None, is_told: false })
    }

    /// The same of one file.
    pub fn data_fault_in(file: &Path, says: impl Into<String>) -> Refusal {
        Box::new(Ending { code: DATA_FAULT, says: says.into(), file: Some(file.to_path_buf()), is_told: false })
    }

    /// There is no fit.
    pub fn without_fit(examination: &Examination) -> Refusal {
        let code = if examination.fault.is_some() { DATA_FAULT } else { NO_CONVERGENCE };
        Box::new(Ending { code, says: examination.says().unwrap_or_default().into(), file: None, is_told: false })
    }
}

impl fmt::Display for Ending {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.file {
            Some(file) => write!(out, "{}: {}", file.display(), self.says),
            None => out.write_str(&self.says),
        }
    }
}

impl std::error::Error for Ending {}

/// Exit code of a refusal.
pub fn code_of(refusal: &Refusal) -> u8 {
    match (refusal.downcast_ref::<Ending>(), refusal.downcast_ref::<FitError>()) {
        (Some(ending), _) => ending.code,
        (None, Some(FitError::NoConvergence)) => NO_CONVERGENCE,
        (None, _) => WRONG_INPUT,
    }
}

/// True when standard output says already why.
pub fn is_told(refusal: &Refusal) -> bool {
    refusal.downcast_ref::<Ending>().is_some_and(|ending| ending.is_told)
}

/// Beginnings of lists of what is allowed, as messages write them.
const ALLOWED: [&str; 8] = [
    "(allowed: ",
    "(groups: ",
    "(links: ",
    "its axes are ",
    "allowed are ",
    "allowed is ",
    "[possible values: ",
    "is not between ",
];

/// A refusal as an object: kind, exit code, message with its parts, file and place; null where there is none.
pub fn refusal_json(refusal: &Refusal, warnings: Vec<String>) -> Value {
    let code = code_of(refusal);
    match (refusal.downcast_ref::<LoadError>(), refusal.downcast_ref::<Ending>()) {
        (Some(load), _) => error_json(code, &load.message, Place::of(load), warnings),
        (None, Some(ending)) => error_json(code, &ending.says, Place::file(ending.file.as_deref()), warnings),
        (None, None) => error_json(code, &refusal.to_string(), Place::file(None), warnings),
    }
}

/// A wrong command line as an object.
pub fn usage_json(message: &str) -> Value {
    let message = message.trim().trim_start_matches("error: ");
    let mut json = error_json(WRONG_INPUT, message, Place::file(None), Vec::new());
    // the first paragraph says what was found, a tip or the usage what to do
    let paragraph = |begins: &str| message.lines().map(str::trim).find(|line| line.starts_with(begins));
    let found = message.lines().take_while(|line| !line.trim().is_empty()).map(str::trim).collect::<Vec<_>>().join(" ");
    let cure = paragraph("tip:").or_else(|| paragraph("Usage:"));
    json["error"]["found"] = json!(found);
    json["error"]["cure"] = json!(cure);
    json
}

/// Where the mistake is.
struct Place<'a> {
    file: Option<&'a Path>,
    line: Option<usize>,
    column: Option<usize>,
}

impl<'a> Place<'a> {
    fn of(load: &'a LoadError) -> Place<'a> {
        Place { file: Some(&load.file), line: load.line, column: load.column }
    }

    fn file(file: Option<&'a Path>) -> Place<'a> {
        Place { file, line: None, column: None }
    }
}

fn error_json(code: u8, message: &str, place: Place, warnings: Vec<String>) -> Value {
    let kind = match code {
        DATA_FAULT => "data fault",
        NO_CONVERGENCE => "no convergence",
        _ => "wrong input",
    };
    let allowed = ALLOWED.iter().find_map(|begin| {
        let (_, rest) = message.split_once(begin)?;
        Some(rest.split([')', ';', ']', '\n']).next().unwrap_or(rest).trim())
    });
    let parts: Vec<&str> = message.split("; ").collect();
    let cure = parts.last().filter(|_| parts.len() > 1).map(|cure| cure.trim());
    json!({
        "error": {
            "kind": kind,
            "exit_code": code,
            "message": message,
            "file": place.file.map(|file| file.to_string_lossy()),
            "line": place.line,
            "column": place.column,
            "found": parts.first(),
            "allowed": allowed,
            "cure": cure,
        },
        "warnings": warnings,
    })
}
