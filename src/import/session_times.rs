//! When captures were recorded within their session, by what they state of it. It reads no dates.

/// What a capture states of its time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stated {
    /// First reading, s on a scale that the captures share; `None` where the file does not state it.
    pub began_s: Option<f64>,
    /// From the first reading to the last, s.
    pub lasts_s: f64,
}

/// What times count from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// From one day of all, s.
    Days,
    /// From midnight of a day that is not stated, s.
    OfDay,
}

/// When a session began, s on the scale of its captures; a time of day is the last such before the earliest capture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Began {
    pub seconds: f64,
    pub scale: Scale,
}

/// The times of captures in a session.
#[derive(Debug, Clone, PartialEq)]
pub enum SessionTimes {
    /// First readings since the session began, s, by capture.
    Stated(Vec<f64>),
    /// As planned.
    Planned(WhyPlanned),
}

/// Why the times of the plan are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WhyPlanned {
    /// No capture states when it was recorded.
    NoneStated,
    /// This capture states none, by number, others do.
    OneWithout(usize),
    /// Two captures were recorded at the same time by what they state: it is no time of theirs.
    Overlap(usize, usize),
    /// So much time lies between two captures that they are of two sessions.
    FarApart(usize, usize),
    /// This capture began before the session did.
    BeforeBegin(usize),
}

/// Time between two captures that is no pause of a session any more, s: a day.
const FAR_APART_S: f64 = DAY_S;
/// Captures may overlap by this, s: clocks that are written to a second, before or behind the bar's mounting.
const OVERLAP_S: f64 = 2.0;

/// To which times are written where seconds are not.
const MINUTE_S: f64 = 60.0;
/// Seconds of a day, after which a clock begins anew.
const DAY_S: f64 = 86400.0;

impl SessionTimes {
    /// Of captures that state their times, from the begin of the session on: a stated one, or that of the earliest capture. Times
    /// of day may have passed midnight.
    pub fn of(stated: &[Stated], began: Option<Began>, scale: Scale) -> SessionTimes {
        if stated.iter().all(|one| one.began_s.is_none()) {
            return SessionTimes::Planned(WhyPlanned::NoneStated);
        }
        if let Some(without) = stated.iter().position(|one| one.began_s.is_none()) {
            return SessionTimes::Planned(WhyPlanned::OneWithout(without));
        }
        let mut begins: Vec<f64> = stated.iter().filter_map(|one| one.began_s).collect();
        if scale == Scale::OfDay {
            over_midnight(&mut begins);
        }
        let mut order: Vec<usize> = (0..stated.len()).collect();
        order.sort_by(|&one, &other| begins[one].total_cmp(&begins[other]));
        let is_by_minutes = begins.iter().all(|begin| begin % MINUTE_S == 0.0);
        let overlap_s = OVERLAP_S + if is_by_minutes { MINUTE_S } else { 0.0 };
        for pair in order.windows(2) {
            let ended_s = begins[pair[0]] + stated[pair[0]].lasts_s;
            let pause_s = begins[pair[1]] - ended_s;
            if pause_s < -overlap_s {
                return SessionTimes::Planned(WhyPlanned::Overlap(pair[0], pair[1]));
            }
            if pause_s > FAR_APART_S {
                return SessionTimes::Planned(WhyPlanned::FarApart(pair[0], pair[1]));
            }
            // as far as it was written down
            begins[pair[1]] = begins[pair[1]].max(ended_s);
        }
        let earliest_s = begins[order[0]];
        let before_s = began.map_or(0.0, |began| match began.scale {
            Scale::OfDay => (earliest_s - began.seconds + OVERLAP_S).rem_euclid(DAY_S) - OVERLAP_S,
            Scale::Days => earliest_s - began.seconds,
        });
        // a session of more than half a day has begun after midnight, or its begin is a little late
        let is_before =
            before_s < -OVERLAP_S || began.is_some_and(|began| began.scale == Scale::OfDay) && before_s > 0.5 * DAY_S;
        if is_before {
            return SessionTimes::Planned(WhyPlanned::BeforeBegin(order[0]));
        }
        let began_s = earliest_s - before_s.max(0.0);
        SessionTimes::Stated(begins.iter().map(|begin| begin - began_s).collect())
    }
}

