//! Every number that decides in the search and in what is said of it: with unit and meaning. It computes nothing.
//!
//! `off` is the value with which a rule does nothing; `calibrate --rules` shows what each rule earns on simulated sessions.

/// A number that decides, as a list shows it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Threshold {
    pub name: &'static str,
    pub value: f64,
    /// With this value the rule does nothing, or falls back to the rule that it refines.
    pub off: f64,
    pub unit: &'static str,
    pub meaning: &'static str,
}

macro_rules! thresholds {
    ($($name:ident = $value:expr, off $off:expr, $unit:literal: $meaning:literal;)*) => {
        /// Numbers that decide in a search.
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct Thresholds {
            $(#[doc = concat!($meaning, "; ", $unit, ".")] pub $name: f64,)*
        }

        impl Default for Thresholds {
            fn default() -> Thresholds {
                Thresholds { $($name: $value,)* }
            }
        }

        impl Thresholds {
            /// All of them, with the values that they have here.
            pub fn list(&self) -> Vec<Threshold> {
                vec![$(Threshold {
                    name: stringify!($name),
                    value: self.$name,
                    off: $off,
                    unit: $unit,
                    meaning: $meaning,
                },)*]
            }

            /// The same with another value of one of them; `None` where none has this name.
            pub fn with(mut self, name: &str, value: f64) -> Option<Thresholds> {
                match name {
                    $(stringify!($name) => self.$name = value,)*
                    _ => return None,
                }
                Some(self)
            }
        }
    };
}

thresholds! {
    accept = 15.0, off 4.0, "log odds":
        "the first effect of a session, and a further one at the same place, is accepted above";
    accept_further = 30.0, off 15.0, "log odds":
        "a further effect at another place is accepted above: what is left of an inexact form must not pass for it";
    accept_event = 24.0, off 15.0, "log odds":
        "an effect that acts once is accepted above: no other reading can confirm it";
    half_accept = 4.0, off 15.0, "log odds":
        "`accept` in a fold of the proof: half of the readings may show far less than half as much";
    half_further = 6.0, off 30.0, "log odds":
        "`accept_further` in a fold";
    half_event = 8.0, off 24.0, "log odds":
        "`accept_event` in a fold";
    half_rest = 50.0, off f64::INFINITY, "log odds":
        "in a fold the rest of a form belongs to it from here, however small it is";
    share_same_place = 0.002, off 0.0, "share":
        "of the mean square that other effects explain which one at the same place must explain";
    share_elsewhere = 0.006, off 0.0, "share":
        "the same for an effect elsewhere";
    rms_first = 0.18, off 0.0, "noise floors":
        "rms that the first effect must take off the residual";
    rms_event = 0.25, off 0.0, "noise floors":
        "the same for an event: somewhere in a session noise looks like a jump";
    rms_elsewhere = 0.25, off 0.0, "noise floors":
        "the same for a further effect elsewhere";
    beyond_doubt = 150.0, off f64::INFINITY, "log odds":
        "from which it is enough to show within sweeps";
    relief = 22.0, off f64::INFINITY, "χ²":
        "fall of what was stated of balls, bars and location errors, without the largest, with which nothing need show in the residual";
    zero_wanders = 0.7, off 0.4, "noise floors":
        "offset from test to test beside which growth must still be worth telling";
    zero_walks = 1.5, off 0.0, "noise floors":
        "standard deviation, at the end of a session, of a zero that walks, beside which growth must still be worth telling";
    growth_worth = 6.0, off f64::NEG_INFINITY, "log odds":
        "from which growth is worth telling beside such a zero";
    poorly_explained = 1.3, off f64::INFINITY, "noise floors":
        "residual from which other first effects are tried";
    better_set = 5.0, off 0.0, "log odds":
        "by which another set of effects must stand better";
    free_set = 60.0, off 5.0, "log odds":
        "the same where it begins with a free curve instead of a named form";
    free_set_share = 0.03, off 0.0, "share":
        "the same, of what the named form gains";
    one_cause = 20.0, off 0.0, "log odds":
        "by which one form in other motions may stand worse than a form with a free curve beside it";
    ball_odds = 60.0, off 0.0, "log odds":
        "by which a ball out of round must stand better than a few effects of the machine: balls are gauges";
    ball_share = 0.15, off 0.0, "share":
        "the same at most, of its gain";
    ball_beside = 2.0, off 0.0, "log odds":
        "against a ball out of round beside the effects that were taken instead";
    overtone_gain = 5.0, off 0.0, "log odds":
        "that a further parameter of a form must add";
    free_margin = 1.3, off 1.0, "ratio of χ²":
        "by which a free curve must explain more than the best named form";
    free_offset = 30.0, off 0.0, "χ²":
        "and so much beside it";
    shift_share = 0.5, off 0.0, "share":
        "of the misfit that a wrong pairing of one test must explain";
    ball_form_um = 1.1, off f64::INFINITY, "µm":
        "largest form of a ball: those of gauges are round to some tenths";
    tie = 3.0, off 0.0, "log odds":
        "within which candidates count as equal, so that the customary name decides";
    tie_share = 0.002, off 0.0, "share":
        "the same, of the best one's log odds: forms are never exact";
    free_tie = 10.0, off 0.0, "log odds":
        "the same among free curves";
    one_direction = 0.93, off 1.0, "share":
        "of what a vibration in several directions explains with which one in a single direction is the likelier";
    given_direction = 0.993, off 1.0, "share":
        "the same beside one free direction, of its log odds";
    two_angles = 50.0, off 0.0, "log odds":
        "what the two angles of a free direction may gain by chance";
    fewer_motions = 0.99, off 1.0, "share":
        "the same for error motions in fewer components";
    own_rather = 0.9, off 1.0, "share":
        "of what a tipping part explains with which lost motion of the axis that drives it is the likelier";
    softening = 0.01, off 0.0, "per log odds":
        "log odds of a rival are divided by 1 and so much of the chosen cause's own: forms of the catalogue are never exact";
    softening_of_arcs = 0.05, off 0.01, "per log odds":
        "the same between sag and error motion over part of a turn";
    customary = 0.4, off 1.0, "ratio":
        "prior odds of a cause that is less customary than the chosen one (growth of the spindle's slide, vibration of an axis that moves)";
    form_unknown = 0.4, off f64::INFINITY, "share":
        "of a finding's gain that free curves beside its form take, from which the form is not the right one";
    rest_of_form = 0.6, off 0.0, "share":
        "of the first effect's gain below which a later one at its place and driver is the rest of its form";
    least_gain = 0.002, off 0.0, "share":
        "of their mean square that readings held out must gain";
    beyond_one_fold = 40.0, off f64::INFINITY, "log likelihood":
        "gain with which a finding may be missed by one fold";
    kept_held_out = 0.5, off 1.0, "share":
        "of what is more than noise that held-out readings may keep where they are predicted";
    still_there = 1.25, off 1.0, "ratio":
        "rise of the residual without unproven findings from which they stay, marked as failed";
    explained = 1.25, off f64::INFINITY, "noise floors":
        "residual up to which a session counts as explained";
    predicted = 1.5, off f64::INFINITY, "ratio":
        "held-out residual over the residual up to which it does";
    surely_more = 1.6, off f64::INFINITY, "noise floors":
        "residual from which something is there although no candidate says what";
    sure_of_form = 30.0, off 0.0, "log likelihood":
        "gain below which readings do not surely show which form it has";
    unproven = 0.97, off 1.0, "probability":
        "most that is claimed of a cause whose proof failed or beside which something stays unexplained";
    restless = 1.2, off f64::INFINITY, "noise floors":
        "residual from which it is asked whether restless readings come from the place of a finding";
    not_the_form = 0.4, off f64::INFINITY, "share":
        "of restlessness at a finding's place from which its form is not the right one";
    stands_keeps = 0.2, off 0.0, "share":
        "of its gain that a finding must keep beside an axis that stands elsewhere in each test";
    stands_cost = 10.0, off 0.0, "χ²":
        "that each such place costs";
    pose_first = 14.0, off 8.0, "log odds":
        "static poses: the first effect is accepted above";
    pose_further = 8.0, off 4.0, "log odds":
        "static poses: further ones";
    pose_strong = 20.0, off 8.0, "log odds":
        "static poses: the same in the first search, from which relative speeds are learnt";
}
