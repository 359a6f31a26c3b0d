//! Programs corrected line by line: a million short moves of a five-axis path, and the size of the process afterwards.

use std::path::Path;

use fiveaxis::chain::Chain;
use fiveaxis::compensate::{Compensator, Coordinates, Settings};
use fiveaxis::load::load_machine;
use fiveaxis::machine::Component;

const LINES: usize = 1_000_000;

/// Memory does not grow with the program: the process stays below this, kB.
const MOST_KB: u64 = 50_000;

fn main() {
    divan::main();
    if let Some(size) = most_memory_kb() {
        println!("largest size of the process: {size} kB");
        assert!(size < MOST_KB, "the process took {size} kB, more than {MOST_KB}");
    }
}

/// Largest size so far as the system tells it, kB.
fn most_memory_kb() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let size = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    size.trim().strip_suffix("kB")?.trim().parse().ok()
}

fn corrected(coordinates: Coordinates) -> usize {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines/hermle-c600u.yaml");
    let mut machine = load_machine(&file).expect("machine");
    for (axis, component, value) in [
        ("C", Component::EX, 0.02),
        ("C", Component::EA, 1e-4),
        ("A", Component::EY, -0.03),
        ("Z", Component::EB, 5e-5),
    ] {
        let axis = machine.axis_index(axis).expect("axis");
        machine.axes[axis].location_errors[component.index()] = value;
    }
    let chain = Chain::of(&machine);
    let mut offsets = [None; 9];
    offsets[0] = Some([0.0; 9]);
    let settings = Settings {
        coordinates,
        tolerance_mm: 8e-5,
        tolerance_rad: 4e-8,
        offsets,
        tools: Vec::new(),
        tool_length_mm: None,
        initial: "G21 G90 G17 G94 G54 G49".into(),
        mark: false,
        decimals: [6, 6],
        keeps_arcs: true,
    };
    let mut compensator = Compensator::new(&machine, &chain, settings).expect("compensator");
    let mut out = Vec::new();
    let mut written = 0;
    compensator.line(b"G0 X0 Y0 Z0 A-20 C0\n", &mut out).expect("line");
    for k in 0..LINES {
        let t = k as f64 * 1e-4;
        let line = format!(
            "G1 X{:.4} Y{:.4} Z{:.4} A{:.4} C{:.4} F3000\n",
            60.0 * t.cos(),
            60.0 * t.sin(),
            5.0 * (3.0 * t).sin(),
            -30.0 + 10.0 * (0.7 * t).sin(),
            40.0 * (0.3 * t).sin()
        );
        compensator.line(line.as_bytes(), &mut out).expect("line");
        written += out.len();
        out.clear();
    }
    written
}

#[divan::bench(sample_count = 1, sample_size = 1)]
fn a_million_lines_in_axis_coordinates() -> usize {
    corrected(Coordinates::Axes)
}

#[divan::bench(sample_count = 1, sample_size = 1)]
fn a_million_lines_in_workpiece_coordinates() -> usize {
    corrected(Coordinates::Workpiece)
}
