//! What an axis owes to the way it has come, by travel alone: lost motion and reversal spikes. The law without a session, so that
//! sessions and programs run the same one.

/// Commanded moves below this are rounding of the file, mm or rad.
pub(super) const STANDSTILL: f64 = 1e-7;

/// A law of the travel of one axis; its value is per unit of size. Travels are in mm or rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MemoryLaw {
    /// `−[(1−w)·play + w·windup]`.
    LostMotion { windup_share: f64, take_up: f64, gap: f64 },
    /// `(bristle − direction)/2`: a spike that dies away over the travel. It comes in at the rate of its size over the way `onset`, at
    /// once where that is 0. At a reversal the bristle is set back by the share `in_full` of its way: with 1 every spike is as large as
    /// after a long way.
    Spike { travel: f64, in_full: f64, onset: f64 },
}

/// What the past has left.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Past {
    /// Flank of the free gap, −1 … 1; 0 midway.
    pub play: f64,
    /// Flank of what relaxes over a travel: wind-up of the drive, or friction.
    pub windup: f64,
    /// Sense of the last move, −1 or 1; 0 before the first.
    pub direction: f64,
    /// Spike, per unit of its size.
    pub spike: f64,
}

impl Past {
    /// On a flank, before the first move.
    pub fn on_flank(flank: f64) -> Past {
        Past { play: flank, windup: flank, ..Past::default() }
    }
}

impl MemoryLaw {
    /// After a way in the mechanical positive sense, mm or rad.
    pub fn advance(&self, past: &mut Past, way: f64) {
        if way.abs() <= STANDSTILL {
            return;
        }
        let (gap, take_up) = match *self {
            MemoryLaw::LostMotion { take_up, gap, .. } => (gap, take_up),
            MemoryLaw::Spike { travel, .. } => (0.0, travel),
        };
        let direction = way.signum();
        if let MemoryLaw::Spike { in_full, .. } = *self
            && past.direction * direction < 0.0
        {
            past.windup += in_full * (past.direction - past.windup);
        }
        past.direction = direction;
        past.play = if gap > 0.0 { (past.play + 2.0 * way / gap).clamp(-1.0, 1.0) } else { direction };
        let mut rest = way.abs();
        if let MemoryLaw::Spike { onset, .. } = *self
            && comes_in(past)
        {
            let until = onset * (due(past) - past.spike).abs();
            if rest < until {
                past.spike -= direction * rest / onset;
                return;
            }
            rest -= until;
        }
        let decay = if take_up > 0.0 { (-rest / take_up).exp() } else { 0.0 };
        past.windup = direction + (past.windup - direction) * decay;
        past.spike = due(past);
    }

    /// Value per unit of size.
    pub fn value(&self, past: &Past) -> f64 {
        match *self {
            MemoryLaw::LostMotion { windup_share, .. } => {
                -((1.0 - windup_share) * past.play + windup_share * past.windup)
            }
            MemoryLaw::Spike { .. } => past.spike,
        }
    }

    /// Change of the value per mm or rad of a further way in the sense of the last move.
    pub fn slope(&self, past: &Past) -> f64 {
        let relaxes = |travel: f64| if travel > 0.0 { (1.0 - past.direction * past.windup) / travel } else { 0.0 };
        match *self {
            MemoryLaw::LostMotion { windup_share, take_up, gap } => {
                let turns_round = if gap > 0.0 && past.play * past.direction < 1.0 { 2.0 / gap } else { 0.0 };
                -((1.0 - windup_share) * turns_round + windup_share * relaxes(take_up))
            }
            MemoryLaw::Spike { onset, .. } if comes_in(past) => -1.0 / onset,
            MemoryLaw::Spike { travel, .. } => 0.5 * relaxes(travel),
        }
    }

    /// The past after a long way in a sense, −1 or 1.
    pub fn settled(&self, direction: f64) -> Past {
        Past { play: direction, windup: direction, direction, spike: 0.0 }
    }

    /// The past at the beginning of a way in a sense: turned round, nothing taken up that takes a travel.
    pub fn turned(&self, past: &Past, direction: f64) -> Past {
        let mut turned = *past;
        self.advance(&mut turned, 2.0 * STANDSTILL * direction);
        turned
    }

    /// How far the value still changes at most on a long way in a sense.
    pub fn to_come(&self, past: &Past, direction: f64) -> f64 {
        let turned = self.turned(past, direction);
        let next = match self {
            MemoryLaw::Spike { .. } => due(&turned),
            MemoryLaw::LostMotion { .. } => self.value(&turned),
        };
        let change = self.value(&self.settled(direction)) - next;
        change.abs().max((next - self.value(past)).abs())
    }

    /// Shortest of the travels over which it changes next on a way in a sense, mm or rad; 0 where it changes at once.
    pub fn next_travel(&self, past: &Past, direction: f64) -> f64 {
        match *self {
            MemoryLaw::LostMotion { windup_share, take_up, gap } => {
                let free = if windup_share < 1.0 { gap } else { f64::INFINITY };
                let elastic = if windup_share > 0.0 { take_up } else { f64::INFINITY };
                free.min(elastic)
            }
            MemoryLaw::Spike { onset, .. } if comes_in(&self.turned(past, direction)) => onset,
            MemoryLaw::Spike { travel, .. } => travel,
        }
    }
}

/// What a spike is to be, per unit of its size.
fn due(past: &Past) -> f64 {
    (past.windup - past.direction) / 2.0
}

/// Of its size: what a spike lacks by rounding alone.
const COME_IN: f64 = 1e-9;

/// Whether a spike still falls behind; one without an onset never does after a move.
fn comes_in(past: &Past) -> bool {
    (due(past) - past.spike) * past.direction < -COME_IN
}
