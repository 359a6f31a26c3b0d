//! A clear way between two poses, one axis at a time so that every control makes the same motion of it. It places no instrument.
//!
//! A way is: some axes go aside, the others move to where they are wanted, the first ones come back. Every leg is certified
//! as a sweep is. Which axes go aside is tried in a fixed order, and for each all orders of the others.

use std::collections::HashSet;

use super::scene::{Scene, Scratch};
use super::sweep::{Hit, certify};
use crate::machine::AxisKind;

/// One axis moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leg {
    /// Axis, by index.
    pub axis: usize,
    /// Where it goes, mm or rad.
    pub to: f64,
}

/// Axes that go aside before the others move: axis and position, mm or rad, in this order.
pub type Aside = Vec<(usize, f64)>;

/// Most legs checked for one way aside: five axes have at most eighty.
const MOST_LEGS: usize = 200;

/// No way was found: what stood in the way of the one that came nearest to the end.
#[derive(Debug, Clone, PartialEq)]
pub struct NoWay {
    pub axis: usize,
    pub hit: Hit,
    /// Ways aside tried.
    pub tried: usize,
}

/// A way from one pose to another on which no pair comes closer than the margin; the first of `asides` that allows one.
pub fn clear_way(
    scene: &Scene,
    from: &[f64],
    to: &[f64],
    asides: &[Aside],
    margin_mm: f64,
    scratch: &mut Scratch,
) -> Result<Vec<Leg>, NoWay> {
    let mut search = Search { scene, margin_mm, scratch, nearest: None };
    for aside in asides {
        if let Some(legs) = search.by(from, to, aside) {
            return Ok(legs);
        }
    }
    let (_, axis, hit) = search.nearest.unwrap_or_else(|| {
        let hit = Hit { mm: f64::NAN, pair: Default::default(), positions: from.to_vec(), at_row: 0.0 };
        (0, 0, hit)
    });
    Err(NoWay { axis, hit, tried: asides.len() })
}

struct Search<'a, 'w> {
    scene: &'a Scene<'w>,
    margin_mm: f64,
    scratch: &'a mut Scratch,
    /// Legs done, axis and hit of the try that got farthest.
    nearest: Option<(usize, usize, Hit)>,
}

impl Search<'_, '_> {
    /// Certifies one leg; true when it is clear.
    fn clear(&mut self, from: &[f64], leg: Leg, done: usize) -> bool {
        let mut end = from.to_vec();
        end[leg.axis] = leg.to;
        match certify(self.scene, &[from.to_vec(), end], self.margin_mm, self.scratch) {
            Ok(_) => true,
            Err(hit) => {
                if self.nearest.as_ref().is_none_or(|(most, ..)| done > *most) {
                    self.nearest = Some((done, leg.axis, hit));
                }
                false
            }
        }
    }

    fn by(&mut self, from: &[f64], to: &[f64], aside: &Aside) -> Option<Vec<Leg>> {
        let mut legs = Vec::new();
        let mut here = from.to_vec();
        for &(axis, position) in aside {
            let leg = Leg { axis, to: position };
            if here[axis] != position {
                if !self.clear(&here, leg, legs.len()) {
                    return None;
                }
                here[axis] = position;
                legs.push(leg);
            }
        }
        // the way back from aside is checked before the longer search between
        let mut entry = to.to_vec();
        let mut back = Vec::new();
        for &(axis, position) in aside {
            if entry[axis] != position {
                let wanted = entry[axis];
                if !self.clear(&entry, Leg { axis, to: position }, legs.len()) {
                    return None;
                }
                entry[axis] = position;
                back.push(Leg { axis, to: wanted });
            }
        }
        let moving = self.moving(&here, &entry);
        let middle = self.between(&here, &entry, &moving, legs.len())?;
        legs.extend(middle);
        legs.extend(back.into_iter().rev());
        Some(legs)
    }

    /// Axes that differ, rotary ones first: they swing while the linear ones are still away.
    fn moving(&self, from: &[f64], to: &[f64]) -> Vec<usize> {
        let chain = self.scene.world.chain();
        let mut moving: Vec<usize> = (0..from.len()).filter(|&axis| from[axis] != to[axis]).collect();
        moving.sort_by_key(|&axis| chain.joint(axis).kind == AxisKind::Linear);
        moving
    }

    /// An order of the axes that is clear: depth first over the sets of axes already moved, each set once.
    fn between(&mut self, from: &[f64], to: &[f64], moving: &[usize], done: usize) -> Option<Vec<Leg>> {
        if moving.len() >= usize::BITS as usize {
            return None;
        }
        let all = (1usize << moving.len()) - 1;
        let mut seen = HashSet::from([0usize]);
        let mut checked = 0;
        let mut path: Vec<usize> = Vec::new();
        let mut moved = 0usize;
        let mut next = vec![0usize];
        while moved != all {
            let level = path.len();
            let Some(bit) =
                (next[level]..moving.len()).find(|bit| moved & (1 << bit) == 0 && !seen.contains(&(moved | 1 << bit)))
            else {
                // a dead end: the axis that led here goes back
                moved ^= 1 << path.pop()?;
                next.pop();
                continue;
            };
            next[level] = bit + 1;
            checked += 1;
            if checked > MOST_LEGS {
                return None;
            }
            let mut here = from.to_vec();
            (0..moving.len()).filter(|k| moved & (1 << k) != 0).for_each(|k| here[moving[k]] = to[moving[k]]);
            let axis = moving[bit];
            if self.clear(&here, Leg { axis, to: to[axis] }, done + level) {
                moved |= 1 << bit;
                seen.insert(moved);
                path.push(bit);
                next.push(0);
            }
        }
        Some(path.into_iter().map(|bit| Leg { axis: moving[bit], to: to[moving[bit]] }).collect())
    }
}
