//! Temperature channels of recordings as drivers: change since the session's first reading, carried over gaps.

use super::{Context, EffectError, Profile};

/// Temperature minus the first one of the session, K; rows without a reading repeat the one before.
pub(super) fn warming(context: &Context, effect: &str, channel: &str) -> Result<Profile, EffectError> {
    let mut profile = vec![Vec::new(); context.tests()];
    let mut reference = None;
    let mut last = 0.0;
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
                    last = value - *reference.get_or_insert(value);
                }
                last
            })
            .collect();
    }
    Ok(profile)
}
