//! When a search accepts and when it ends, for all readings of a session and for half of them. It weighs nothing.

use crate::diagnose::thresholds::Thresholds;

/// When a search stops.
pub(crate) struct Limits {
    /// Log odds above which a first effect is accepted that has a form, and those that a free curve needs, or a further effect at one
    /// place: free curves take up what is left of any kind of noise.
    pub(crate) accept_form: f64,
    pub(crate) accept: f64,
    /// Those that a further one at another place needs: what is left of an inexact form must not pass for it.
    pub(crate) accept_further: f64,
    /// Log odds above which an effect that acts once is accepted: no other reading can confirm it.
    pub(crate) accept_event: f64,
    /// Log odds that an effect must keep beside a zero that wanders.
    pub(crate) beside_wander: f64,
    /// Log odds from which the rest of a form, of one kind with it, belongs to it however small it is.
    pub(crate) sure_rest: f64,
    /// Steps after which no other set of effects is tried: readings that no form fits would go on for minutes.
    pub(crate) steps: usize,
    /// What else decides.
    pub(crate) thresholds: Thresholds,
}

/// Most effects of one session: few causes beside one that dominates.
pub(crate) const MOST_EFFECTS: usize = 6;

impl Limits {
    /// Of a search on all readings.
    pub(crate) fn of_all(thresholds: Thresholds) -> Limits {
        Limits {
            accept_form: thresholds.accept_form,
            accept: thresholds.accept,
            accept_further: thresholds.accept_further,
            accept_event: thresholds.accept_event,
            beside_wander: thresholds.better,
            sure_rest: f64::INFINITY,
            steps: 26,
            thresholds,
        }
    }

    /// The same over half of the readings: by chance they may show far less than half as much, and what is left of a form must
    /// not end a search whose findings nobody reads.
    pub(crate) fn of_half(thresholds: Thresholds) -> Limits {
        Limits {
            accept_form: thresholds.half * thresholds.accept_form,
            accept: thresholds.half * thresholds.accept,
            accept_further: thresholds.half * thresholds.accept_further,
            accept_event: thresholds.half * thresholds.accept_event,
            beside_wander: thresholds.half * thresholds.better,
            sure_rest: thresholds.half_rest,
            steps: 10,
            ..Limits::of_all(thresholds)
        }
    }
}
