//! Balls that were mounted anew where the session states one setup: for the runs one way, for every program, or for every run. Whether they were is for others to judge.

use super::ball_places::End;
use super::exchanged::repeats;
use super::foreign::FOREIGN_MM;
use super::misplaced::names;
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::preflight::data_fault::listed;
use crate::diagnose::preflight::suspicion::{Detail, Suspicion};
use crate::session::{Session, Setups};

/// What readings tell of a place, mm, and of how many of its coordinates: those in which bars looked from it.
const TOLD_MM: f64 = 1e-4;
const COORDINATES_TOLD: f64 = 2.0;

/// One ball mounted anew for the tests of one way, `one_way`, for every program of the session, or for every run.
pub(crate) fn mounted_anew(session: &Session, one_way: &[Vec<usize>]) -> Vec<Suspicion> {
    let mut list = Vec::new();
    // as near to its place as stated, or anywhere that a cup is put
    let spreads = [None, Some(FOREIGN_MM)];
    // the first run of a program stands for it
    let firsts: Vec<usize> =
        (0..session.tests.len()).map(|test| repeats(session, test).first().copied().unwrap_or(test)).collect();
    for end in [End::Pivot, End::Spindle] {
        let ball = end.words();
        let mut add = |tests: &[usize], says: &str, way: &'static str, group: &dyn Fn(usize) -> usize| {
            let guesses = spreads.map(|spread| remounted(session, end, (tests, says, way), spread, group));
            list.extend(guesses.into_iter().flatten());
        };
        // the runs that rise: of those that fall the others are the ones mounted anew
        if let Some(tests) = one_way.first() {
            let says = format!(
                "the {ball} stood elsewhere in {}: it was mounted anew between the runs one way and back; state 'setup: second' of it there",
                listed(&names(session, tests))
            );
            add(tests, &says, "one way", &|test| usize::from(tests.contains(&test)));
        }
        let says = format!(
            "the {ball} stood elsewhere in every program: it was mounted anew for each; state a 'setup' of its own of it in each program"
        );
        add(&[], &says, "every program", &|test| firsts[test]);
        if (0..firsts.len()).all(|test| firsts[test] == test) {
            continue;
        }
        let turned = match end {
            End::Pivot => "it was mounted anew for each",
            End::Spindle => {
                "it was mounted anew for each, or the spindle was not locked and turned between them: lock it"
            }
        };
        let says = format!(
            "the {ball} stood elsewhere in every run: {turned}; record the runs anew, or state a 'setup' of its own of it in each"
        );
        add(&[], &says, "every run", &|test| test);
    }
    list
}

/// The session with the ball of one end mounted anew for each group of tests; `None` where no two groups share one.
fn remounted(
    session: &Session,
    end: End,
    (tests, says, way): (&[usize], &str, &'static str),
    spread_mm: Option<f64>,
    group: impl Fn(usize) -> usize,
) -> Option<Suspicion> {
    let mut undone = session.clone();
    for (index, test) in undone.tests.iter_mut().enumerate() {
        let own = end.of(test).setup.as_deref().unwrap_or_default();
        let setup = format!("{own} mounted for {}", group(index));
        end.mount_anew(test, setup, spread_mm);
    }
    let setups = |session: &Session| {
        let setups = Setups::of(session);
        if end == End::Pivot { setups.pivots.len() } else { setups.spindle_balls.len() }
    };
    let more = setups(&undone).saturating_sub(setups(session));
    if more == 0 {
        return None;
    }
    let mut found = Suspicion::new(FaultKind::MountedAnew, end.place(), names(session, tests), says.into(), undone);
    // what a place may be over what readings tell of it, across the bar and along
    let stated_mm = if end == End::Pivot { session.spread.pivot_mm } else { session.spread.spindle_ball_mm };
    let room = (spread_mm.unwrap_or(stated_mm) / TOLD_MM).max(1.0).ln();
    found.log_figures = -COORDINATES_TOLD * room * more as f64;
    (found.detail, found.is_found) = (Detail::Way(way), spread_mm.is_some());
    Some(found)
}
