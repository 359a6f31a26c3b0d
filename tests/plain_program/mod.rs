//! A reader of programs written for tests alone: lines and arcs to moves over time, in the coordinates of the program with
//! its offsets. It knows what the test programs use and panics at the rest.

#![allow(dead_code, reason = "shared by tests of which not all need it")]

pub const LETTERS: &str = "XYZABC";

#[derive(Debug, Clone)]
pub struct Move {
    pub line: usize,
    /// Number of the N word that was last seen.
    pub number: u32,
    pub is_rapid: bool,
    pub from: [f64; 6],
    pub to: [f64; 6],
    /// Plane, centre, sweep rad.
    pub arc: Option<([usize; 2], [f64; 2], f64)>,
    /// Minutes; 0 for rapids.
    pub minutes: f64,
}

impl Move {
    pub fn at(&self, s: f64) -> [f64; 6] {
        let mut place: [f64; 6] = std::array::from_fn(|k| self.from[k] + s * (self.to[k] - self.from[k]));
        if let Some((plane, centre, sweep)) = self.arc {
            let (u, v) = (self.from[plane[0]] - centre[0], self.from[plane[1]] - centre[1]);
            let (sine, cosine) = (s * sweep).sin_cos();
            let grown = 1.0 + s * self.growth(plane, centre);
            place[plane[0]] = centre[0] + (u * cosine - v * sine) * grown;
            place[plane[1]] = centre[1] + (u * sine + v * cosine) * grown;
        }
        place
    }

    fn growth(&self, plane: [usize; 2], centre: [f64; 2]) -> f64 {
        let radius = |p: &[f64; 6]| (p[plane[0]] - centre[0]).hypot(p[plane[1]] - centre[1]);
        radius(&self.to) / radius(&self.from) - 1.0
    }

    /// Length along all letters, a degree counting as a millimetre.
    pub fn way(&self) -> f64 {
        self.length().hypot((3..6).map(|k| (self.to[k] - self.from[k]).powi(2)).sum::<f64>().sqrt())
    }