/// Times of day on one scale: the longest pause of the round of a day lies outside of the session.
fn over_midnight(begins: &mut [f64]) {
    let mut sorted = begins.to_vec();
    sorted.sort_by(f64::total_cmp);
    let next = |k: usize| sorted.get(k + 1).copied().unwrap_or(sorted[0] + DAY_S);
    let longest =
        (0..sorted.len()).max_by(|&one, &other| (next(one) - sorted[one]).total_cmp(&(next(other) - sorted[other])));
    let Some(last) = longest.map(|k| sorted[k]) else { return };
    // what lies at or before the pause is of the day after
    let is_split = begins.iter().any(|begin| *begin > last);
    begins.iter_mut().filter(|begin| is_split && **begin <= last).for_each(|begin| *begin += DAY_S);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn capture(began_s: f64) -> Stated {
        Stated { began_s: Some(began_s), lasts_s: 60.0 }
    }

    fn at(seconds: f64) -> Option<Began> {
        Some(Began { seconds, scale: Scale::Days })
    }

    fn of_day(seconds: f64) -> Option<Began> {
        Some(Began { seconds, scale: Scale::OfDay })
    }

    #[test]
    fn captures_count_from_the_earliest_or_from_when_the_session_began() {
        let captures = [capture(1000.0), capture(400.0)];
        assert_eq!(SessionTimes::of(&captures, None, Scale::Days), SessionTimes::Stated(vec![600.0, 0.0]));
        assert_eq!(SessionTimes::of(&captures, at(100.0), Scale::Days), SessionTimes::Stated(vec![900.0, 300.0]));
        // written to the second
        assert_eq!(SessionTimes::of(&captures, at(401.0), Scale::Days), SessionTimes::Stated(vec![600.0, 0.0]));
    }

    #[test]
    fn times_to_the_minute_may_overlap_by_one() {
        let long = |began_s| Stated { began_s: Some(began_s), lasts_s: 100.0 };
        assert_eq!(
            SessionTimes::of(&[long(600.0), long(660.0)], None, Scale::Days),
            SessionTimes::Stated(vec![0.0, 100.0])
        );
        let overlap = SessionTimes::of(&[long(601.0), long(660.0)], None, Scale::Days);
        assert_eq!(overlap, SessionTimes::Planned(WhyPlanned::Overlap(0, 1)));
    }

    #[test]
    fn a_clock_passes_midnight() {
        let captures = [capture(86300.0), capture(200.0), capture(500.0)];
        assert_eq!(SessionTimes::of(&captures, None, Scale::OfDay), SessionTimes::Stated(vec![0.0, 300.0, 600.0]));
        assert_eq!(
            SessionTimes::of(&captures[1..], of_day(86000.0), Scale::OfDay),
            SessionTimes::Stated(vec![600.0, 900.0])
        );
        assert_eq!(SessionTimes::of(&captures[1..], None, Scale::OfDay), SessionTimes::Stated(vec![0.0, 300.0]));
        // beside captures that state their day: the same day, or the evening before
        let dated = [capture(10.0 * DAY_S + 200.0)];
        assert_eq!(SessionTimes::of(&dated, of_day(100.0), Scale::Days), SessionTimes::Stated(vec![100.0]));
        assert_eq!(SessionTimes::of(&dated, of_day(86000.0), Scale::Days), SessionTimes::Stated(vec![600.0]));
    }

    #[test]
    fn times_that_cannot_be_are_not_taken() {
        let planned = |captures: &[Stated], began| match SessionTimes::of(captures, began, Scale::Days) {
            SessionTimes::Planned(why) => why,
            SessionTimes::Stated(times) => panic!("{times:?}"),
        };
        let silent = Stated { began_s: None, lasts_s: 60.0 };
        assert_eq!(planned(&[silent, silent], None), WhyPlanned::NoneStated);
        assert_eq!(planned(&[capture(0.0), silent], None), WhyPlanned::OneWithout(1));
        assert_eq!(planned(&[capture(100.0), capture(130.0)], None), WhyPlanned::Overlap(0, 1));
        assert_eq!(planned(&[capture(1e6), capture(0.0)], None), WhyPlanned::FarApart(1, 0));
        assert_eq!(planned(&[capture(100.0)], at(106.0)), WhyPlanned::BeforeBegin(0));
    }
}
