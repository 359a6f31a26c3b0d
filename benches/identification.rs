//! Time of `identify` on the thesis's chapter 5, as the verb runs it, one thread: `RAYON_NUM_THREADS=1 cargo bench --bench identification`.

use std::path::Path;

use divan::{Bencher, black_box};
use fiveaxis::identify::{Options, identify};
use fiveaxis::load::load_session;

fn main() {
    divan::main();
}

const SESSION: &str = "examples/thesis/chapter5/session.yaml";

/// Machine, session and recordings.
#[divan::bench]
fn files_are_read(bencher: Bencher) {
    bencher.bench_local(|| load_session(Path::new(black_box(SESSION))).expect("a session"));
}

/// Eight location errors, balls, bars and the budget of the linear axes, with outliers and a noise model for each test.
#[divan::bench]
fn chapter5_is_identified(bencher: Bencher) {
    let session = load_session(Path::new(SESSION)).expect("a session");
    bencher.bench_local(|| identify(black_box(&session), &Options::default()).expect("a fit"));
}
