//! Temperature channels of recordings as drivers: change since the session's first reading, carried over gaps.

use super::{Context, EffectError, Profile};

/// What a part feels of a channel.
pub(super) struct Warming {
    /// Temperature minus the first one of the session, K, followed with a lag (first order, s); rows without a reading
    /// repeat the one before, gaps between tests are bridged smoothly, and before the session all stood still.
    pub kelvin: Profile,
    /// How far a part that was out of balance as the session began has come to the channel, 0 to 1.
    pub settled: Profile,
}

pub(super) fn warming(context: &Context, effect: &str, channel: &str, lag_s: f64) -> Result<Warming, EffectError> {
    let mut kelvin = vec![Vec::new(); context.tests()];
    let mut reference = None;
    let mut felt: Option<Felt> = None;
    let mut before: Option<Trend> = None;
    for &test in context.order() {
        let entry = &context.session().tests[test];
        let rows = context.motion(test).rows();
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
        let read: Vec<(f64, f64)> = (0..rows)
            .filter_map(|row| {
                let value = values.get(row).copied().filter(|value| value.is_finite())?;
                Some((context.session_time_s(test, row), value - *reference.get_or_insert(value)))
            })
            .collect();
        let trend = Trend::of(&read);
        if let (Some(felt), Some(before), Some(trend)) = (&mut felt, &before, &trend) {
            before.bridge(trend).for_each(|(at_s, value)| felt.follow(at_s, value));
        }
        let mut read = read.into_iter().peekable();
        kelvin[test] = (0..rows)
            .map(|row| {
                let at_s = context.session_time_s(test, row);
                if let Some((_, value)) = read.next_if(|(read_s, _)| *read_s == at_s) {
                    felt.get_or_insert(Felt::at_rest(lag_s, at_s)).follow(at_s, value);
                } else if let Some(felt) = &mut felt {
                    felt.follow(at_s, felt.channel);
                }
                felt.as_ref().map_or(0.0, |felt| felt.value)
            })
            .collect();
        before = trend.or(before);
    }
    let began_s = felt.map_or(0.0, |felt| felt.began_s);
    let settled = |test, row| match lag_s > 0.0 {
        true => -(-(context.session_time_s(test, row) - began_s).max(0.0) / lag_s).exp_m1(),
        false => 0.0,
    };
    Ok(Warming { kelvin, settled: context.profile(settled) })
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
const REACH: f64 = 3.0;
/// Points on the bridge over a gap.
const BRIDGE: usize = 16;

impl Trend {
    fn of(read: &[(f64, f64)]) -> Option<Trend> {
        let ((from_s, _), (to_s, _)) = (*read.first()?, *read.last()?);
        let count = read.len() as f64;
        let middle = read.iter().map(|(at, _)| at).sum::<f64>() / count;
        let mean = read.iter().map(|(_, value)| value).sum::<f64>() / count;
        let square: f64 = read.iter().map(|(at, _)| (at - middle).powi(2)).sum();
        let product: f64 = read.iter().map(|(at, value)| (at - middle) * (value - mean)).sum();
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
            let share = (REACH * (trend.to_s - trend.from_s) / gap.max(f64::MIN_POSITIVE)).min(1.0);
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
struct Felt {
    lag_s: f64,
    /// Session time of the first reading.
    began_s: f64,
    at_s: f64,
    channel: f64,
    value: f64,
}

impl Felt {
    fn at_rest(lag_s: f64, began_s: f64) -> Felt {
        Felt { lag_s, began_s, at_s: began_s, channel: 0.0, value: 0.0 }
    }

    /// On to a time at which the channel has this value: exact for a channel that runs straight in between.
    fn follow(&mut self, at_s: f64, channel: f64) {
        let passed_s = at_s - self.at_s;
        if self.lag_s <= 0.0 {
            self.value = channel;
        } else if passed_s > 0.0 {
            let slope = (channel - self.channel) / passed_s;
            let kept = (-passed_s / self.lag_s).exp();
            self.value = channel - slope * self.lag_s * (1.0 - kept) + (self.value - self.channel) * kept;
        }
        (self.at_s, self.channel) = (at_s, channel);
    }
}
