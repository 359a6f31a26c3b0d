//! The thesis's three methods disagree on orientation errors: which physics that they leave out can do it, and does `diagnose` find it?
//!
//! `cargo run --release --example thesis_mismatch` simulates the three designs with the same machine, one cause at a
//! time, and prints the disagreement and what the diagnosis says. What the published numbers themselves support, `fiveaxis
//! reconcile` tells.

mod causes;
mod designs;
mod outcome;

use std::error::Error;

use fiveaxis::units::{ARCSEC_PER_RAD, UM_PER_MM};

use causes::{CAUSES, LeftOut};
use designs::{Design, INSERTED};
use outcome::{ByMethod, Named, ORIENTATIONS, Outcome, by_method, outcomes, shown};

/// Lever arms over which the methods turn a difference of two centres into an angle, mm: chapters 4 and 5 both axes,
/// chapter 6 A and C.
const ARMS_MM: [f64; 3] = [111.803_399, 550.0, 78.0];

/// One cause in the three designs and in the extension that can show it.
struct Row {
    cause: LeftOut,
    /// In the order of [`ORIENTATIONS`].
    errors: [ByMethod; 4],
    /// Chapters 4, 5, 6.
    outcomes: Vec<Outcome>,
    /// What the session added, and what came of it.
    extension: Option<(&'static str, Outcome)>,
}

impl Row {
    /// The orientation error on which the methods differ most.
    fn worst(&self) -> (&'static str, &ByMethod) {
        let mut worst = 0;
        for k in 1..ORIENTATIONS.len() {
            if self.errors[k].spread() > self.errors[worst].spread() {
                worst = k;
            }
        }
        (ORIENTATIONS[worst], &self.errors[worst])
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let designs = designs::designs()?;
    let mut rows = Vec::new();
    for (index, cause) in CAUSES.iter().enumerate() {
        rows.push(row(&designs, cause, causes::seed_of(index))?);
    }
    print_levers();
    print_disagreement(&rows);
    print_outcomes(&rows);
    Ok(())
}

fn print_levers() {
    println!("One machine, three methods. Inserted in all three designs:");
    let unit = |name: &str| if ORIENTATIONS.contains(&name) { "″" } else { " µm" };
    let list: Vec<String> = INSERTED.iter().map(|(name, size)| format!("{name} {size}{}", unit(name))).collect();
    println!("  {}\n", list.join(", "));
    println!("Lever arms: arcsec that one µm between the two circles of an axis makes");
    for (words, arm_mm) in ["chapters 4 and 5, A and C", "chapter 6, A", "chapter 6, C"].iter().zip(ARMS_MM) {
        let per_um = ARCSEC_PER_RAD / arm_mm / UM_PER_MM;
        println!("  {words:<26} {arm_mm:6.1} mm  {per_um:.2}″ per µm; 5 µm make {:.1}″", 5.0 * per_um);
    }
}

fn print_disagreement(rows: &[Row]) {
    println!(
        "\nLargest difference between two of the three methods, arcsec (in standard deviations of that difference)"
    );
    print!("{:<46}{:>9}", "left out", "size");
    ORIENTATIONS.iter().for_each(|name| print!("{name:>14}"));
    println!("{:>15}", "″ per unit");
    for row in rows {
        print!("{:<46}{:>9}", row.cause.name, size(row));
        for by in &row.errors {
            print!("{:>14}", format!("{:.2} ({:.0})", by.spread(), by.in_sigmas()));
        }
        let per =
            if row.cause.size > 0.0 { format!("{:.2}", row.worst().1.spread() / row.cause.size) } else { "–".into() };
        println!("{per:>15}");
    }
}

fn print_outcomes(rows: &[Row]) {
    println!("\nWhat diagnose says of each session");
    println!("{:<46}{:<24}{:<24}{:<24}once the design can show it", "left out", "chapter 4", "chapter 5", "chapter 6");
    let mut defects = Vec::new();
    for row in rows {
        print!("{:<46}", row.cause.name);
        for (outcome, chapter) in row.outcomes.iter().zip([4, 5, 6]) {
            print!("{:<24}", words(outcome, row.cause.unit));
            if let Outcome::Neither(what) = outcome {
                defects.push(format!("{}, chapter {chapter}: {what}", row.cause.name));
            }
        }
        match &row.extension {
            None => println!("–"),
            Some((session, outcome)) => {
                println!("{}; {session}", words(outcome, row.cause.unit));
                if !matches!(outcome, Outcome::Found { .. }) {
                    defects.push(format!("{}, {session}: {outcome:?}", row.cause.name));
                }
            }
        }
    }
    println!("\nNeither found nor listed as out of sight, or not found where the design should show it:");
    if defects.is_empty() {
        println!("  none");
    }
    defects.iter().for_each(|defect| println!("  {defect}"));
}

fn size(row: &Row) -> String {
    match (row.cause.size > 0.0, row.cause.unit) {
        (false, _) => "–".into(),
        (true, "um") => format!("{} µm", row.cause.size),
        (true, _) => format!("{}″", row.cause.size),
    }
}

fn words(outcome: &Outcome, unit: &str) -> String {
    let unit = if unit == "um" { " µm" } else { "″" };
    match outcome {
        Outcome::Found { how: Named::Exactly, probability } => format!("found ({probability:.2})"),
        Outcome::Found { how: Named::AsRival, probability } => format!("among rivals ({probability:.2})"),
        Outcome::Found { how: Named::AsSagOrErrorMotion, probability } => format!("place found ({probability:.2})"),
        Outcome::Found { how: Named::AsSagOfCarried, probability } => format!("named at C ({probability:.2})"),
        Outcome::Blind(Some(smallest)) => format!("blind below {smallest:.0}{unit}"),
        Outcome::Blind(None) => "blind at any size".into(),
        Outcome::Clean => "clean".into(),
        Outcome::Neither(_) => "NEITHER".into(),
    }
}

/// Simulates, estimates and diagnoses one cause.
fn row(designs: &[Design], cause: &LeftOut, seed: u64) -> Result<Row, Box<dyn Error>> {
    let errors = by_method(designs, cause, seed)?;
    Ok(Row {
        cause: *cause,
        errors,
        outcomes: outcomes(designs, cause, seed)?,
        extension: shown(designs, cause, seed)?,
    })
}
