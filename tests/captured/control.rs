//! A control of the tests' own: runs a program in time, with ramps, an override, and the latency of dwells.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use fiveaxis::machine::{AxisKind, Machine};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::super::nc_reader::{Act, Pace, read_iso};

/// How this control runs programs.
pub struct Manner {
    /// Speed over the programmed feed, of each direction.
    pub paces: [f64; 2],
    /// Time in which a run comes to speed, s.
    pub ramp_s: f64,
    /// Rests before the first motion and after the last, s; programmed ones where the operator does not wait.
    rests_s: [f64; 2],
    /// Rest in place of those between the directions of a program without marks, s.
    between_s: Option<f64>,
    /// Time in which a mark comes to speed where it is the run's: acceleration by a time constant, s.
    mark_ramp_s: Option<f64>,
    /// What a rest may last longer than programmed, s.
    longer_s: f64,
    /// A rest between the directions that is the operator's, s.
    waits_s: f64,
    /// Time constant by which all axes follow their commands, s.
    lag_s: f64,
}

/// What controls and operators do beside running a program as written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Habit {
    /// Nothing.
    Plain,
    /// Acceleration by a time constant: marks come to speed as slowly as runs.
    SlowMarks,
    /// Each direction at a pace of its own.
    TwoPaces,
    /// Rests that are longer by what the control pleases, up to 40 ms.
    UnevenRests,
    /// The operator lets the second direction wait.
    Waits,
    /// He lets it wait for so long beside the dwell, s.
    WaitsFor(f64),
    /// Servos lag by a time constant, s.
    Lags(f64),
    /// The feed override is not at 100 %.
    Override(f64),
    /// The programmed feed is kept, and ramps are as long as axes that accelerate fast or slowly need.
    Exact,
}

pub const HABITS: [Habit; 4] = [Habit::SlowMarks, Habit::TwoPaces, Habit::UnevenRests, Habit::Waits];

impl Manner {
    pub fn drawn(random: &mut ChaCha8Rng, marked: bool, habit: Habit) -> Manner {
        let mut rest = || random.random_range(0.5..10.0);
        let (rests_s, between_s) = ([rest(), rest()], rest());
        let part = if let Habit::Override(part) = habit { part } else { 1.0 };
        let mut pace = || part * (1.0 + random.random_range(-0.02..0.02));
        let pace_there = pace();
        let pace_back = if habit == Habit::TwoPaces { pace() } else { pace_there };
        let ramp_s = random.random_range(0.08..0.29);
        let (paces, ramp_s) = match habit {
            Habit::Exact => ([1.0; 2], 0.005 * 60f64.powf(random.random_range(0.0..1.0))),
            _ => ([pace_there, pace_back], ramp_s),
        };
        Manner {
            paces,
            ramp_s,
            rests_s,
            between_s: (!marked).then_some(between_s),
            mark_ramp_s: (habit == Habit::SlowMarks).then_some(ramp_s),
            longer_s: if habit == Habit::UnevenRests { 0.04 } else { 0.0 },
            waits_s: match habit {
                Habit::Waits => random.random_range(0.5..10.0),
                Habit::WaitsFor(waits_s) => waits_s,
                _ => 0.0,
            },
            lag_s: if let Habit::Lags(lag_s) = habit { lag_s } else { 0.0 },
        }
    }
}

/// The piece of a program with marks behind which lies the gap between its directions: moves out and back, run, out and back.
const BETWEEN: usize = 4;

/// One act and how long it takes as programmed, s.
struct Leg {
    seconds: f64,
    from: Vec<f64>,
    act: Act,
}

/// Acts that are run without a stop, and when.
struct Group {
    begin_s: f64,
    whole_s: f64,
    ramp_s: f64,
    legs: Vec<Leg>,
    /// Programmed times at which the legs end.
    ends_s: Vec<f64>,
}

/// What the axes do over time.
pub struct Motion {
    groups: Vec<Group>,
    letters: Vec<String>,
    kinds: Vec<AxisKind>,
    last_s: f64,
    lag_s: f64,
    /// Begin and end of the two runs, s.
    pub runs_s: [[f64; 2]; 2],
}

