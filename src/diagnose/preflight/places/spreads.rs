//! Spreads of balls and bars that are stated a thousand times too small. Whether they are is for others to judge.

use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::preflight::data_fault::SESSION;
use crate::diagnose::preflight::suspicion::{Detail, Suspicion};
use crate::session::{Session, Spread, Test};

/// Millimetres that were written as micrometres, or micrometres as nanometres.
const TOO_SMALL: f64 = 1e3;

/// Spreads as they are stated, at most, mm: cups are set to some tenths, bars are calibrated to some hundredths.
const MOST_OF_BALLS_MM: f64 = 1.0;
const MOST_OF_BARS_MM: f64 = 0.05;

/// What has a spread.
struct Stated {
    name: &'static str,
    most_mm: f64,
    of: fn(&mut Spread) -> &mut f64,
    /// The spread that a test states for its own.
    own: fn(&mut Test) -> Option<&mut f64>,
}

const STATED: [Stated; 3] = [
    Stated {
        name: "pivot",
        most_mm: MOST_OF_BALLS_MM,
        of: |spread| &mut spread.pivot_mm,
        own: |test| test.pivot.spread_mm.as_mut(),
    },
    Stated {
        name: "spindle_ball",
        most_mm: MOST_OF_BALLS_MM,
        of: |spread| &mut spread.spindle_ball_mm,
        own: |test| test.spindle_ball.spread_mm.as_mut(),
    },
    Stated { name: "bar_length", most_mm: MOST_OF_BARS_MM, of: |spread| &mut spread.bar_length_mm, own: |_| None },
];

/// The session with some of its spreads a thousand times as wide, where those are such as are stated.
pub(crate) fn stated_too_small(session: &Session) -> Vec<Suspicion> {
    let groups = (1..1 << STATED.len()).map(|members: usize| {
        let is_member = |(k, _): &(usize, &Stated)| members >> k & 1 == 1;
        STATED.iter().enumerate().filter(is_member).map(|(_, stated)| stated).collect::<Vec<_>>()
    });
    groups.filter_map(|group| widened(session, &group)).collect()
}

fn widened(session: &Session, group: &[&Stated]) -> Option<Suspicion> {
    let mut undone = session.clone();
    let mut words = Vec::new();
    for stated in group {
        let spread_mm = (stated.of)(&mut undone.spread);
        *spread_mm *= TOO_SMALL;
        words.push(format!("{}: {} um", stated.name, (1e6 * *spread_mm).round() / 1e3));
        let mut widest_mm = *spread_mm;
        for own_mm in undone.tests.iter_mut().filter_map(stated.own) {
            *own_mm *= TOO_SMALL;
            widest_mm = widest_mm.max(*own_mm);
        }
        if widest_mm > stated.most_mm {
            return None;
        }
    }
    let words = words.join(", ");
    let says = format!(
        "spreads are stated a thousand times too small: the readings fit with 'spread: {{{words}}}'; state the unit that is meant"
    );
    let found = Suspicion::new(FaultKind::Unit, SESSION, Vec::new(), says, undone);
    Some(Suspicion { components: vec!["spread".into()], detail: Detail::Way("spread"), ..found })
}
