//! Temperature channels of recordings as drivers: change since the session's first reading, carried over gaps.

use super::{Context, EffectError, Profile};

/// What a part feels of a channel.
pub(super) struct Warming {
    /// Temperature minus the first one of the session, K, followed with a lag (first order, s); between the readings of a
    /// test it runs straight, gaps between tests are bridged smoothly, and before the session all stood still.
    pub kelvin: Profile,
    /// How far a part that was out of balance as the session began has come to the channel, 0 to 1.
    pub settled: Profile,
}

pub(super) fn warming(context: &Context, effect: &str, channel: &str, lag_s: f64) -> Result<Warming, EffectError> {
    let mut reference = None;
    let mut knots: Vec<Knot> = Vec::new();
    let mut before: Option<Trend> = None;
    for &test in context.order() {
        let read = read(context, effect, channel, test, &mut reference)?;
        let trend = Trend::of(&read);
        if let (Some(before), Some(trend)) = (&before, &trend) {
            knots.extend(before.bridge(trend).map(|(at_s, value)| Knot { at_s, value, row: None }));
        }
        knots.extend(read.iter().map(|&(row, at_s, value)| Knot { at_s, value, row: Some((test, row)) }));
        before = trend.or(before);
    }
    let Some(first) = knots.first() else {
        return Err(EffectError::EmptyChannel { effect: effect.to_string(), channel: channel.to_string() });
    };
    let began_s = first.at_s;
    let mut felt = Felt { lag_s, at_s: began_s, channel: 0.0, value: 0.0 };
    let states: Vec<Felt> = knots
        .iter()
        .map(|knot| {
            felt.follow(knot.at_s, knot.value);
            felt
        })
        .collect();
    let mut kelvin = vec![Vec::new(); context.tests()];
    // knots that lie behind
    let mut passed = 0;
    for &test in context.order() {
        for row in 0..context.motion(test).rows() {
            let at_s = context.session_time_s(test, row);
            passed += knots[passed..].iter().take_while(|knot| knot.row.is_none() && knot.at_s <= at_s).count();
            let is_read = |knot: &Knot| knot.row == Some((test, row));
            // what is left of a bridge ends where the test is read
            let bridge = knots[passed..].iter().take_while(|knot| knot.row.is_none()).count();
            if knots.get(passed + bridge).is_some_and(is_read) {
                passed += bridge + 1;
                kelvin[test].push(states[passed - 1].value);
                continue;
            }
            kelvin[test].push(match (passed.checked_sub(1), knots.get(passed)) {
                (None, _) => 0.0,
                (Some(last), next) => {
                    let mut felt = states[last];
                    felt.follow(at_s, next.map_or(felt.channel, |next| between(&knots[last], next, at_s)));
                    felt.value
                }
            });
        }
    }
    let settled = |test, row| match lag_s > 0.0 {
        true => -(-(context.session_time_s(test, row) - began_s).max(0.0) / lag_s).exp_m1(),
        false => 0.0,
    };
    Ok(Warming { kelvin, settled: context.profile(settled) })
}

/// A temperature at a time: a reading, or a point of the bridge between two tests.
struct Knot {
    at_s: f64,
    value: f64,
    row: Option<(usize, usize)>,
}

/// Temperature on the straight line from one knot to the next; that of the first one where no time passes.
fn between(one: &Knot, next: &Knot, at_s: f64) -> f64 {
    let passes_s = next.at_s - one.at_s;
    let share = if passes_s > 0.0 { ((at_s - one.at_s) / passes_s).clamp(0.0, 1.0) } else { 0.0 };
    one.value + share * (next.value - one.value)
}

