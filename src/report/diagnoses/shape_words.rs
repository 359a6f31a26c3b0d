//! The shape of an effect in words, from its parameters: where on the axis, how often, how fast, driven by what. It holds no sizes.

use super::quantity_words::{digits, tests_words, time_words};
use crate::diagnose::ONE_JUMP_S;
use crate::effects::{OWN, ParameterUnit, ROTARY, SLIDES, Signature, WARM, is_a, kind};
use crate::machine::{Axis, AxisKind, Effect, Machine, ParameterValue};

/// The shape of an effect from its parameters, in units of files; empty when there is nothing to say.
pub fn shape_words(machine: &Machine, effects: &[Effect]) -> String {
    let Some(lead) = effects.first() else { return String::new() };
    let times: Vec<f64> = effects.iter().filter_map(|effect| effect.number("time")).collect();
    if effects.len() > 1 && times.len() == effects.len() && times.iter().any(|t| (t - times[0]).abs() > ONE_JUMP_S) {
        return format!("{} jumps, some at one place of the axis", effects.len());
    }
    let shape = Shape { machine, lead };
    let words = [
        shape.bump_words(),
        shape.lift_words(),
        shape.slope_words(),
        shape.cup_words(),
        shape.take_up_words(),
        shape.period_words(),
        shape.time_constant_words(),
        shape.heat_words(),
        shape.channel_words(),
        shape.arrival_words(),
        shape.jump_words(),
        shape.frequency_words(),
        shape.free_curve_words(),
    ];
    words.concat().join("; ")
}

/// The effect that leads a finding, with the machine that tells the units of its positions.
struct Shape<'a> {
    machine: &'a Machine,
    lead: &'a Effect,
}

