//! Functions of effects that were worked out before: a search comes back to the same shapes at every stage and in every fold.

use std::collections::HashMap;
use std::fmt::Write;
use std::sync::{Arc, Mutex, PoisonError};

use crate::effects::{Context, EffectError, Profile, kind};
use crate::machine::Effect;

/// Most values kept, 8 bytes each.
const MOST_VALUES: usize = 32_000_000;

/// Shapes over the rows of one session.
#[derive(Default)]
pub struct Shapes {
    known: Mutex<Known>,
}

#[derive(Default)]
struct Known {
    by_effect: HashMap<String, Arc<Vec<Profile>>>,
    values: usize,
}

impl Shapes {
    /// Functions of an effect; tests in which all of them are zero hold no rows.
    pub fn of(&self, context: &Context, effect: &Effect) -> Result<Arc<Vec<Profile>>, EffectError> {
        let name = name(effect);
        if let Some(profiles) = self.lock().by_effect.get(&name) {
            return Ok(profiles.clone());
        }
        let Some(kind) = kind(&effect.kind) else {
            return Err(EffectError::UnknownKind { found: effect.kind.clone(), known: String::new() });
        };
        let mut profiles = kind.shape(context, effect)?;
        for rows in profiles.iter_mut().flatten().filter(|rows| rows.iter().all(|value| *value == 0.0)) {
            *rows = Vec::new();
        }
        let profiles = Arc::new(profiles);
        let count: usize = profiles.iter().flatten().map(Vec::len).sum();
        let mut known = self.lock();
        if known.values + count <= MOST_VALUES {
            known.values += count;
            known.by_effect.insert(name, profiles.clone());
        }
        Ok(profiles)
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Known> {
        // nothing panics while it holds the lock; what is in the map is whole in any case
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// All that shapes an effect; its sizes do not.
pub fn name(effect: &Effect) -> String {
    let mut name = effect.kind.clone();
    // writing to a string cannot fail
    let _ = write!(name, " {:?} {:?} {:?}", effect.place, effect.parameters, effect.tests);
    name
}