/// Rows, session times and changes since the session's first reading where the channel of a test has one.
fn read(
    context: &Context,
    effect: &str,
    channel: &str,
    test: usize,
    reference: &mut Option<f64>,
) -> Result<Vec<(usize, f64, f64)>, EffectError> {
    let entry = &context.session().tests[test];
    let channels = entry.recording.as_ref().map(|recording| recording.channels.as_slice()).unwrap_or_default();
    let Some((_, values)) = channels.iter().find(|(name, _)| name == channel) else {
        let found: Vec<&str> = channels.iter().map(|(name, _)| name.as_str()).collect();
        return Err(EffectError::NoChannel {
            effect: effect.to_string(),
            test: entry.name.clone(),
            channel: channel.to_string(),
            found: if found.is_empty() { "none".into() } else { found.join(", ") },
        });
    };
    let rows = 0..context.motion(test).rows();
    let finite = rows.filter_map(|row| Some((row, values.get(row).copied().filter(|value| value.is_finite())?)));
    let since_first =
        finite.map(|(row, value)| (row, context.session_time_s(test, row), value - *reference.get_or_insert(value)));
    Ok(since_first.collect())
}

/// Straight line through the readings of a test.
struct Trend {
    from_s: f64,
    to_s: f64,
    /// K per second.
    slope: f64,
    mean: f64,
}

/// A test's slope says how a gap begins or ends that is at most so many times as long as the test; the longer the gap, the
/// straighter the bridge.
const LONGEST_GAP_IN_TESTS: f64 = 3.0;
/// Points on the bridge over a gap.
const BRIDGE: usize = 16;

impl Trend {
    fn of(read: &[(usize, f64, f64)]) -> Option<Trend> {
        let ((_, from_s, _), (_, to_s, _)) = (*read.first()?, *read.last()?);
        let count = read.len() as f64;
        let middle = read.iter().map(|(_, at, _)| at).sum::<f64>() / count;
        let mean = read.iter().map(|(_, _, value)| value).sum::<f64>() / count;
        let square: f64 = read.iter().map(|(_, at, _)| (at - middle).powi(2)).sum();
        let product: f64 = read.iter().map(|(_, at, value)| (at - middle) * (value - mean)).sum();
        let slope = if square > 0.0 { product / square } else { 0.0 };
        // the mean belongs to the middle of the times
        let mean = mean + slope * (0.5 * (from_s + to_s) - middle);
        Some(Trend { from_s, to_s, slope, mean })
    }

    fn at(&self, at_s: f64) -> f64 {
        self.mean + self.slope * (at_s - 0.5 * (self.from_s + self.to_s))
    }

    /// Times and values between this test's last reading and the next one's first, on the cubic that leaves and arrives with
    /// their slopes.
    fn bridge(&self, next: &Trend) -> impl Iterator<Item = (f64, f64)> + use<> {
        let gap = next.from_s - self.to_s;
        let (leaves, arrives) = (self.at(self.to_s), next.at(next.from_s));
        let straight = arrives - leaves;
        let bend = |trend: &Trend| {
            let share = (LONGEST_GAP_IN_TESTS * (trend.to_s - trend.from_s) / gap.max(f64::MIN_POSITIVE)).min(1.0);
            share * share * (trend.slope * gap - straight)
        };
        let (first, last) = (bend(self), bend(next));
        let from_s = self.to_s;
        let points = if gap > 0.0 { BRIDGE } else { 0 };
        (1..points).map(move |k| {
            let x = k as f64 / BRIDGE as f64;
            let value = leaves + straight * x + x * (1.0 - x) * (first * (1.0 - x) - last * x);
            (from_s + gap * x, value)
        })
    }
}

/// A part that follows a channel.
#[derive(Clone, Copy)]
struct Felt {
    lag_s: f64,
    at_s: f64,
    channel: f64,
    value: f64,
}

impl Felt {
    /// On to a time at which the channel has this value: exact for a channel that runs straight in between.
    fn follow(&mut self, at_s: f64, channel: f64) {
        let passed_s = at_s - self.at_s;
        if self.lag_s <= 0.0 {
            self.value = channel;
        } else if passed_s > 0.0 {
            let slope = (channel - self.channel) / passed_s;
            let kept = (-passed_s / self.lag_s).exp();
            let gone = -(-passed_s / self.lag_s).exp_m1();
            self.value = channel - slope * self.lag_s * gone + (self.value - self.channel) * kept;
        }
        // tests that overlap in time do not turn it back
        (self.at_s, self.channel) = (self.at_s.max(at_s), channel);
    }
}