/// Programmed time of an act from a place, s, and where it ends; positions as programs state them.
fn programmed(act: &Act, here: &[f64], letters: &[String]) -> (f64, Vec<f64>) {
    let index = |name: &String| letters.iter().position(|letter| letter == name).expect("an axis");
    let absolute = |to: &BTreeMap<String, f64>| {
        let mut end = here.to_vec();
        to.iter().for_each(|(name, value)| end[index(name)] = *value);
        end
    };
    match act {
        Act::Rapid(to) => (0.0, absolute(to)),
        Act::Feed { to, pace: Pace::Seconds(seconds) } => (*seconds, absolute(to)),
        Act::Feed { to, pace: Pace::PerMinute(feed) } => {
            let end = absolute(to);
            let way = end.iter().zip(here).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            (way / feed * 60.0, end)
        }
        Act::Arc { plane, end, centre, counter_clockwise, feed } => {
            let (turn, radius) = turned(plane, end, centre, *counter_clockwise);
            let mut to = here.to_vec();
            end.iter().for_each(|(name, by)| to[index(name)] += by);
            (turn.abs() * radius / feed * 60.0, to)
        }
        _ => (0.0, here.to_vec()),
    }
}

/// Turn of an arc, rad with its sense, and its radius.
fn turned(plane: &str, end: &BTreeMap<String, f64>, centre: &BTreeMap<String, f64>, left: bool) -> (f64, f64) {
    let [one, other] = [&plane[..1], &plane[1..]];
    let middle = [centre[one], centre[other]];
    let from = (-middle[1]).atan2(-middle[0]);
    let to = (end[other] - middle[1]).atan2(end[one] - middle[0]);
    let turn = if left { (to - from).rem_euclid(TAU) } else { -(from - to).rem_euclid(TAU) };
    (turn, middle[0].hypot(middle[1]))
}

/// Runs a program from the stop at which the bar is mounted to that at which it is taken off.
pub fn timeline(machine: &Machine, text: &str, manner: &Manner, random: &mut ChaCha8Rng) -> Motion {
    let acts = read_iso(text, false, &[]).acts;
    let letters: Vec<String> = machine.axes.iter().map(|axis| axis.name.clone()).collect();
    let dwells: Vec<usize> = (0..acts.len()).filter(|&k| matches!(acts[k], Act::Dwell(_))).collect();
    let (first, last) = (dwells[0], dwells[dwells.len() - 1]);
    let mut here = vec![0.0; letters.len()];
    for act in &acts[..first] {
        here = programmed(act, &here, &letters).1;
    }
    let mut clock = manner.rests_s[0];
    let mut groups: Vec<Group> = Vec::new();
    let mut runs = Vec::new();
    let of_run = if manner.between_s.is_none() { [2, 7] } else { [0, 2] };
    // what this control adds to a dwell: the same each time, but for a cycle or two
    let slow = random.random_range(0.0..0.02);
    for (piece, pair) in dwells.windows(2).enumerate() {
        let part = &acts[pair[0] + 1..pair[1]];
        if !part.is_empty() {
            let is_run = of_run.contains(&piece);
            let mut legs = Vec::new();
            let mut ends_s = Vec::new();
            let mut gone = 0.0;
            for act in part {
                let (seconds, to) = programmed(act, &here, &letters);
                gone += seconds;
                ends_s.push(gone);
                legs.push(Leg { seconds, from: std::mem::replace(&mut here, to), act: act.clone() });
            }
            // marks are slow: their ramps are short
            let ramp_s = match manner.mark_ramp_s {
                None if !is_run => random.random_range(0.001..0.004),
                _ => manner.ramp_s,
            };
            let whole_s = gone / manner.paces[usize::from(piece > BETWEEN.min(of_run[1] - 1))];
            groups.push(Group { begin_s: clock, whole_s, ramp_s, legs, ends_s });
            if is_run {
                runs.push([clock, clock + whole_s + ramp_s]);
            }
            clock += whole_s + ramp_s;
        }
        let Act::Dwell(seconds) = acts[pair[1]] else { unreachable!() };
        clock += match (pair[1] == last, manner.between_s) {
            (true, _) => manner.rests_s[1],
            (false, None) => {
                let waits_s = if piece == BETWEEN { manner.waits_s } else { 0.0 };
                let longer_s = if manner.longer_s > 0.0 { random.random_range(0.0..manner.longer_s) } else { 0.0 };
                seconds + slow + random.random_range(0.0..0.002) + longer_s + waits_s
            }
            // two dwells between the directions
            (false, Some(between)) if piece == 0 => between,
            (false, Some(_)) => 0.0,
        };
    }
    let kinds = machine.axes.iter().map(|axis| axis.kind).collect();
    let runs_s = <[[f64; 2]; 2]>::try_from(runs).expect("two runs");
    Motion { groups, letters, kinds, last_s: clock, lag_s: manner.lag_s, runs_s }
}