impl Shape<'_> {
    /// The axis on which the effect is.
    fn axis(&self) -> Option<&Axis> {
        self.lead.place.axis().map(|axis| &self.machine.axes[axis])
    }

    /// Name of the axis on which the effect is; empty when it is on none.
    fn axis_name(&self) -> &str {
        self.axis().map_or("", |axis| axis.name.as_str())
    }

    /// Unit in which positions of that axis are said.
    fn position_unit(&self) -> &'static str {
        match self.axis().map(|axis| axis.kind) {
            Some(AxisKind::Rotary) => "°",
            Some(AxisKind::Linear) | None => "mm",
        }
    }

    /// A stated number, in the unit of files.
    fn number(&self, name: &str) -> Option<f64> {
        let value = self.lead.number(name)?;
        let is_position = kind(&self.lead.kind).is_some_and(|kind| {
            kind.parameters.iter().any(|parameter| parameter.name == name && parameter.unit == ParameterUnit::Position)
        });
        Some(self.axis().filter(|_| is_position).map_or(value, |axis| axis.kind.to_file_unit(value)))
    }

    /// A stated list; empty when it is not stated.
    fn list(&self, name: &str) -> &[f64] {
        match self.lead.parameter(name) {
            Some(ParameterValue::List(values)) => values,
            _ => &[],
        }
    }

    /// A stated word.
    fn word(&self, name: &str) -> Option<&str> {
        match self.lead.parameter(name) {
            Some(ParameterValue::Word(word)) => Some(word),
            _ => None,
        }
    }

    /// Whether the effect shows itself in this way.
    fn is(&self, signature: Signature) -> bool {
        is_a(&self.lead.kind, signature)
    }

    /// Whether the machine was warm as the session began.
    fn begins_warm(&self) -> bool {
        self.word("begins") == Some(WARM)
    }

    /// Where on the travel: a bump and its width, or all of it.
    fn bump_words(&self) -> Vec<String> {
        if let (Some(centre), Some(width)) = (self.number("centre"), self.number("width")) {
            let (centre, width) = (digits(centre, Some(1.0)), digits(width, Some(1.0)));
            vec![format!("a bump centred at {} = {centre} mm, {width} mm wide", self.axis_name())]
        } else if !self.list("degrees").is_empty() {
            vec!["a bow over the whole travel".into()]
        } else {
            Vec::new()
        }
    }

    /// How late and how fast something lifts off and settles.
    fn lift_words(&self) -> Vec<String> {
        if !self.is(Signature::Lift) {
            return Vec::new();
        }
        let unit = self.position_unit();
        let late = self.number("hysteresis").filter(|late| *late > 0.0);
        let rise = self.number("rise").filter(|rise| *rise > 0.0);
        let late = late.map(|late| format!("about {} {unit} later on the way back", digits(late, Some(0.2 * late))));
        let rise = rise.map(|rise| format!("settles in about {} s (1/e)", digits(rise, Some(0.2 * rise))));
        let both = (late.is_some() && rise.is_some()).then(|| "one feed alone does not tell these two apart".into());
        late.into_iter().chain(rise).chain(both).collect()
    }

    /// How an angle grows along the axis.
    fn slope_words(&self) -> Vec<String> {
        let Some(curvature) = self.number("curvature").filter(|curvature| *curvature != 0.0) else { return Vec::new() };
        let centre = digits(self.number("centre").unwrap_or(0.0), Some(1.0));
        let (share, way) = (digits(10.0 * curvature.abs(), Some(1.0)), if curvature > 0.0 { "more" } else { "less" });
        vec![format!("so at {} = {centre} mm, {share} % {way} with every 100 mm further on", self.axis_name())]
    }

    /// Form of a ball, and how it lets go of its cup.
    fn cup_words(&self) -> Vec<String> {
        let harmonics = self.number("degree").map(|degree| format!("spherical harmonics up to degree {degree:.0}"));
        let lets_go = self.number("turned").map(|turned| {
            format!("lets go as the bar has turned {} ° in its cup (1/e)", digits(turned, Some(0.1 * turned)))
        });
        harmonics.into_iter().chain(lets_go).collect()
    }

    /// How lost motion is taken up.
    fn take_up_words(&self) -> Vec<String> {
        let Some(share) = self.number("windup_share") else { return Vec::new() };
        match self.number("take_up") {
            Some(travel) if share > 0.02 => vec![format!(
                "{:.0} % of it wind-up, taken up within {} {}",
                100.0 * share,
                digits(travel, Some(0.05 * travel)),
                self.position_unit()
            )],
            _ => vec!["free play, taken up at once".into()],
        }
    }

    /// How often it repeats along the axis.
    fn period_words(&self) -> Vec<String> {
        let joined =
            |values: &[f64]| values.iter().map(|v| digits(*v, Some(0.02 * v.abs()))).collect::<Vec<_>>().join(", ");
        let per_turn = |orders: &[f64]| format!("{} per turn", joined(orders));
        let period = |periods: &[f64]| format!("period {} mm", joined(periods));
        let stated = |name: &str| Some(self.list(name)).filter(|values| !values.is_empty());
        let ripple = self.number("order").map(|order| per_turn(&[order]));
        let ripple = ripple.or_else(|| self.number("period").map(|length| period(&[length])));
        let lists = stated("orders").map(per_turn).into_iter().chain(stated("periods").map(period));
        lists.chain(ripple).collect()
    }

    /// How fast it runs in, and the tests in which a free curve alone is seen.
    fn time_constant_words(&self) -> Vec<String> {
        if self.is(Signature::FreeCurve) {
            return self.lead.tests.iter().map(|tests| format!("only in {}", tests_words(tests, 4))).collect();
        }
        let by_pose = self.word("clock") == Some("poses");
        let words_of = |tau: &f64| if by_pose { format!("{tau:.0} poses") } else { time_words(*tau) };
        match self.list("tau") {
            [] => Vec::new(),
            [tau] => vec![format!("time constant {}", words_of(tau))],
            taus => {
                let taus: Vec<String> = taus.iter().map(words_of).collect();
                vec![format!("time constants {}", taus.join(" and "))]
            }
        }
    }

    /// What heats it.
    fn heat_words(&self) -> Vec<String> {
        let source = self.word("heat").and_then(|heat| match heat {
            OWN => Some("this axis as it moves"),
            SLIDES => Some("the linear axes as they move"),
            ROTARY => Some("the rotary axes as they move"),
            _ => None,
        });
        let heated = source.map(|source| format!("heated by {source}"));
        let is_warm = self.begins_warm() && self.lead.parameter("channel").is_none();
        heated.into_iter().chain(is_warm.then(|| "warm from work before the session".into())).collect()
    }

    /// Which recorded channel it follows.
    fn channel_words(&self) -> Vec<String> {
        let Some(channel) = self.word("channel") else { return Vec::new() };
        let lag = self.number("lag").filter(|lag| *lag > 0.0);
        let lag = lag.map(|lag| format!(" with a lag of {}", time_words(lag))).unwrap_or_default();
        let unbalanced = self.begins_warm().then(|| "out of balance with it as the session began".into());
        [format!("follows {channel}{lag}")].into_iter().chain(unbalanced).collect()
    }

    /// By whose speed an arm swings as it arrives, and which load turns.
    fn arrival_words(&self) -> Vec<String> {
        let mut words = Vec::new();
        if self.is(Signature::Arrival) {
            words.extend(self.word("of").map(|of| format!("by the speed of {of}")));
            words.extend(self.word("about").map(|about| format!("with the arm's reach from {about}")));
            let names = self.machine.axis_names().into_iter();
            let paces =
                names.zip(self.list("rates")).map(|(name, rate)| format!("{name} {}", digits(*rate, Some(0.1))));
            let paces: Vec<String> = paces.collect();
            if !self.list("rates").is_empty() {
                words.push(format!("top speeds to each other {}", paces.join(", ")));
            }
        }
        words.extend(self.word("load").map(|load| format!("load turns with {load}")));
        words
    }

    /// When something jumped, how it creeps and when it is gone.
    fn jump_words(&self) -> Vec<String> {
        let mut words = Vec::new();
        words.extend(self.number("time").map(|time| format!("at {} of the session", time_words(time))));
        words.extend(self.number("pose").map(|first| format!("from pose {:.0} on", first.ceil())));
        if let (Some(share), Some(time)) = (self.number("creep_share"), self.number("creep_time"))
            && share > 0.02
        {
            words.push(format!("{:.0} % of it by creep over {}", 100.0 * share, time_words(time)));
        }
        words.extend(self.number("travel").map(|travel| {
            format!("gone after {} {} of travel", digits(travel, Some(0.05 * travel)), self.position_unit())
        }));
        words
    }

    /// At which frequency it is caught up, swings or beats.
    fn frequency_words(&self) -> Vec<String> {
        let servo = self.number("servo_hz").filter(|hz| *hz > 0.0);
        let caught_up = servo.map(|hz| format!("caught up at {} Hz", digits(hz, Some(0.05 * hz))));
        let says = if self.is(Signature::Beat) { "beats at " } else { "" };
        let swings = self.number("frequency").map(|hz| format!("{says}{} Hz", digits(hz, Some(0.01 * hz))));
        caught_up.into_iter().chain(swings).collect()
    }

    /// Which bar it is of, and over what a curve of unknown form runs.
    fn free_curve_words(&self) -> Vec<String> {
        let bar = self.number("bar").map(|bar| format!("the bar of {bar:.2} mm"));
        let driver = match self.word("driver") {
            Some("direction") => "position and direction",
            Some("run") => "the time since a run began",
            Some("elevation") => "the elevation of the bar",
            Some(driver) => driver,
            None => "position",
        };
        let free = self.is(Signature::FreeCurve).then(|| format!("form unknown: a free curve over {driver}"));
        bar.into_iter().chain(free).collect()
    }
}
