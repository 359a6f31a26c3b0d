//! The numbers that decide what the search accepts and what is said of it: with unit and meaning. It computes nothing.
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
        "a free curve as the first effect of a session, and a further effect at the same place, is accepted above; χ² is twice as much";
    accept_form = 8.0, off 15.0, "log odds":
        "a form of the catalogue as the first effect of a session, and further effects of static poses, are accepted above";
    accept_further = 30.0, off 15.0, "log odds":
        "a further effect at another place is accepted above: what is left of an inexact form must not pass for it";
    accept_event = 24.0, off 15.0, "log odds":
        "an effect that acts once is accepted above: no other reading can confirm it";
    half = 0.27, off 1.0, "share":
        "of these three in a fold of the proof: half of the readings may show far less than half as much";
    half_rest = 50.0, off f64::INFINITY, "log odds":
        "in a fold the rest of a form belongs to it from here, however small it is";
    inexact = 0.002, off 0.0, "share":
        "of a mean square or of log odds that says nothing, for no form is exact: a further effect at one place, and what held-out readings gain, must be more; names within it are tied";
    share_elsewhere = 0.006, off 0.0, "share":
        "of the mean square that other effects explain which one at another place must explain";
    rms_first = 0.18, off 0.0, "noise floors":
        "rms that the first effect must take off the residual";
    rms_further = 0.25, off 0.0, "noise floors":
        "the same for a further effect elsewhere and for an event: somewhere in a session noise looks like a jump";
    beyond_doubt = 150.0, off f64::INFINITY, "log odds":
        "from which it is enough to show within sweeps";
    relief = 22.0, off f64::INFINITY, "χ²":
        "fall of what was stated of balls, bars and location errors, without the largest, with which nothing need show in the residual";
    zero_wanders = 0.7, off 0.4, "noise floors":
        "offset from test to test beside which an effect must still be worth telling";
    zero_walks = 1.5, off 0.0, "noise floors":
        "standard deviation, at the end of a session, of a zero that walks, beside which an effect must still be worth telling";
    better = 5.0, off 0.0, "log odds":
        "by which another set of effects must stand better, that a further parameter of a form must add, and that an effect must keep beside a zero that wanders";
    explained = 1.25, off f64::INFINITY, "noise floors":
        "residual up to which a session counts as explained: beyond it other first effects are tried, readings that scatter unevenly are looked at, and findings that no fold confirms stay";
    unlikely_set = 60.0, off 5.0, "log odds":
        "by which a set that begins with a free curve, or with a ball out of round, must stand better than named effects of the machine";
    free_set_share = 0.03, off 0.0, "share":
        "the same at least, of what the named form gains";
    ball_share = 0.15, off 0.0, "share":
        "the same at most for a ball, of its gain: balls are gauges";
    one_cause = 20.0, off 0.0, "log odds":
        "by which one form in other motions may stand worse than a form with a free curve beside it";
    free_margin = 1.3, off 1.0, "ratio of χ²":
        "by which a free curve must explain more than the best named form";
    explains_most = 0.5, off 0.0, "share":
        "of what is more than noise that a wrong pairing of one test, or findings where the folds call them otherwise, must explain; and of what findings take off all readings that they must take off those held out, or no more than this share is claimed";
    tie = 3.0, off 0.0, "log odds":
        "within which candidates count as equal, so that the customary name decides";
    free_tie = 10.0, off 0.0, "log odds":
        "the same among free curves";
    one_direction = 0.93, off 1.0, "share":
        "of what a vibration in several directions explains with which one in a single direction is the likelier";
    two_angles = 50.0, off 0.0, "log odds":
        "what the two angles of a free direction may gain by chance";
    fewer_motions = 0.99, off 1.0, "share":
        "of what error motions in several components explain with which one in fewer is the likelier";
    own_rather = 0.9, off 1.0, "share":
        "of what a tipping part explains with which lost motion of the axis that drives it is the likelier";
    softening = 0.004, off 0.0, "per log odds":
        "log odds of a rival are divided by 1 and so much of the chosen cause's own: forms of the catalogue are never exact";
    softening_of_arcs = 0.02, off 0.01, "per log odds":
        "the same between sag and error motion over part of a turn";
    customary = 0.04, off 1.0, "ratio":
        "in sweeps, prior odds of a cause that is less customary than the chosen one (growth of the spindle's slide, vibration of an axis, lost motion of a drive)";
    undescribed = 0.15, off 0.0, "ratio":
        "prior odds of a cause that no form describes beside one that has a form: where a free curve stood nearly as well, 3 of 65 causes were none of the catalogue's (six seeds), and a shop has more kinds than the trial";
    form_unknown = 0.4, off f64::INFINITY, "share":
        "of a finding's gain that free curves beside it take, or of the scatter that is left at its place, from which its form is not the right one";
    rest_of_form = 0.6, off 0.0, "share":
        "of the first effect's gain below which a later one at its place and driver is the rest of its form";
    sure_of_form = 30.0, off 0.0, "log likelihood":
        "gain below which readings do not surely show which form it has; above it one fold may miss it";
    predicted = 1.5, off f64::INFINITY, "ratio":
        "held-out residual over the residual up to which a session counts as explained";
    surely_more = 1.6, off f64::INFINITY, "noise floors":
        "residual from which something is there although no candidate says what";
    unproven = 0.97, off 1.0, "probability":
        "most that is claimed of a cause that does not carry over to other setups or beside which something stays unexplained";
    stands_keeps = 0.2, off 0.0, "share":
        "of its gain that a finding must keep beside an axis that stands elsewhere in each test";
    stands_cost = 10.0, off 0.0, "χ²":
        "that each such place costs";
}