impl Group {
    /// Share of the programmed time that is gone: the speed rises as a squared sine.
    fn gone(&self, since_s: f64) -> f64 {
        let end = self.whole_s + self.ramp_s;
        let wave = self.ramp_s / (2.0 * PI);
        let rise = |t: f64| {
            if t < self.ramp_s { t / 2.0 - wave * (PI * t / self.ramp_s).sin() } else { t - self.ramp_s / 2.0 }
        };
        let way = if since_s <= 0.0 {
            0.0
        } else if since_s >= end {
            self.whole_s
        } else if since_s < end - self.ramp_s {
            rise(since_s)
        } else {
            self.whole_s - rise(end - since_s)
        };
        (way / self.whole_s).clamp(0.0, 1.0)
    }
}

impl Motion {
    pub fn lasts_s(&self) -> f64 {
        self.last_s
    }

    /// Positions of all axes at a time, mm and rad: the mean of commands past, a share of e^(−age/lag) each.
    pub fn at(&self, time_s: f64) -> Vec<f64> {
        const PARTS: usize = 64;
        if self.lag_s == 0.0 {
            return self.commanded(time_s);
        }
        let mut mean = vec![0.0; self.kinds.len()];
        for part in 0..PARTS {
            let age_s = -self.lag_s * (1.0 - (part as f64 + 0.5) / PARTS as f64).ln();
            let commanded = self.commanded((time_s - age_s).max(0.0));
            mean.iter_mut().zip(commanded).for_each(|(mean, q)| *mean += q / PARTS as f64);
        }
        mean
    }

    /// Positions that are commanded at a time.
    fn commanded(&self, time_s: f64) -> Vec<f64> {
        let k = self.groups.partition_point(|group| group.begin_s <= time_s).saturating_sub(1);
        let group = &self.groups[k];
        let whole = group.ends_s[group.ends_s.len() - 1];
        let gone = whole * group.gone(time_s - group.begin_s);
        let leg = group.ends_s.partition_point(|end| *end < gone).min(group.legs.len() - 1);
        let Leg { seconds, from, act } = &group.legs[leg];
        let part = (1.0 - (group.ends_s[leg] - gone) / seconds.max(1e-12)).clamp(0.0, 1.0);
        let shown = match act {
            Act::Arc { plane, end, centre, counter_clockwise, .. } => {
                let (turn, radius) = turned(plane, end, centre, *counter_clockwise);
                let mut place = from.clone();
                let index = |name: &str| self.letters.iter().position(|letter| letter == name).expect("an axis");
                let names = [&plane[..1], &plane[1..]];
                let middle = names.map(|name| centre[name]);
                let (sin, cos) = ((-middle[1]).atan2(-middle[0]) + turn * part).sin_cos();
                place[index(names[0])] += middle[0] + radius * cos;
                place[index(names[1])] += middle[1] + radius * sin;
                for (name, by) in end.iter().filter(|(name, _)| !names.contains(&name.as_str())) {
                    place[index(name)] += by * part;
                }
                place
            }
            act => {
                let (_, to) = programmed(act, from, &self.letters);
                from.iter().zip(&to).map(|(from, to)| from + (to - from) * part).collect()
            }
        };
        shown
            .iter()
            .zip(&self.kinds)
            .map(|(q, kind)| if *kind == AxisKind::Rotary { q.to_radians() } else { *q })
            .collect()
    }
}