    fn length(&self) -> f64 {
        let steps = 2000;
        let way = |k: usize| {
            let (a, b) = (self.at(k as f64 / steps as f64), self.at((k + 1) as f64 / steps as f64));
            (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
        };
        match self.arc {
            None => (0..3).map(|i| (self.to[i] - self.from[i]).powi(2)).sum::<f64>().sqrt(),
            Some(_) => (0..steps).map(way).sum(),
        }
    }
}

/// Moves of a program. `offset` is G54 by letter, `length` the tool's, added to Z while G43 holds.
pub fn moves(text: &str, start: [f64; 6], mut offset: [[f64; 6]; 2], length: f64) -> Vec<Move> {
    let (mut here, mut list) = (start, Vec::new());
    let (mut unit, mut absolute, mut plane, mut motion) = (1.0, true, [0, 1], 0);
    let (mut mode, mut feed, mut system, mut z_length, mut number) = (94, 0.0, 0, 0.0, 0);
    for (index, line) in text.lines().enumerate() {
        let line = line.split(';').next().unwrap();
        let mut plain = String::new();
        let mut depth = 0;
        for c in line.chars() {
            depth += i32::from(c == '(');
            if depth == 0 && !c.is_whitespace() {
                plain.push(c.to_ascii_uppercase());
            }
            depth -= i32::from(c == ')');
        }
        if plain.starts_with('%') || plain.is_empty() {
            continue;
        }
        let mut words: Vec<(char, f64)> = Vec::new();
        let starts: Vec<usize> =
            plain.char_indices().filter(|(_, c)| c.is_ascii_alphabetic()).map(|(k, _)| k).collect();
        for (k, &from) in starts.iter().enumerate() {
            let to = starts.get(k + 1).copied().unwrap_or(plain.len());
            words.push((
                plain.as_bytes()[from] as char,
                plain[from + 1..to].parse().unwrap_or_else(|_| panic!("{line}")),
            ));
        }
        let value = |letter: char| words.iter().find(|(other, _)| *other == letter).map(|(_, value)| *value);
        if let Some(n) = value('N') {
            number = n as u32;
        }
        let mut sets_offset = false;
        let mut is_pause = false;
        for &(_, g) in words.iter().filter(|(letter, _)| *letter == 'G') {
            match (g * 10.0).round() as i32 {
                0 | 10 | 20 | 30 => motion = g as i32,
                40 => is_pause = true,
                100 => sets_offset = true,
                170 => plane = [0, 1],
                180 => plane = [2, 0],
                190 => plane = [1, 2],
                200 => unit = 25.4,
                210 => unit = 1.0,
                900 => absolute = true,
                910 => absolute = false,
                930 | 940 => mode = g as i32,
                540 | 550 => system = g as usize - 54,
                430 => z_length = length,
                434 | 400 | 610 | 640 | 800 | 911 => {}
                490 => z_length = 0.0,
                other => panic!("G{other} in a test program"),
            }
        }
        if let Some(f) = value('F') {
            feed = f;
        }
        if sets_offset {
            let p = value('P').unwrap() as usize - 1;
            for (k, letter) in LETTERS.chars().enumerate() {
                if let Some(v) = value(letter) {
                    offset[p][k] = v * if k < 3 { unit } else { 1.0 };
                }
            }
            continue;
        }
        let has = |letters: &str| words.iter().any(|(letter, _)| letters.contains(*letter));
        if is_pause || !(has(LETTERS) || motion > 1 && has("IJKR")) {
            continue;
        }
        let mut to = here;
        for (k, letter) in LETTERS.chars().enumerate() {
            let Some(v) = value(letter) else { continue };
            let v = v * if k < 3 { unit } else { 1.0 };
            let tool = if k == 2 { z_length } else { 0.0 };
            to[k] = if absolute { v + offset[system][k] + tool } else { here[k] + v };
        }
        let mut next = Move { line: index + 1, number, is_rapid: motion == 0, from: here, to, arc: None, minutes: 0.0 };
        if motion > 1 {
            next.arc = Some(arc(&next, plane, motion == 3, unit, &value));
        }
        if motion > 0 {
            let turned = (3..6).map(|k| (to[k] - here[k]).powi(2)).sum::<f64>().sqrt();
            let way = next.length();
            next.minutes = match (mode, way > 0.0) {
                (93, _) => {
                    assert!(value('F').is_some(), "line {}: no F in G93", index + 1);
                    1.0 / feed
                }
                (_, true) => way / (feed * unit),
                (_, false) => turned / feed,
            };
        }
        here = to;
        list.push(next);
    }
    list
}

fn arc(
    next: &Move,
    plane: [usize; 2],
    counter: bool,
    unit: f64,
    value: &dyn Fn(char) -> Option<f64>,
) -> ([usize; 2], [f64; 2], f64) {
    let [u, v] = plane;
    let (start, end) = ([next.from[u], next.from[v]], [next.to[u], next.to[v]]);
    let tau = std::f64::consts::TAU;
    let sweep_about = |centre: [f64; 2]| {
        let angle = |p: [f64; 2]| (p[1] - centre[1]).atan2(p[0] - centre[0]);
        let mut sweep = angle(end) - angle(start);
        let same = (start[0] - end[0]).hypot(start[1] - end[1]) < 1e-9;
        if same {
            sweep = 0.0;
        }
        if counter {
            while sweep <= 1e-12 {
                sweep += tau;
            }
        } else {
            while sweep >= -1e-12 {
                sweep -= tau;
            }
        }
        sweep + if counter { 1.0 } else { -1.0 } * tau * (value('P').unwrap_or(1.0) - 1.0)
    };
    if let Some(r) = value('R') {
        let r = r * unit;
        let middle = [0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1])];
        let half = 0.5 * (end[0] - start[0]).hypot(end[1] - start[1]);
        let rise = (r * r - half * half).max(0.0).sqrt();
        let normal = [-(end[1] - start[1]) / (2.0 * half), (end[0] - start[0]) / (2.0 * half)];
        let both = [1.0, -1.0].map(|side| {
            let centre = [middle[0] + side * rise * normal[0], middle[1] + side * rise * normal[1]];
            (centre, sweep_about(centre))
        });
        // of the two the shorter way for a positive radius
        let [one, other] = both;
        let (short, long) = if one.1.abs() < other.1.abs() { (one, other) } else { (other, one) };
        let (centre, sweep) = if r > 0.0 { short } else { long };
        return (plane, centre, sweep);
    }
    let letters = ['I', 'J', 'K'];
    let centre =
        [start[0] + value(letters[u]).unwrap_or(0.0) * unit, start[1] + value(letters[v]).unwrap_or(0.0) * unit];
    (plane, centre, sweep_about(centre))
}
