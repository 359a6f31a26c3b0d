//! A share of the survey: every n-th topology, so that all shards take about the same time. It runs nothing.

use std::fmt;

/// Shard `index` of `count`, counted from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Shard {
    pub index: usize,
    pub count: usize,
}

/// Most shards of a survey.
pub const MAX_SHARDS: usize = 2160;

/// Why a shard was refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ShardError {
    #[error("shard '{0}' is not understood; write NUMBER/COUNT, e.g. 3/64")]
    Form(String),
    #[error("shard {index}/{count} does not exist; with {count} shards they are 1/{count} to {count}/{count}")]
    Number { index: usize, count: usize },
    #[error("{0} shards are more than the {MAX_SHARDS} topologies there are")]
    Count(usize),
}

impl Shard {
    /// The whole survey.
    pub const WHOLE: Shard = Shard { index: 1, count: 1 };

    /// Reads `3/64`.
    pub fn parse(text: &str) -> Result<Shard, ShardError> {
        let form = || ShardError::Form(text.chars().filter(|c| !c.is_control()).take(40).collect());
        let (index, count) = text.split_once('/').ok_or_else(form)?;
        let number = |part: &str| match part.chars().all(|c| c.is_ascii_digit()) {
            true => part.parse::<usize>().map_err(|_| form()),
            false => Err(form()),
        };
        let (index, count) = (number(index)?, number(count)?);
        if count > MAX_SHARDS {
            return Err(ShardError::Count(count));
        }
        if index == 0 || index > count {
            return Err(ShardError::Number { index, count });
        }
        Ok(Shard { index, count })
    }

    /// True when the item with this place in the whole list is the shard's.
    pub fn holds(&self, place: usize) -> bool {
        place % self.count == self.index - 1
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}
