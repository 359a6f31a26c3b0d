//! A move cut into straight commands and arcs after which the erring machine's tool follows the ideal path within a tolerance.

use super::command::{Control, Coordinates, Positions};
use super::correct::{Corrected, Corrector};
use super::memory::LEVER_MM;
use super::path::{Arc, ArcSense, ArcWords, Path, Place};
use crate::machine::{AxisKind, ComponentForm};

/// How closely the path is followed and how finely words are written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fineness {
    /// Distance of the tip from the ideal path, mm.
    pub tolerance_mm: f64,
    /// Angle of the tool from the ideal direction, rad, beside what the axes cannot give.
    pub tolerance_rad: f64,
    /// Smallest steps of lengths (mm) and angles (deg) in words.
    pub step_mm: f64,
    pub step_deg: f64,
    /// Arcs become arcs where they can.
    pub keeps_arcs: bool,
}

/// The end of one command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece {
    /// Share of the move's time at its end; 1 is the end of the move.
    pub share: f64,
    /// Share at its start.
    pub from_share: f64,
    /// Coordinates of the command, rounded as they are written.
    pub command: Place,
    /// The way there, with its centre rounded as it is written; straight without one.
    pub arc: Option<Arc>,
    /// Corrected positions of the axes.
    pub positions: Positions,
    /// What the tool's direction stays off, rad.
    pub off_rad: f64,
    /// The tip is where it ought to be at its end.
    pub is_met: bool,
}

/// Where a piece is compared with the ideal path: off the middle, so that a wave is not met at its zeros alone.
const LOOKS: [f64; 3] = [0.27, 0.5, 0.77];
/// A further look where an axis owes something to its way: what turns back as a piece begins may be over before the first one.
const NEAR_BEGIN: f64 = 0.02;
/// Of a tolerance a piece may use this much: between the looks it may be a little farther off.
const USED: f64 = 0.8;
/// Shares of a move below this are not cut any more.
const LEAST_SHARE: f64 = 1e-7;
/// The same where an axis loses motion: its reversal is one short block.
const LEAST_SHARE_OF_JUMPS: f64 = 1e-9;
/// How much longer a block may be than the one before where an axis loses motion; 2 elsewhere.
const GROWS_AFTER_REVERSAL: f64 = 1000.0;
/// Of a tolerance: what a piece uses that a smooth way ends.
const USED_BY_SMOOTH: f64 = 0.25;
/// Of a tolerance: a block that goes over less may hold the jump of a reversal, which no cut takes away.
const JUMP: f64 = 0.5;
/// Shares of a block below this are no place to cut it at a reversal.
const NEAR_END: f64 = 1e-3;
/// Rounds of a search for a reversal; each leaves two thirds of the interval.
const ROUNDS: usize = 60;
/// Ways below this tell no sense of motion, mm or rad.
const STANDSTILL: f64 = 1e-9;
/// Most pieces of a move of a machine that loses motion: some hundred times what lost motion makes of a circle. An axis for which no
/// command is right turns back at each of them without end.
const MOST_PIECES: usize = 30_000;
/// An arc whose rise over its chord is below this share of the tolerance is written as a straight command.
const FLAT: f64 = 0.3;
/// Looks at a wave of a component error.
const LOOKS_PER_WAVE: f64 = 8.0;

/// A move that is being cut.
#[derive(Debug, Clone)]
pub struct Pieces<'p> {
    path: &'p Path,
    fineness: Fineness,
    /// Where the control stands.
    sent: Place,
    sent_off_rad: f64,
    share: f64,
    step: f64,
    longest: f64,
    /// Pieces so far.
    count: usize,
    /// Distance of the tool from the ideal path at the start of the move, mm and rad, that is not of this move's making.
    start_off: (f64, f64),
}

