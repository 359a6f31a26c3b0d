//! Temperature channels of recordings as drivers: change since the session's first reading, carried over gaps.

use super::{Context, EffectError, Profile};

/// Temperature minus the first one of the session, K, followed with a lag (first order, s); rows without a reading
/// repeat the one before, gaps are bridged by a straight line, and before the session all stood still.
pub(super) fn warming(context: &Context, effect: &str, channel: &str, lag_s: f64) -> Result<Profile, EffectError> {
    let mut profile = vec![Vec::new(); context.tests()];
    let mut reference = None;
    let mut last = 0.0;
    let mut felt = Felt { lag_s, at_s: 0.0, channel: 0.0, value: 0.0 };
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
        profile[test] = (0..rows)
            .map(|row| {
                if let Some(value) = values.get(row).copied().filter(|value| value.is_finite()) {
                    if reference.is_none() {
                        felt.at_s = context.session_time_s(test, row);
                    }
                    last = value - *reference.get_or_insert(value);
                }
                felt.follow(context.session_time_s(test, row), last);
                felt.value
            })
            .collect();
    }
    Ok(profile)
}

/// A part that follows a channel.
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
            self.value = channel - slope * self.lag_s * (1.0 - kept) + (self.value - self.channel) * kept;
        }
        (self.at_s, self.channel) = (at_s, channel);
    }
}
