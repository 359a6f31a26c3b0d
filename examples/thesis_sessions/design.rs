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
/// Directions of the ten repeats, alternating as one drives there and back.
pub const RUNS: [Direction; 10] = {
    use Direction::{Ccw, Cw};
    [Ccw, Cw, Ccw, Cw, Ccw, Cw, Ccw, Cw, Ccw, Cw]
};
/// Travel before and after the capture arc, degrees (Tables 4.1 and 6.2).
pub const OVERSHOOT_DEG: [f64; 2] = [2.0, 45.0];

/// Height of the spindle ball above the circle with the extended bar, `√(150² − 100²) = 50√5`.
pub fn cone_height_mm() -> f64 {
    (EXTENDED_MM * EXTENDED_MM - RADIUS_MM * RADIUS_MM).sqrt()
}

#[derive(Clone, Copy, PartialEq)]
pub enum Direction {
    Ccw,
    Cw,
}

#[derive(Clone, Copy, PartialEq, Debug)]
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

/// What the pivot stands on.
#[derive(Clone, Copy, PartialEq)]
pub enum Carrier {
    /// The A tilting table, beside the C table.
    TiltingTable,
    /// The C table.
    Table,
}

/// One mounting of the pivot and the tests made from it in order.
#[derive(Clone)]
pub struct Mounting {
    pub carrier: Carrier,
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

/// Place of chapter 4's pivot along A, mm.
const CHAPTER_4_X_MM: f64 = 150.0;

fn chapter_4() -> Design {
    let d = cone_height_mm();
    let x = CHAPTER_4_X_MM;
    Design {
        chapter: 4,
        title: "four tests, the pivot mounted once for each axis",
        // Tables 4.2 and 4.3
        errors: [34.2, -35.3, 6.62, 1.89, 1.3, -52.5, -22.32, -3.75],
        mountings: vec![
            Mounting {
                carrier: Carrier::TiltingTable,
                pivot_mm: [x, RADIUS_MM, 0.0],
                tests: vec![
                    test("a-short", Axis::A, Bar::Short, [x, 0.0, 0.0]),
                    test("a-extended", Axis::A, Bar::Extended, [x - d, 0.0, 0.0]),
                ],
            },
            Mounting {
                carrier: Carrier::Table,
                pivot_mm: [RADIUS_MM, 0.0, 0.0],
                tests: vec![
                    test("c-short", Axis::C, Bar::Short, [0.0, 0.0, 0.0]),
                    test("c-extended", Axis::C, Bar::Extended, [0.0, 0.0, d]),
                ],
            },
        ],
        assumptions: &[
            "the pivot of the A tests stands on the tilting table beside the C table, at x = 150 mm and y = 100 mm (neither is printed); x = 0 returns the same errors (tests/thesis_sessions.rs)",
            "the pivot of the C tests stands at x = 100 mm on the C table; the extended bar's spindle ball is raised",
        ],
    }
}

fn chapter_5() -> Design {
    let d = cone_height_mm();
    Design {
        chapter: 5,
        title: "four tests from one pivot mounting",
        // Tables 5.2 and 5.3
        errors: [35.3, -33.4, -1.29, 1.20, 1.3, -52.9, -22.28, 4.48],
        mountings: vec![Mounting {
            carrier: Carrier::Table,
            pivot_mm: [0.0, RADIUS_MM, 0.0],
            tests: vec![
                test("a-short", Axis::A, Bar::Short, [0.0, 0.0, 0.0]),
                test("a-extended", Axis::A, Bar::Extended, [-d, 0.0, 0.0]),
                test("c-short", Axis::C, Bar::Short, [0.0, 0.0, 0.0]),
                test("c-extended", Axis::C, Bar::Extended, [0.0, 0.0, d]),
            ],
        }],
        assumptions: &[
            "the pivot stands on the y axis of the table at C = 0 (eq. 3.9); the tests run in the order of section 5.1",
        ],
    }
}

/// Half of the 550 mm between the two A positions.
const A_POSITION_MM: f64 = 275.0;
/// Height between the two C positions.
const C_HEIGHT_MM: f64 = 78.0;

fn chapter_6() -> Design {
    let at = |name, axis, carrier, pivot_mm, spindle_mm| Mounting {
        carrier,
        pivot_mm,
        tests: vec![test(name, axis, Bar::Short, spindle_mm)],
    };
    let (on_a, on_c) = (Carrier::TiltingTable, Carrier::Table);
    Design {
        chapter: 6,
        title: "each axis tested at two positions along it with the short bar",
        // Tables 6.3 and 6.4
        errors: [33.5, -35.6, 7.23, 2.94, 1.4, -51.3, -26.03, -14.38],
        mountings: vec![
            at("a-position-1", Axis::A, on_a, [A_POSITION_MM, RADIUS_MM, 0.0], [A_POSITION_MM, 0.0, 0.0]),
            at("a-position-2", Axis::A, on_a, [-A_POSITION_MM, RADIUS_MM, 0.0], [-A_POSITION_MM, 0.0, 0.0]),
            at("c-position-3", Axis::C, on_c, [RADIUS_MM, 0.0, 0.0], [0.0, 0.0, 0.0]),
            at("c-position-4", Axis::C, on_c, [RADIUS_MM, 0.0, C_HEIGHT_MM], [0.0, 0.0, C_HEIGHT_MM]),
        ],
        assumptions: &[
            "DA = 550 mm is the distance between the two A positions, x = 275 mm and x = −275 mm (erratum 21); position 1, whose side is not printed, stands at +x",
            "position errors are those where the axes meet, half way between the two A positions",
        ],
    }
}

pub fn designs() -> [Design; 3] {
    [chapter_4(), chapter_5(), chapter_6()]
}
