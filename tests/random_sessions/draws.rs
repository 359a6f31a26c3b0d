//! Random choices of one session, the same for the same seed everywhere.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A stream of choices.
pub struct Draws(ChaCha8Rng);

impl Draws {
    pub fn of(seed: u64) -> Draws {
        Draws(ChaCha8Rng::seed_from_u64(seed))
    }

    /// True in so many of a hundred.
    pub fn percent(&mut self, of_hundred: u32) -> bool {
        self.0.random_range(0..100) < of_hundred
    }

    pub fn between(&mut self, from: f64, to: f64) -> f64 {
        self.0.random_range(from..to)
    }

    /// A whole number from `from` to `to`, both among them.
    pub fn count(&mut self, from: usize, to: usize) -> usize {
        self.0.random_range(from..=to)
    }

    /// A size over many orders of magnitude, either sign.
    pub fn magnitude(&mut self, least: f64, most: f64) -> f64 {
        let size = 10f64.powf(self.between(least.log10(), most.log10()));
        if self.percent(50) { size } else { -size }
    }

    pub fn one<'a, T>(&mut self, of: &'a [T]) -> &'a T {
        &of[self.0.random_range(0..of.len())]
    }

    pub fn shuffled<T: Clone>(&mut self, of: &[T]) -> Vec<T> {
        let mut list = of.to_vec();
        for last in (1..list.len()).rev() {
            let other = self.count(0, last);
            list.swap(last, other);
        }
        list
    }

    /// About normal, standard deviation one.
    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.between(0.0, 1.0)).sum::<f64>() - 6.0
    }

    pub fn vector(&mut self, reach: f64) -> [f64; 3] {
        [0; 3].map(|_| (self.between(-reach, reach) * 1e3).round() / 1e3)
    }
}
