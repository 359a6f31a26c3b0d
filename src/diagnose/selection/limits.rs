//! When a search accepts and when it ends, for all readings of a session and for half of them. It weighs nothing.

/// When a search stops.
pub(crate) struct Limits {
    /// Log odds above which an effect is accepted, and those that a further one at another place needs: what is left of
    /// an inexact form must not pass for it.
    pub(crate) accept: f64,
    pub(crate) accept_further: f64,
    /// Log odds above which an effect that acts once is accepted: no other reading can confirm it.
    pub(crate) accept_event: f64,
    /// Most effects of one session.
    pub(crate) effects: usize,
    /// Share of what was explained before that a further effect elsewhere must explain.
    pub(crate) share_elsewhere: f64,
    /// Log odds from which the rest of a form, of one kind with it, belongs to it however small it is.
    pub(crate) sure_rest: f64,
    /// Rms that a further effect elsewhere must take off the residual, in noise floors.
    pub(crate) rms_elsewhere: f64,
    /// Steps after which no other set of effects is tried: readings that no form fits would go on for minutes.
    pub(crate) steps: usize,
}

/// Sweeps: few causes beside one that dominates; what an inexact form leaves must not pass for physics.
pub(crate) const SWEEPS: Limits = Limits {
    accept: 15.0,
    accept_further: 30.0,
    accept_event: 24.0,
    effects: 6,
    share_elsewhere: 0.006,
    sure_rest: f64::INFINITY,
    rms_elsewhere: 0.25,
    steps: 26,
};

/// The same over half of the readings: by chance they may show far less than half as much, and what is left of a form must
/// not end a search whose findings nobody reads.
pub(crate) const HALF: Limits =
    Limits { accept: 4.0, accept_further: 6.0, accept_event: 8.0, sure_rest: 50.0, steps: 10, ..SWEEPS };
