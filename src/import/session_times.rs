//! When captures were recorded within their session, by what they state of it. It reads no dates.

/// What a capture states of its time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stated {
    /// Zero of the gauge's clock, s on a scale that the captures share; `None` where the file does not state it.
    pub zero_s: Option<f64>,
    /// First and last reading on the gauge's clock, s.
    pub ends_s: (f64, f64),
}

/// The times of captures in a session.
#[derive(Debug, Clone, PartialEq)]
pub enum SessionTimes {
    /// Zeros of the gauge's clock since the session began, s, by capture.
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
const FAR_APART_S: f64 = 86400.0;
/// Captures may overlap by this, s: clocks that are written to a second, before or behind the bar's mounting.
const OVERLAP_S: f64 = 2.0;

impl SessionTimes {
    /// Of captures that state their times, from the begin of the session on: a stated one, or that of the earliest capture.
    pub fn of(stated: &[Stated], began_s: Option<f64>) -> SessionTimes {
        let without = stated.iter().position(|one| one.zero_s.is_none());
        if let Some(without) = without {
            let is_all = stated.iter().all(|one| one.zero_s.is_none());
            let why = if is_all { WhyPlanned::NoneStated } else { WhyPlanned::OneWithout(without) };
            return SessionTimes::Planned(why);
        }
        let zeros: Vec<f64> = stated.iter().filter_map(|one| one.zero_s).collect();
        let ends = |k: usize| [zeros[k] + stated[k].ends_s.0, zeros[k] + stated[k].ends_s.1];
        let mut order: Vec<usize> = (0..stated.len()).collect();
        order.sort_by(|&one, &other| ends(one)[0].total_cmp(&ends(other)[0]));
        for pair in order.windows(2) {
            let pause_s = ends(pair[1])[0] - ends(pair[0])[1];
            if pause_s < -OVERLAP_S {
                return SessionTimes::Planned(WhyPlanned::Overlap(pair[0], pair[1]));
            }
            if pause_s > FAR_APART_S {
                return SessionTimes::Planned(WhyPlanned::FarApart(pair[0], pair[1]));
            }
        }
        let Some(&first) = order.first() else { return SessionTimes::Planned(WhyPlanned::NoneStated) };
        let earliest_s = ends(first)[0];
        let began_s = began_s.unwrap_or(earliest_s);
        if earliest_s < began_s {
            return SessionTimes::Planned(WhyPlanned::BeforeBegin(first));
        }
        SessionTimes::Stated(zeros.iter().map(|zero| zero - began_s).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn capture(zero_s: f64) -> Stated {
        Stated { zero_s: Some(zero_s), ends_s: (5.0, 65.0) }
    }

    #[test]
    fn captures_count_from_the_earliest_or_from_when_the_session_began() {
        let captures = [capture(1000.0), capture(400.0)];
        assert_eq!(SessionTimes::of(&captures, None), SessionTimes::Stated(vec![595.0, -5.0]));
        assert_eq!(SessionTimes::of(&captures, Some(100.0)), SessionTimes::Stated(vec![900.0, 300.0]));
    }

    #[test]
    fn times_that_cannot_be_are_not_taken() {
        let planned = |captures: &[Stated], began_s| match SessionTimes::of(captures, began_s) {
            SessionTimes::Planned(why) => why,
            SessionTimes::Stated(times) => panic!("{times:?}"),
        };
        let silent = Stated { zero_s: None, ends_s: (0.0, 60.0) };
        assert_eq!(planned(&[silent, silent], None), WhyPlanned::NoneStated);
        assert_eq!(planned(&[capture(0.0), silent], None), WhyPlanned::OneWithout(1));
        assert_eq!(planned(&[capture(100.0), capture(130.0)], None), WhyPlanned::Overlap(0, 1));
        assert_eq!(planned(&[capture(1e6), capture(0.0)], None), WhyPlanned::FarApart(1, 0));
        assert_eq!(planned(&[capture(100.0)], Some(106.0)), WhyPlanned::BeforeBegin(0));
    }
}
