//! The tables of docs/survey.md from a survey's rows: `cargo run --release --example survey_tables -- survey/survey.csv`.

use std::collections::BTreeMap;
use std::process::ExitCode;

/// One topology, cells by column.
type Row = BTreeMap<String, String>;

/// Families in the order of the tables.
const FAMILIES: [&str; 3] = ["table-table", "table-head", "head-head"];

const COLUMNS: &str = "| topologies | errors that lengths show | all 8 determined | all visible determined | … from one pivot | \
                       8 from one pivot | minutes | worst position, µm | worst orientation, arcsec |\n|---|---|---|---|---|---|---|---|---|---|";

fn number(row: &Row, column: &str) -> Option<f64> {
    row.get(column).and_then(|cell| cell.parse().ok())
}

/// Errors that a row shows or determines, as a count.
fn count(row: &Row, column: &str) -> i64 {
    number(row, column).unwrap_or(0.0) as i64
}

/// Whether all that lengths show is determined, freely or from one pivot setup.
fn is_all(row: &Row, column: &str) -> bool {
    count(row, "visible") > 0 && count(row, column) >= count(row, "visible")
}

/// Order of translations (T) and rotations (R) from workpiece to tool, bed and ends left out.
fn order(code: &str) -> String {
    let letter = |c: char| match c {
        'X' | 'Y' | 'Z' => Some('T'),
        'A' | 'B' | 'C' => Some('R'),
        _ => None,
    };
    code.chars().filter_map(letter).collect()
}

fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut all: Vec<f64> = values.collect();
    all.sort_by(f64::total_cmp);
    all
}

/// Median and largest.
fn spread(values: impl Iterator<Item = f64>) -> String {
    let all = sorted(values);
    match (all.get(all.len() / 2), all.last()) {
        (Some(middle), Some(last)) => format!("{middle:.1} / {last:.1}"),
        _ => "–".into(),
    }
}

/// One line of a table.
fn line(title: &str, rows: &[&Row]) -> String {
    let of = |holds: &dyn Fn(&Row) -> bool| rows.iter().filter(|row| holds(row)).count();
    let visible = sorted(rows.iter().filter_map(|row| number(row, "visible")));
    let shown = match (visible.first(), visible.last()) {
        (Some(least), Some(most)) if least == most => format!("{least}"),
        (Some(least), Some(most)) => format!("{least}–{most}"),
        _ => "–".into(),
    };
    let eight = |column: &'static str| of(&|row: &Row| count(row, column) == 8);
    let minutes = rows.iter().filter(|row| is_all(row, "one_pivot_determined"));
    let minutes = sorted(minutes.filter_map(|row| number(row, "one_pivot_minutes")));
    let cells = [
        title.to_string(),
        rows.len().to_string(),
        shown,
        eight("determined").to_string(),
        of(&|row| is_all(row, "determined")).to_string(),
        of(&|row| is_all(row, "one_pivot_determined")).to_string(),
        eight("one_pivot_determined").to_string(),
        minutes.get(minutes.len() / 2).map_or("–".into(), |minutes| format!("{minutes:.0}")),
        spread(rows.iter().filter_map(|row| number(row, "worst_position_um"))),
        spread(rows.iter().filter_map(|row| number(row, "worst_orientation_arcsec"))),
    ];
    format!("| {} |", cells.join(" | "))
}

fn main() -> ExitCode {
    let Some(file) = std::env::args().nth(1) else {
        eprintln!("error: name a table of fiveaxis survey, e.g. survey/survey.csv");
        return ExitCode::from(2);
    };
    let text = match std::fs::read_to_string(&file) {
        Ok(text) => text,
        Err(why) => {
            eprintln!("error: {file}: {why}");
            return ExitCode::from(2);
        }
    };
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let rows: Vec<Row> = lines
        .map(|line| head.iter().map(|name| (*name).to_string()).zip(line.split(',').map(str::to_string)).collect())
        .collect();
    let family = |row: &Row| row.get("family").cloned().unwrap_or_default();
    let code = |row: &Row| row.get("code").cloned().unwrap_or_default();
    println!("| {COLUMNS}");
    for name in FAMILIES {
        let of: Vec<&Row> = rows.iter().filter(|row| family(row) == name).collect();
        println!("{}", line(name, &of));
    }
    println!("{}\n\n| from workpiece to tool {COLUMNS}", line("all", &rows.iter().collect::<Vec<_>>()));
    let mut groups: BTreeMap<(String, usize), Vec<&Row>> = BTreeMap::new();
    for row in &rows {
        let place = FAMILIES.iter().position(|name| *name == family(row)).unwrap_or(FAMILIES.len());
        groups.entry((order(&code(row)), place)).or_default().push(row);
    }
    for ((order, place), of) in &groups {
        println!("{}", line(&format!("{order}, {}", FAMILIES.get(*place).unwrap_or(&"?")), of));
    }
    println!();
    let heads = |row: &&Row| family(row) != "table-table";
    println!(
        "with a head: {}, showing five: {}",
        rows.iter().filter(heads).count(),
        rows.iter().filter(heads).filter(|row| count(row, "visible") == 5).count()
    );
    let short = |name: &str| {
        rows.iter().filter(|row| family(row) == name && count(row, "visible") > 0 && !is_all(row, "determined")).count()
    };
    println!("left short by family: {:?}", FAMILIES.map(short));
    let nothing: Vec<String> = rows.iter().filter(|row| count(row, "visible") == 0).map(code).collect();
    println!("show nothing: {} {:?}", nothing.len(), &nothing[..nothing.len().min(4)]);
    let several = |row: &&Row| count(row, "determined") > count(row, "one_pivot_determined");
    println!("more from several pivots: {}", rows.iter().filter(several).count());
    let only_several = |row: &&Row| count(row, "determined") == 8 && count(row, "one_pivot_determined") < 8;
    println!("all eight from several pivots only: {}", rows.iter().filter(only_several).count());
    let above =
        |column: &'static str| rows.iter().filter(move |row| number(row, column).is_some_and(|value| value > 4.0));
    println!(
        "above 4 um: {}, above 4 arcsec: {}",
        above("worst_position_um").count(),
        above("worst_orientation_arcsec").count()
    );
    let reached = |row: &&Row| {
        ["worst_position_um", "worst_orientation_arcsec"]
            .iter()
            .all(|column| number(row, column).is_none_or(|value| value <= 4.0))
            && count(row, "tests") > 0
    };
    println!("within 4 um and 4 arcsec: {}", rows.iter().filter(reached).count());
    for column in ["worst_position_um", "worst_orientation_arcsec"] {
        let mut worst: Vec<(f64, String)> =
            rows.iter().filter_map(|row| Some((number(row, column)?, code(row)))).collect();
        worst.sort_by(|a, b| b.0.total_cmp(&a.0));
        println!("largest {column}: {:?}", worst.iter().take(8).collect::<Vec<_>>());
    }
    let considered = sorted(rows.iter().filter_map(|row| number(row, "setups_considered")));
    println!("median setups considered: {:?}", considered.get(considered.len() / 2));
    ExitCode::SUCCESS
}
