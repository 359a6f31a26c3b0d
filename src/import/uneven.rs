//! Runs that were held, or changed their feed, on the way, beside an even one that explains a capture. They are looked for between marks.

use rayon::prelude::*;

use super::capture::Averages;
use super::course::Course;
use super::error::ImportError;
use super::likelihood::{cost, residual_mm};
use super::refusals::CERTAIN;
use super::search::{RAMPS, descend_by_covariance, descend_freely, wandering};
use super::timing::Timing;
use super::timing::bend::Bend;
use super::uncertainty::apart;
use super::variables::Candidate;
use super::wander::Wander;
use crate::statistics::{minimise_few, rms};

/// Costs above the best, twice log odds, beyond which an uneven run says nothing of an even one.
const UNLIKELY: f64 = 20.0;
/// Positions that an uneven run puts elsewhere by less than this are as well placed by an even one, deg or mm.
const AS_WELL_PLACED: f64 = 0.05;
/// What an uneven run leaves, in noise and the usual wander of a gauge, where nothing else is at work. Where forms of the machine are left, a
/// bend takes what it can of them and is none.
const LEFT_BY_A_BEND: f64 = 2.0;

/// What uneven runs say beside an even one.
pub(super) struct Uneven {
    /// Those that explain most, the best first; their costs count how rare they are.
    bent: Vec<Candidate>,
    /// How far all of them together leave open where an axis was, root mean square, deg or mm.
    pub position_sigma: f64,
}

impl Uneven {
    /// Beside an even run that leaves so much of readings with so much noise, mm.
    pub fn beside(course: &Course, fine: &Averages, even: &Candidate, (left_mm, noise_mm): (f64, f64)) -> Uneven {
        if fine.marks.is_none() {
            return Uneven { bent: Vec::new(), position_sigma: 0.0 };
        }
        let most_left_mm = LEFT_BY_A_BEND * noise_mm.hypot(Wander::default().size_mm);
        let every = uneven(course, fine, even);
        let mut bent = bent(course, fine, &every);
        bent.retain(|one| {
            let left = residual_mm(course, &fine.with(one.wander), &one.timing, one.freedom);
            rms(left.into_iter()) < most_left_mm
        });
        let shares = if left_mm < most_left_mm { shares(even, &every) } else { Vec::new() };
        let off = |one: &Candidate| apart(course, &even.timing, &one.timing).powi(2);
        let variance: f64 = shares.iter().zip(&every).map(|(share, one)| share * off(one)).sum();
        Uneven { bent, position_sigma: variance.sqrt() }
    }

    /// Refuses a run that was not even, where the readings say so beyond doubt and it puts positions elsewhere.
    pub fn refuse(&self, test: &str, course: &Course, even: &Candidate) -> Result<(), ImportError> {
        let is_certain = |found: &&Candidate| 0.5 * (even.cost - found.cost) > CERTAIN;
        let Some(found) = self.bent.first().filter(is_certain) else { return Ok(()) };
        let off = apart(course, &even.timing, &found.timing);
        if off < AS_WELL_PLACED {
            return Ok(());
        }
        let bends = found.timing.bends;
        let direction = usize::from(bends[0] == Bend::NONE);
        let Bend { at, held_s, ratio } = bends[direction];
        Err(ImportError::Uneven { test: test.into(), percent: 100.0 * at, held_s, ratio, off, unit: course.unit })
    }

    /// Those that are nearly as likely as the even run.
    pub fn as_likely(&self, even: &Candidate) -> impl Iterator<Item = Candidate> + '_ {
        let most = even.cost + UNLIKELY;
        self.bent.iter().copied().filter(move |one| one.cost < most)
    }
}

/// Log odds against a run that is uneven on the way: one in fifty is; and twice those against one place and size of it among some fifty
/// that readings tell apart.
const AGAINST_BENDS: f64 = 3.9;
const AGAINST_A_BEND: f64 = 2.0 * AGAINST_BENDS + 16.0;
/// Places, s and ratios of paces from which uneven runs are sought, and how many of those that explain most are.
const BENT_AT: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];
const HELD_S: [f64; 3] = [0.1, 0.3, 0.9];
const RATIOS: [f64; 6] = [0.9, 0.95, 0.985, 1.015, 1.05, 1.1];
const BENT: usize = 3;