impl<'p> Pieces<'p> {
    /// A move from where the control stands.
    pub fn new(
        control: &mut Control,
        corrector: &Corrector,
        path: &'p Path,
        sent: &Place,
        fineness: Fineness,
    ) -> Pieces<'p> {
        let longest = longest_share(control, path, fineness.tolerance_mm);
        let from = control.positions(&path.from, &[0.0; 9]);
        let stands = control.positions(sent, &from);
        let (ideal, actual) = (control.ideal(&from), corrector.pose(&stands));
        let start_off = ((actual.tip_mm - ideal.tip_mm).norm(), actual.angle_to(&ideal.axis));
        Pieces { step: longest, longest, ..Pieces::from_start(path, fineness, *sent, start_off) }
    }

    /// A rapid: its end alone is corrected.
    pub fn rapid(path: &'p Path, fineness: Fineness) -> Pieces<'p> {
        Pieces::from_start(path, fineness, path.to, (f64::INFINITY, f64::INFINITY))
    }

    /// A move in one piece, of which nothing is cut yet.
    fn from_start(path: &'p Path, fineness: Fineness, sent: Place, start_off: (f64, f64)) -> Pieces<'p> {
        Pieces { path, fineness, sent, sent_off_rad: 0.0, share: 0.0, step: 1.0, longest: 1.0, count: 0, start_off }
    }

    /// How far from its path the tool is when the move begins, mm.
    pub fn starts_off_mm(&self) -> f64 {
        self.start_off.0
    }

    /// The next command; `None` at the end.
    pub fn next(&mut self, control: &mut Control, corrector: &mut Corrector) -> Result<Option<Piece>, String> {
        if self.share >= 1.0 {
            return Ok(None);
        }
        self.count += 1;
        // waves alone may ask for more
        let most = MOST_PIECES.max((2.0 * LOOKS_PER_WAVE / self.longest) as usize);
        if self.count > most && !corrector.memories.is_empty() {
            return Err(format!(
                "cannot be corrected in {most} blocks: an axis would turn back again and again, as lost motion or spikes of the machine leave no command that is right"
            ));
        }
        // the shortest step that was too long
        let mut too_long: Option<f64> = None;
        loop {
            let rest = 1.0 - self.share;
            // two halves rather than a whole and a rest
            let step = if self.step >= rest { rest } else { self.step.min(0.5 * rest) };
            let end = if step >= rest { 1.0 } else { self.share + step };
            let end = self.before_turn(control, corrector, end);
            let (piece, used) = self.tried(control, corrector, end);
            let step = end - self.share;
            let goes_over_jump = used > USED && used.is_finite() && self.is_jump(control, corrector, [self.share, end]);
            if used <= USED || goes_over_jump {
                let (piece, next) = match too_long {
                    // behind a jump the way is smooth again
                    _ if goes_over_jump => (piece, self.longest),
                    Some(long) if !corrector.memories.is_empty() => {
                        self.up_to_jump(control, corrector, (piece, used), long)
                    }
                    _ => {
                        let most = if corrector.memories.is_empty() { 2.0 } else { GROWS_AFTER_REVERSAL };
                        (piece, step * (0.85 * (USED / used.max(1e-3)).sqrt()).clamp(0.5, most))
                    }
                };
                self.step = next.min(self.longest);
                (self.share, self.sent, self.sent_off_rad, self.start_off) =
                    (piece.share, piece.command, piece.off_rad, (0.0, 0.0));
                return Ok(Some(piece));
            }
            let least = if corrector.memories.is_empty() { LEAST_SHARE } else { LEAST_SHARE_OF_JUMPS };
            if step < least {
                return Err("cannot be cut finely enough: an error of the machine jumps there, or the tolerance is below what words can say".into());
            }
            too_long = Some(step);
            self.step = step * (0.85 * (USED / used).sqrt()).clamp(0.05, 0.7);
        }
    }

    /// The command to an end, and the share of the tolerance that it uses.
    fn tried(&self, control: &mut Control, corrector: &mut Corrector, end: f64) -> (Piece, f64) {
        let piece = self.command(control, corrector, end);
        // of a rapid the end alone counts, and what no command makes right is told by the move after it
        let counts = piece.is_met || self.start_off.0.is_infinite();
        let used = if counts { self.used(control, corrector, &piece) } else { f64::INFINITY };
        (piece, used)
    }

    /// The longest piece that ends before what made a step too long, and the step that goes on: over a jump, where it is one. By
    /// halves blocks would only come nearer to a jump, and a control lingers on many short ones.
    fn up_to_jump(
        &self,
        control: &mut Control,
        corrector: &mut Corrector,
        (mut best, mut used): (Piece, f64),
        mut long: f64,
    ) -> (Piece, f64) {
        // a piece that uses some of the tolerance is as long as a smooth way allows
        while used < USED_BY_SMOOTH {
            let short = best.share - self.share;
            if self.is_jump(control, corrector, [best.share, self.share + long]) || long - short < LEAST_SHARE_OF_JUMPS
            {
                return (best, long - short);
            }
            let middle = 0.5 * (short + long);
            let (tried, used_by_it) = self.tried(control, corrector, self.share + middle);
            match used_by_it <= USED {
                true => (best, used) = (tried, used_by_it),
                false => long = middle,
            }
        }
        let step = best.share - self.share;
        (best, step)
    }

    /// The end of a piece, before the next reversal of an axis that loses motion, and short over what it has to take up.
    fn before_turn(&self, control: &mut Control, corrector: &Corrector, end: f64) -> f64 {
        if corrector.memories.is_empty() {
            return end;
        }
        let at = |control: &mut Control, share: f64| control.positions(&self.path.at(share), &[0.0; 9]);
        let mut end = end;
        // straight commands of axes turn back at their ends alone
        if self.path.arc.is_some() || control.coordinates == Coordinates::Workpiece {
            for axis in corrector.memories.driving() {
                end = self.first_turn(control, axis, end);
            }
        }
        let from = at(control, self.share);
        loop {
            let to = at(control, end);
            let reach = corrector.memories.reach(&from, &to);
            if reach >= 1.0 {
                return end;
            }
            end = self.share + (end - self.share) * (0.95 * reach.sqrt());
        }
    }

    /// Where an axis turns back before an end of the ideal path; that end where it does not.
    fn first_turn(&self, control: &mut Control, axis: usize, end: f64) -> f64 {
        // near the ends, too: an axis that turns just before the end may stand there farther on than at the look before
        const PLACES: [f64; 7] = [0.0, NEAR_END, LOOKS[0], LOOKS[1], LOOKS[2], 1.0 - NEAR_END, 1.0];
        let share = |k: usize| self.share + PLACES[k] * (end - self.share);
        let mut at = |share: f64| control.positions(&self.path.at(share), &[0.0; 9])[axis];
        let seen: [f64; PLACES.len()] = std::array::from_fn(|k| at(share(k)));
        let way = |k: usize| seen[k + 1] - seen[k];
        let turns = |k: &usize| way(*k).abs().min(way(k + 1).abs()) > STANDSTILL && way(*k) * way(k + 1) < 0.0;
        let Some(k) = (0..PLACES.len() - 2).find(turns) else { return end };
        let sense = way(k).signum();
        let (mut low, mut high) = (share(k), share(k + 2));
        for _ in 0..ROUNDS {
            let third = (high - low) / 3.0;
            match sense * (at(low + third) - at(high - third)) < 0.0 {
                true => low += third,
                false => high -= third,
            }
        }
        let turn = 0.5 * (low + high);
        if turn - self.share > NEAR_END * (end - self.share) { turn } else { end }
    }

    /// Whether the way between two shares is so short that what a piece over it is off can only be the jump of a reversal.
    fn is_jump(&self, control: &mut Control, corrector: &Corrector, shares: [f64; 2]) -> bool {
        if corrector.memories.is_empty() {
            return false;
        }
        let [from, to] = shares.map(|share| control.positions(&self.path.at(share), &[0.0; 9]));
        control.nominal.machine().axes.iter().zip(from.iter().zip(&to)).all(|(axis, (from, to))| {
            let lever_mm = if axis.kind == AxisKind::Rotary { LEVER_MM } else { 1.0 };
            (to - from).abs() * lever_mm < JUMP * self.fineness.tolerance_mm
        })
    }

    /// The command for a share of the way.
    fn command(&self, control: &mut Control, corrector: &mut Corrector, share: f64) -> Piece {
        let (corrected, place) = self.corrected(control, corrector, share);
        let command: Place = std::array::from_fn(|letter| self.rounded(letter, place[letter]));
        let mut piece = Piece {
            share,
            from_share: self.share,
            command,
            arc: None,
            positions: corrected.positions,
            off_rad: corrected.off_rad,
            is_met: corrected.is_met,
        };
        if let Some(arc) = self.path.arc.filter(|_| self.fineness.keeps_arcs) {
            let (_, middle) = self.corrected(control, corrector, 0.5 * (self.share + share));
            piece.arc = self.arc_through(&arc, &middle, &command);
        }
        piece
    }

    /// Corrected positions for a share of the way, and the coordinates that command them.
    fn corrected(&self, control: &mut Control, corrector: &mut Corrector, share: f64) -> (Corrected, Place) {
        let programmed = control.positions(&self.path.at(share), &[0.0; 9]);
        let corrected = corrector.correct(&control.ideal(&programmed), &programmed);
        (corrected, control.place(&corrected.positions))
    }

    fn rounded(&self, letter: usize, value: f64) -> f64 {
        let step = if (3..6).contains(&letter) { self.fineness.step_deg } else { self.fineness.step_mm };
        (value / step).round() * step
    }

    /// The arc from where the control stands through a middle to an end; `None` where a straight command does as well.
    fn arc_through(&self, own: &Arc, middle: &Place, end: &Place) -> Option<Arc> {
        let [u, v] = own.plane;
        // seen from the middle of the chord: along it, and across to its left
        let (along, across) = ((0.5 * (end[u] - self.sent[u])), (0.5 * (end[v] - self.sent[v])));
        let half = along.hypot(across);
        let (x, y) = (middle[u] - self.sent[u] - along, middle[v] - self.sent[v] - across);
        let (on_chord, rise) = ((x * along + y * across) / half, (y * along - x * across) / half);
        if !rise.is_finite() || rise.abs() < FLAT * self.fineness.tolerance_mm || rise * own.sweep > 0.0 {
            return None;
        }
        // equally far from both ends and from the middle
        let left = (on_chord * on_chord + rise * rise - half * half) / (2.0 * rise);
        let centre = [self.sent[u] + along - left * across / half, self.sent[v] + across + left * along / half];
        let from_start = [0, 1].map(|k| {
            let start = self.sent[own.plane[k]];
            start + self.rounded(own.plane[k], centre[k] - start)
        });
        let sense = if own.sweep > 0.0 { ArcSense::CounterClockwise } else { ArcSense::Clockwise };
        Arc::new(&self.sent, end, own.plane, ArcWords::Centre(from_start), sense, 1.0).ok()
    }

    /// Largest share of the tolerance that a piece uses between its ends.
    fn used(&self, control: &mut Control, corrector: &Corrector, piece: &Piece) -> f64 {
        let mut most = 0.0f64;
        // what the axes cannot give, or what was off before, is no fault of the cut
        let known_rad = self.start_off.1 + piece.off_rad.max(self.sent_off_rad);
        let way = Path { from: self.sent, to: piece.command, arc: piece.arc };
        let begins = Some(NEAR_BEGIN).filter(|_| !corrector.memories.is_empty());
        for look in begins.into_iter().chain(LOOKS) {
            let share = self.share + look * (piece.share - self.share);
            let ideal = control.positions(&self.path.at(share), &piece.positions);
            let driven = control.positions(&way.at(look), &piece.positions);
            let (ideal, actual) = (control.ideal(&ideal), corrector.pose(&driven));
            let off_mm = (actual.tip_mm - ideal.tip_mm).norm();
            let excess_mm = off_mm - self.start_off.0;
            let excess_rad = actual.angle_to(&ideal.axis) - known_rad;
            most = most.max(excess_mm / self.fineness.tolerance_mm).max(excess_rad / self.fineness.tolerance_rad);
        }
        most
    }
}

/// Longest share of a move in one piece: no wave or corner of a component error may lie between two looks.
fn longest_share(control: &Control, path: &Path, tolerance_mm: f64) -> f64 {
    let machine = control.nominal.machine();
    let mut pieces = 1.0f64;
    for (letter, axis) in control.axis_of.iter().enumerate() {
        let Some(axis) = *axis else { continue };
        let axis = &machine.axes[axis];
        let arc =
            path.arc.filter(|arc| arc.plane.contains(&letter)).map_or(0.0, |arc| arc.sweep.abs() * arc.start_radius);
        let way = axis.kind.from_file_unit((path.to[letter] - path.from[letter]).abs().max(arc));
        for error in &axis.component_errors {
            // what a turn of the error moves at the end of its lever
            let lever_mm = if error.component.is_angle() { LEVER_MM } else { 1.0 };
            pieces = pieces.max(way / shortest(&error.form, tolerance_mm / lever_mm));
        }
    }
    if let Some(arc) = &path.arc {
        // a quarter at most, so that the looks do not all lie on one chord
        pieces = pieces.max(arc.sweep.abs() / std::f64::consts::FRAC_PI_2);
    }
    1.0 / pieces
}

/// Shortest way over which a form leaves a straight line by more than a tolerance, or a wave fits between looks, mm or rad.
fn shortest(form: &ComponentForm, tolerance: f64) -> f64 {
    match form {
        ComponentForm::Polynomial(_) => f64::INFINITY,
        ComponentForm::Fourier(harmonics) => {
            let highest = harmonics.iter().map(|harmonic| harmonic.frequency.abs()).fold(0.0, f64::max);
            std::f64::consts::TAU / highest / LOOKS_PER_WAVE * LOOKS.len() as f64
        }
        ComponentForm::Table { position, value } => {
            let slope = |k: usize| (value[k + 1] - value[k]) / (position[k + 1] - position[k]);
            let (mut spacing, mut bend) = (f64::INFINITY, 0.0f64);
            for k in 1..position.len().saturating_sub(1) {
                let between = 0.5 * (position[k + 1] - position[k - 1]);
                spacing = spacing.min(between);
                bend = bend.max((slope(k) - slope(k - 1)).abs() / between);
            }
            // a curve of this bend leaves its chord by bend·way²/8
            (8.0 * tolerance / bend).sqrt().max(spacing * LOOKS.len() as f64)
        }
    }
}
