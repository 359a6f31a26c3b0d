//! How often the truth lies within the stated sigmas when the linear axes err, on two designs and for four kinds of errors:
//! `cargo run --release --example linear_axes -- 500`.

#[path = "../tests/erring/mod.rs"]
mod erring;
#[path = "../tests/recorded/mod.rs"]
mod recorded;

use erring::{Form, coverage, table, table_head, table_table};

/// Sessions of each design and kind unless the command says otherwise.
const SESSIONS: u64 = 500;
/// Rows of a sweep.
const ROWS: usize = 120;

fn main() {
    let sessions = std::env::args().nth(1).and_then(|count| count.parse().ok()).unwrap_or(SESSIONS).max(1);
    println!(
        "{sessions} sessions each, seeds 0 to {}; the machine files state nothing: 5 µm/m, 10 µrad\n",
        sessions - 1
    );
    for (design, session) in [("table-table, chapter 5", table_table(ROWS)), ("table-head, planned", table_head(ROWS))]
    {
        for form in [Form::Waves, Form::PlainWaves, Form::ScaleAndBow, Form::Exact] {
            println!("{design}; linear axes: {form:?}\n{}", table(&coverage(&session, form, 0..sessions)));
        }
    }
}
