//! Places simulated captures and prints each with its error and its stated uncertainty; then captures that are to be refused.
//!
//! `FIVEAXIS_CAPTURES=200 cargo run --release --example import_trial`; 24 unless given.

#[path = "../../tests/captured/mod.rs"]
mod captured;

use captured::{Kind, drawn, off, planned};
use fiveaxis::import::{Feeds, pairs, place};

fn count() -> usize {
    std::env::var("FIVEAXIS_CAPTURES").map_or(24, |count| count.parse().expect("a number of captures"))
}

fn simulated_captures_are_placed() {
    let session = planned();
    let all = pairs(&session);
    let (mut placed, mut good, mut misplaced) = (0, 0, 0);
    let count = count();
    for seed in 0..count as u64 {
        let drawn = drawn(&session, &all, seed, Kind::Sound);
        let begun = std::time::Instant::now();
        match place(&session, &[all[drawn.pair]], &drawn.capture, Feeds::Programmed) {
            Ok(placement) => {
                let off = off(&drawn, &placement);
                let limit = f64::max(0.05, 3.0 * placement.position_sigma);
                placed += 1;
                good += usize::from(off < limit);
                misplaced += usize::from(off > f64::max(0.25, 6.0 * placement.position_sigma));
                println!(
                    "{seed}: {} off {off:.4} sigma {:.4} left {:.2} um noise {:.2} odds {:.1} pace {:.4} ({:.4}) {:.1} s {}",
                    drawn.says,
                    placement.position_sigma,
                    1e3 * placement.left_mm,
                    1e3 * placement.noise_mm,
                    placement.odds_place,
                    placement.timing.pace,
                    drawn.pace,
                    begun.elapsed().as_secs_f64(),
                    if off < limit { "" } else { "<<<<" }
                );
            }
            Err(why) => println!("{seed}: {} REFUSED {why} {:.1} s", drawn.says, begun.elapsed().as_secs_f64()),
        }
    }
    println!("{placed} of {count} placed, {good} within the limit, {misplaced} misplaced");
}

fn what_cannot_be_placed_is_refused() {
    let session = planned();
    let all = pairs(&session);
    for seed in 0..(count() as u64).div_ceil(3) {
        for kind in [Kind::CutAtStart, Kind::CutAtEnd, Kind::BarOff, Kind::Standing] {
            let drawn = drawn(&session, &all, 1000 + seed, kind);
            let found = place(&session, &[all[drawn.pair]], &drawn.capture, Feeds::Programmed);
            println!(
                "{seed} {kind:?} {}: {}",
                drawn.says,
                match &found {
                    Ok(p) => format!("PLACED off {:.3} sigma {:.3} <<<<", off(&drawn, p), p.position_sigma),
                    Err(why) => why.to_string(),
                }
            );
        }
        // another program's capture
        let drawn = drawn(&session, &all, 2000 + seed, Kind::Sound);
        let other = all[(drawn.pair + 1) % all.len()];
        let found = place(&session, &[other], &drawn.capture, Feeds::Programmed);
        println!(
            "{seed} other program {} as {}: {}",
            drawn.says,
            session.tests[other.tests[0]].name,
            match &found {
                Ok(p) => format!(
                    "PLACED sigma {:.3} left {:.2} pace {:.3} <<<<",
                    p.position_sigma,
                    1e3 * p.left_mm,
                    p.timing.pace
                ),
                Err(why) => why.to_string(),
            }
        );
        // told apart from the right one
        let both = place(&session, &[other, all[drawn.pair]], &drawn.capture, Feeds::Programmed);
        println!(
            "   among both: {}",
            match &both {
                Ok(p) => format!("{} odds {:.1}", session.tests[p.pair.tests[0]].name, p.odds_tests),
                Err(why) => why.to_string(),
            }
        );
    }
}

fn main() {
    simulated_captures_are_placed();
    what_cannot_be_placed_is_refused();
}