/// The same place with runs that are uneven on the way: both at one time or place of theirs, or one of them, also so that both had one pace.
fn uneven(course: &Course, fine: &Averages, from: &Candidate) -> Vec<Candidate> {
    let none = Bend::NONE;
    let held = BENT_AT.into_iter().flat_map(|at| HELD_S.map(|held_s| Bend { at, held_s, ..none }));
    let changed = BENT_AT.into_iter().flat_map(|at| RATIOS.map(|ratio| Bend { at, ratio, ..none }));
    let of = |bend: Bend| {
        let back = Bend { at: 1.0 - bend.at, ..bend };
        let restored = Bend { ratio: bend.ratio.recip(), ..bend };
        [[bend; 2], [bend, back], [bend, restored], [bend, none], [none, bend]]
    };
    let [there, back] = from.timing.paces;
    let longer_s = course.run_s / there - course.run_s / back;
    let at_one_pace = BENT_AT.into_iter().flat_map(|at| {
        let hold = Bend { at, held_s: longer_s.abs(), ..none };
        // the first run changed to the pace of the second, or the second from that of the first
        let first = Bend { at, ratio: (back / there - (1.0 - at)) / at, ..none };
        let second = Bend { at, ratio: (1.0 - at) / (there / back - at), ..none };
        let is_sane = |bend: &Bend| (0.5..2.0).contains(&bend.ratio);
        let of_hold = if longer_s > 0.0 { [hold, none] } else { [none, hold] };
        let of_change = [[first, none], [none, second]];
        std::iter::once(of_hold).chain(of_change.into_iter().filter(move |bends| bends.iter().all(is_sane)))
    });
    let as_found = held.chain(changed).flat_map(of).chain(at_one_pace).map(|bends| Timing { bends, ..from.timing });
    let every: Vec<Timing> = as_found.chain(held_at_the_pace_of_marks(course, fine, &from.timing)).collect();
    let data = fine.with(from.wander);
    let bent = |timing| Candidate::of(course, &data, timing, from.freedom);
    let mut list: Vec<Candidate> = every.into_par_iter().map(bent).filter(|one| one.cost.is_finite()).collect();
    list.sort_by(|one, other| one.cost.total_cmp(&other.cost));
    list
}

/// Runs at the pace of the marks with usual ramps, which stand for the time that is left: a ramp, or a pace, stands for it else.
fn held_at_the_pace_of_marks(course: &Course, data: &Averages, timing: &Timing) -> Vec<Timing> {
    let Some(seen) = &data.marks else { return Vec::new() };
    let ways = RAMPS.into_iter().filter_map(|ramp_s| {
        let moving_s = [0, 1].map(|direction| timing.moving_s(direction, course.run_s));
        let held_s = moving_s.map(|moving_s| moving_s - ramp_s - course.run_s / seen.pace);
        let paces = moving_s.map(|moving_s| course.run_s / (moving_s - ramp_s));
        let is_held = held_s.iter().all(|held_s| *held_s > LEAST_HELD_S);
        is_held.then_some((Timing { ramp_s, paces, ..*timing }, held_s))
    });
    let at = |(timing, held_s): (Timing, [f64; 2])| {
        BENT_AT.into_iter().flat_map(move |at| {
            [[at, at], [at, 1.0 - at]].map(|places| {
                let bends = [0, 1].map(|k| Bend { at: places[k], held_s: held_s[k], ..Bend::NONE });
                Timing { bends, ..timing }
            })
        })
    };
    ways.flat_map(at).collect()
}

/// Shortest hold that is looked for so, s: shorter ones are those of rests and ramps.
const LEAST_HELD_S: f64 = 0.03;

/// Uneven runs by how likely each is beside an even one, all of them together one in fifty before any reading.
fn shares(even: &Candidate, uneven: &[Candidate]) -> Vec<f64> {
    let each = (-AGAINST_BENDS).exp() / uneven.len().max(1) as f64;
    let weights: Vec<f64> = uneven.iter().map(|one| each * (0.5 * (even.cost - one.cost)).exp()).collect();
    let all = 1.0 + weights.iter().sum::<f64>();
    weights.into_iter().map(|weight| weight / all).collect()
}

/// The uneven runs that explain most, the best first, where they do. Their costs count how rare that is.
fn bent(course: &Course, fine: &Averages, uneven: &[Candidate]) -> Vec<Candidate> {
    let settled = |candidate: &Candidate| {
        let settled = (0..2).fold(*candidate, |one, _| {
            let data = fine.with(wandering(course, fine, &one));
            let bent = sized(course, &data, &one);
            descend_freely(&bent, |timing, freedom| {
                descend_by_covariance(course, &data, Candidate::of(course, &data, timing, freedom))
            })
        });
        Candidate { cost: settled.cost + AGAINST_A_BEND, ..settled }
    };
    let mut settled: Vec<Candidate> = uneven[..BENT.min(uneven.len())].par_iter().map(settled).collect();
    settled.sort_by(|one, other| one.cost.total_cmp(&other.cost));
    settled
}

/// An uneven run with the place and size of its bends that explain most: moved alike where both runs have one.
fn sized(course: &Course, data: &Averages, from: &Candidate) -> Candidate {
    let at = |[along, size]: &[f64; 2]| {
        let bends = from.timing.bends.map(|bend| match bend == Bend::NONE {
            true => bend,
            false => Bend {
                at: (bend.at + 0.1 * along).clamp(0.02, 0.98),
                held_s: bend.held_s * size.exp(),
                ratio: bend.ratio.powf(size.exp()),
            },
        });
        Timing { bends, ..from.timing }
    };
    let timing = at(&minimise_few([0.0; 2], 0.5, |x| cost(course, data, &at(x), from.freedom)));
    Candidate::of(course, data, timing, from.freedom)
}
