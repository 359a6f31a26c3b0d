//! The three test designs and the errors inserted into them, as data; what is assumed in them is said in words beside it.

/// Radius of the circle that the pivot ball describes, mm.
pub const RADIUS_MM: f64 = 100.0;
/// Ball bar with its 50 mm extension, mm.
pub const EXTENDED_MM: f64 = 150.0;
/// Path speed of the pivot ball, mm/min.
pub const FEED_MM_MIN: f64 = 500.0;
/// A sweep of the thesis, degrees.
pub const A_SWEEP_DEG: (f64, f64) = (-20.0, 70.0);
/// A full turn that leaves room for run-in and run-out within ±360°.
pub const C_SWEEP_DEG: (f64, f64) = (-180.0, 180.0);
/// Directions of the repeat runs, balanced so that a drift does not look like a direction effect.
pub const RUNS: [Direction; 6] =
    [Direction::Ccw, Direction::Cw, Direction::Cw, Direction::Ccw, Direction::Ccw, Direction::Cw];

/// Height of the spindle ball above the circle with the extended bar, `√(150² − 100²) = 50√5`.
pub fn cone_height_mm() -> f64 {
    (EXTENDED_MM * EXTENDED_MM - RADIUS_MM * RADIUS_MM).sqrt()
}

#[derive(Clone, Copy, PartialEq)]
pub enum Direction {
    Ccw,
    Cw,
}

#[derive(Clone, Copy, PartialEq)]
pub enum Axis {
    A,
    C,
}

#[derive(Clone, Copy, PartialEq)]
pub enum Bar {
    Short,
    Extended,
}

/// One test: which axis sweeps, with which bar, and where X Y Z hold the spindle ball.
#[derive(Clone)]
pub struct Test {
    pub name: &'static str,
    pub axis: Axis,
    pub bar: Bar,
    pub spindle_mm: [f64; 3],
}

/// One mounting of the pivot and the tests made from it in order.
#[derive(Clone)]
pub struct Mounting {
    pub pivot_mm: [f64; 3],
    pub tests: Vec<Test>,
}

/// Location errors in µm and arcsec, in the order of [`ERROR_NAMES`].
pub const ERROR_NAMES: [(&str, &str); 8] = [
    ("EY0A", "um"),
    ("EZ0A", "um"),
    ("EB0A", "arcsec"),
    ("EC0A", "arcsec"),
    ("EX0C", "um"),
    ("EY0C", "um"),
    ("EA0C", "arcsec"),
    ("EB0C", "arcsec"),
];

/// One chapter's session.
pub struct Design {
    pub chapter: u64,
    pub title: &'static str,
    pub errors: [f64; 8],
    pub mountings: Vec<Mounting>,
    pub assumptions: &'static [&'static str],
}

fn test(name: &'static str, axis: Axis, bar: Bar, spindle_mm: [f64; 3]) -> Test {
    Test { name, axis, bar, spindle_mm }
}

fn chapter_4() -> Design {
    let d = cone_height_mm();
    Design {
        chapter: 4,
        title: "four tests, the pivot mounted once for each axis",
        errors: [33.0, -17.5, 9.40, -6.80, 2.1, -51.2, -19.10, -7.20],
        mountings: vec![
            Mounting {
                pivot_mm: [0.0, RADIUS_MM, 0.0],
                tests: vec![
                    test("a-short", Axis::A, Bar::Short, [0.0, 0.0, 0.0]),
                    test("a-extended", Axis::A, Bar::Extended, [-d, 0.0, 0.0]),
                ],
            },
            Mounting {
                pivot_mm: [RADIUS_MM, 0.0, 0.0],
                tests: vec![
                    test("c-short", Axis::C, Bar::Short, [0.0, 0.0, 0.0]),
                    test("c-extended", Axis::C, Bar::Extended, [0.0, 0.0, d]),
                ],
            },
        ],
        assumptions: &[
            "the pivot of the A tests stands at x = 0 (its x is not published) and the spindle ball of the extended A test on the −x side",
            "the pivot of the C tests stands on the x axis of the table",
        ],
    }
}

fn chapter_5() -> Design {
    let d = cone_height_mm();
    Design {
        chapter: 5,
        title: "four tests from one pivot mounting",
        errors: [34.2, -18.7, 6.62, -11.40, 1.3, -52.5, -22.32, -3.75],
        mountings: vec![Mounting {
            pivot_mm: [0.0, RADIUS_MM, 0.0],
            tests: vec![
                test("a-short", Axis::A, Bar::Short, [0.0, 0.0, 0.0]),
                test("c-short", Axis::C, Bar::Short, [0.0, 0.0, 0.0]),
                test("a-extended", Axis::A, Bar::Extended, [-d, 0.0, 0.0]),
                test("c-extended", Axis::C, Bar::Extended, [0.0, 0.0, d]),
            ],
        }],
        assumptions: &[
            "the pivot stands on the y axis of the table at C = 0, the spindle ball of the extended A test on the −x side",
        ],
    }
}

/// Half of the 550 mm between the two A positions.
const A_POSITION_MM: f64 = 275.0;
/// Height between the two C positions.
const C_HEIGHT_MM: f64 = 150.0;

fn chapter_6() -> Design {
    let at =
        |name, axis, pivot_mm, spindle_mm| Mounting { pivot_mm, tests: vec![test(name, axis, Bar::Short, spindle_mm)] };
    Design {
        chapter: 6,
        title: "each axis tested at two positions along it with the short bar",
        errors: [35.1, -19.6, -4.30, 2.90, 0.6, -53.4, -11.50, 4.60],
        mountings: vec![
            at("a-position-1", Axis::A, [-A_POSITION_MM, RADIUS_MM, 0.0], [-A_POSITION_MM, 0.0, 0.0]),
            at("a-position-2", Axis::A, [A_POSITION_MM, RADIUS_MM, 0.0], [A_POSITION_MM, 0.0, 0.0]),
            at("c-position-1", Axis::C, [RADIUS_MM, 0.0, 0.0], [0.0, 0.0, 0.0]),
            at("c-position-2", Axis::C, [RADIUS_MM, 0.0, C_HEIGHT_MM], [0.0, 0.0, C_HEIGHT_MM]),
        ],
        assumptions: &[
            "the offset of 550 mm is the distance between the two A positions, x = −275 mm and x = +275 mm; position 1 is the one on the −x side",
            "the two C positions are 150 mm apart in height, position 1 the lower",
        ],
    }
}

pub fn designs() -> [Design; 3] {
    [chapter_4(), chapter_5(), chapter_6()]
}
