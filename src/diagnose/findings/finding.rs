//! A finding: what acts where, how large and how surely, and the test that would settle it. It works nothing out.

use crate::diagnose::cause::Cause;
use crate::effects::{Signature, is_a};
use crate::machine::{Effect, Outlet};

/// One finding.
#[derive(Debug, Clone)]
pub struct Finding {
    pub cause: Cause,
    /// Effects as they go into a machine file, with sizes.
    pub effects: Vec<Effect>,
    pub size: SizeFound,
    /// Tests in which it shows, most visible first.
    pub tests: Vec<String>,
    pub range: Option<RangeFound>,
    pub probability: f64,
    pub rivals: Vec<(Cause, f64)>,
    /// Log likelihood that it explains.
    pub gain: f64,
    /// Acts once: it cannot be shown to repeat.
    pub single: bool,
    /// Indices of the accepted columns that belong to it.
    pub columns: Vec<usize>,
    /// The test that would tell it from its rivals, where one was found.
    pub next_test: Option<NextTest>,
    /// Root mean square of what it adds to the readings of the tests in which it shows, µm.
    pub rms_um: f64,
}

/// Share of a jump that is left at most when another one undoes it.
const THERE_AND_BACK: f64 = 0.2;

/// A rival of at least this share of a finding's probability leaves its cause open: worse than two to one.
const LEAST_SHARE_OF_A_RIVAL: f64 = 0.5;

impl Finding {
    /// Whether readings held out cannot prove it: neither the moment of an event nor the phase of a vibration is to be predicted.
    pub(crate) fn escapes(&self) -> bool {
        self.single || is_a(&self.cause.effect, Signature::Oscillation)
    }

    /// Effects whose form is told: none where the place stands and the form does not.
    pub fn told_effects(&self) -> &[Effect] {
        match self.effects.first() {
            Some(lead) if lead.kind == self.cause.effect => &self.effects,
            _ => &[],
        }
    }

    /// The most probable rival where it leaves the cause open, in words.
    pub(crate) fn near_rival(&self) -> Option<String> {
        let (rival, probability) = self.rivals.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        (*probability >= LEAST_SHARE_OF_A_RIVAL * self.probability).then(|| {
            let components =
                if rival.components.is_empty() { String::new() } else { format!(" ({})", rival.components.join(" ")) };
            format!(
                "{} of {}{components}, {:.0} % against {:.0} %",
                rival.effect,
                rival.place,
                100.0 * probability,
                100.0 * self.probability
            )
        })
    }

    /// Whether a jump is undone by another one of the same ball: something that comes and goes looks so as well.
    pub(crate) fn is_undone_by(&self, other: &Finding) -> bool {
        let (Some(one), Some(two)) = (self.effects.first(), other.effects.first()) else { return false };
        let is_same_ball = (&one.kind, one.place, one.parameter("link"), one.parameter("at"))
            == (&two.kind, two.place, two.parameter("link"), two.parameter("at"));
        let length =
            |jump: &dyn Fn(Outlet) -> f64| one.sizes.iter().map(|s| jump(s.outlet).powi(2)).sum::<f64>().sqrt();
        let along = |effect: &Effect, outlet: Outlet| -> f64 {
            effect.sizes.iter().filter(|size| size.outlet == outlet).map(|size| size.value).sum()
        };
        let left = length(&|outlet| along(one, outlet) + along(two, outlet));
        let largest = length(&|outlet| along(one, outlet)).max(length(&|outlet| along(two, outlet)));
        self.single && other.single && is_same_ball && left < THERE_AND_BACK * largest
    }
}

/// Size in display units.
#[derive(Debug, Clone, PartialEq)]
pub struct SizeFound {
    pub value: f64,
    pub sigma: f64,
    pub unit: &'static str,
    pub meaning: String,
}

/// Where along its driver it acts, in file units.
#[derive(Debug, Clone, PartialEq)]
pub struct RangeFound {
    /// Axis name, or `time_s`.
    pub axis: String,
    pub from: f64,
    pub to: f64,
}

/// A proposed test.
#[derive(Debug, Clone, PartialEq)]
pub struct NextTest {
    /// What to run, in words.
    pub says: String,
    /// Probability that the finding would have afterwards, were it true.
    pub probability_after: f64,
    /// Time on the machine, without mounting.
    pub minutes: f64,
}
