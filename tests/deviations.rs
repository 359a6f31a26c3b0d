//! Deviations in place of lengths, and a zero set by hand: read in every form, fitted as computed independently here.

use std::fs;
use std::path::Path;
use std::process::Command;

use fiveaxis::chain::{Chain, Composition};
use fiveaxis::identify::{Fit, FreePrior, Options, Problem, Weighting, default_free, identify, minimise, unknowns};
use fiveaxis::load::load_session;
use fiveaxis::methods::circles;
use fiveaxis::session::{LengthColumn, Session, Setups, Zero};
use fiveaxis::simulate::simulate;
use fiveaxis::statistics::NoiseModel;
use nalgebra::{DMatrix, DVector, Rotation3, Vector3};

/// A table on the bed; the spindle stands where the session puts it.
const MACHINE: &str = "name: table\ncode: \"[wCbXYZt]\"\naxes: {C: {range: [-360, 360]}}\ndirections: carried\nlinear_axes: {positioning: 0 um/m, straightness: 0 um/m, squareness: 0 urad}\n";
/// Bar length, mm.
const BAR_MM: f64 = 100.0;
/// Spindle ball of each test, mm; the pivot ball turns on a radius of 60 mm.
const SPINDLE_MM: [[f64; 3]; 3] = [[0.0, 0.0, 80.0], [0.0, 0.0, -80.0], [60.0, 100.0, 0.0]];
const PIVOT_MM: [f64; 3] = [60.0, 0.0, 0.0];
/// Sweep of each test, deg: the ball of the last one comes within the gauge's stroke about C 0 alone.
const SWEEPS_DEG: [(f64, f64); 3] = [(-180.0, 180.0), (-180.0, 180.0), (-2.0, 2.0)];
const ROWS: usize = 61;
/// What stands elsewhere than stated: EX0C, EY0C (mm), EA0C, EB0C (rad), pivot and spindle balls (mm), zero (mm).
const TRUTH: [f64; 17] =
    [21e-3, -13e-3, 4e-5, -3e-5, 8e-3, -5e-3, 11e-3, 1e-3, 2e-3, -1e-3, 1e-3, -2e-3, 2e-3, -1e-3, 1e-3, 1e-3, 0.37];

/// Length between the balls by its own formula, plus the zero's offset: C is `Tx Ty Rx Ry` and then the turn.
fn reading_mm(x: &[f64], test: usize, angle_rad: f64) -> f64 {
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), angle_rad);
    let tilt =
        Rotation3::from_axis_angle(&Vector3::x_axis(), x[2]) * Rotation3::from_axis_angle(&Vector3::y_axis(), x[3]);
    let pivot = Vector3::from(PIVOT_MM) + Vector3::new(x[4], x[5], x[6]);
    let k = 7 + 3 * test;
    let spindle = Vector3::from(SPINDLE_MM[test]) + Vector3::new(x[k], x[k + 1], x[k + 2]);
    (Vector3::new(x[0], x[1], 0.0) + tilt * (turn * pivot) - spindle).norm() + x[16]
}

fn angle_deg(test: usize, row: usize) -> f64 {
    let (from, to) = SWEEPS_DEG[test];
    from + (to - from) * row as f64 / (ROWS - 1) as f64
}

/// Time (s), C (deg) and deviation (mm) of each row, and what writes them as a file.
type Rows = [(f64, f64, f64)];
type Writer = dyn Fn(&Rows) -> Vec<u8>;

fn session_yaml(more: &str) -> String {
    let mut text = String::from("machine: machine.yaml\ntests:\n");
    for (test, at) in SPINDLE_MM.iter().enumerate() {
        text += &format!(
            "  - {{name: t{test}, recording: t{test}.csv, bar_length: {BAR_MM}, pivot: {{link: C, at: {PIVOT_MM:?}}}, spindle_ball: {{link: Z, at: {at:?}}}, positions: {{X: 0, Y: 0, Z: 0}}{more}}}\n"
        );
    }
    text
}

/// Session in a folder of its own, readings written by `write` from C (deg) and deviation (mm).
fn session(more: &str, write: impl Fn(&Rows) -> Vec<u8>) -> Result<Session, String> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("machine.yaml"), MACHINE).unwrap();
    fs::write(folder.path().join("session.yaml"), session_yaml(more)).unwrap();
    for test in 0..SPINDLE_MM.len() {
        let rows: Vec<(f64, f64, f64)> = (0..ROWS)
            .map(|row| {
                let angle = angle_deg(test, row);
                (0.1 * row as f64, angle, reading_mm(&TRUTH, test, angle.to_radians()) - BAR_MM)
            })
            .collect();
        fs::write(folder.path().join(format!("t{test}.csv")), write(&rows)).unwrap();
    }
    let name = folder.path().display().to_string();
    load_session(&folder.path().join("session.yaml")).map_err(|why| why.to_string().replace(&format!("{name}/"), ""))
}

fn plain(rows: &Rows) -> Vec<u8> {
    let lines = rows.iter().map(|(time, angle, deviation)| format!("{time},{angle},{deviation:.10}\n"));
    format!("time_s,C_deg,deviation_mm\n{}", lines.collect::<String>()).into_bytes()
}

/// As a spreadsheet in a country of decimal commas saves it, columns in another order, behind another program's lines.
fn foreign(rows: &Rows, separator: &str) -> String {
    let comma = |value: f64| format!("{value:.7}").replace('.', ",");
    let lines = rows
        .iter()
        .map(|&(time, angle, deviation)| [comma(1e3 * deviation), comma(angle), comma(time)].join(separator) + "\r\n");
    let header = ["deviation_um", "C_deg", "time_s"].join(separator);
    format!("Ballbar recorder 4.2{separator}A, B; C\r\n\r\nStart: 12:04\r\n{header}\r\n{}", lines.collect::<String>())
}

#[test]
fn every_form_of_the_file_holds_the_same_lengths() {
    let due = session("", plain).unwrap();
    let wide = |text: String, unit: fn(u16) -> [u8; 2]| {
        [0xfeff].into_iter().chain(text.encode_utf16()).flat_map(unit).collect()
    };
    let unmarked = |text: String, unit: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(unit).collect();
    let forms: [(&str, Box<Writer>); 8] = [
        ("semicolons", Box::new(|rows| foreign(rows, ";").into_bytes())),
        ("tabs", Box::new(|rows| foreign(rows, "\t").into_bytes())),
        ("UTF-16, little end first", Box::new(move |rows| wide(foreign(rows, ";"), u16::to_le_bytes))),
        ("UTF-16, big end first", Box::new(move |rows| wide(foreign(rows, "\t"), u16::to_be_bytes))),
        ("UTF-16 without its mark", Box::new(move |rows| unmarked(foreign(rows, ";"), u16::to_le_bytes))),
        (
            "UTF-16 without its mark, big end first",
            Box::new(move |rows| unmarked(foreign(rows, "\t"), u16::to_be_bytes)),
        ),
        ("carriage returns alone", Box::new(|rows| foreign(rows, ";").replace("\r\n", "\r").into_bytes())),
        (
            "quoted decimal commas",
            Box::new(|rows| {
                let quoted = |value: f64| format!("\"{}\"", format!("{value:.9}").replace('.', ","));
                let lines = rows.iter().map(|&(t, c, d)| format!("{t},{},{}\n", quoted(c), quoted(d)));
                format!("# time_s,C_deg,deviation_mm\n{}", lines.collect::<String>()).into_bytes()
            }),
        ),
    ];
    for (name, write) in forms {
        let found = session("", write).unwrap_or_else(|why| panic!("{name}: {why}"));
        for (found, due) in found.tests.iter().zip(&due.tests) {
            let (found, due) = (found.recording.as_ref().unwrap(), due.recording.as_ref().unwrap());
            for (found, due) in found.time_s().unwrap().iter().zip(due.time_s().unwrap()) {
                assert!((found - due).abs() < 1e-6, "{name}: {found} for {due}");
            }
            for (found, due) in found.length_mm.iter().zip(&due.length_mm) {
                // both files round: to 1e-7 µm, 1e-9 and 1e-10 mm
                assert!((found - due).abs() < 1.1e-9, "{name}: {found} for {due}");
            }
        }
    }
}

/// Gauss–Newton with priors on the model above, derivatives by differences: values and standard deviations.
fn computed(noise_mm: f64, zero_mm: f64) -> (DVector<f64>, DVector<f64>) {
    let count = TRUTH.len();
    let mut sigma = vec![1.0, 1.0, 0.1f64.to_radians(), 0.1f64.to_radians()];
    sigma.extend([20e-3; 3]);
    sigma.extend([3e-3; 9]);
    sigma.push(zero_mm);
    let mut x = DVector::zeros(count);
    let mut normal = DMatrix::zeros(count, count);
    for _ in 0..6 {
        normal = DMatrix::from_diagonal(&DVector::from_iterator(count, sigma.iter().map(|s| s.powi(-2))));
        let mut right = -&normal * &x;
        for test in 0..SPINDLE_MM.len() {
            for row in 0..ROWS {
                let at = angle_deg(test, row).to_radians();
                let off = reading_mm(&TRUTH, test, at) - reading_mm(x.as_slice(), test, at);
                let step = 1e-4;
                let slope = DVector::from_fn(count, |k, _| {
                    let [mut up, mut down] = [x.clone(), x.clone()];
                    (up[k], down[k]) = (up[k] + step, down[k] - step);
                    (reading_mm(up.as_slice(), test, at) - reading_mm(down.as_slice(), test, at)) / (2.0 * step)
                });
                normal += &slope * slope.transpose() / noise_mm.powi(2);
                right += slope * (off / noise_mm.powi(2));
            }
        }
        x += normal.clone().cholesky().unwrap().solve(&right);
    }
    let covariance = normal.cholesky().unwrap().inverse();
    (x, DVector::from_fn(count, |k, _| covariance[(k, k)].sqrt()))
}

fn value(fit: &Fit, label: &str) -> (f64, f64, bool) {
    let k = fit.unknowns.iter().position(|unknown| unknown.label == label).unwrap_or_else(|| panic!("no {label}"));
    (fit.estimates[k].value, fit.estimates[k].sigma, fit.estimates[k].determined)
}

#[test]
fn a_free_zero_is_fitted_as_computed_independently() {
    const NOISE_MM: f64 = 1e-3;
    let session = session(", zero: free", plain).unwrap();
    assert!(session.tests.iter().all(|test| test.zero == Zero::Free));
    let (chain, setups) = (Chain::of(&session.machine), Setups::of(&session));
    let (free, prior) = (default_free(&session.machine), FreePrior::of(&session.machine));
    let problem = Problem::new(&session, &chain, &setups, unknowns(&session, &setups, &free, prior)).unwrap();
    let noise = vec![NoiseModel::white(NOISE_MM); session.tests.len()];
    let kept = vec![vec![true; ROWS]; session.tests.len()];
    let start = vec![0.0; problem.unknowns.len()];
    let solution = minimise(&problem, &start, &Weighting::Whitened { noise: &noise, kept: &kept });
    let count = problem.unknowns.len();
    let information = &solution.information + DMatrix::identity(count, count);
    let covariance = information.cholesky().unwrap().inverse();
    let (x, sigma) = computed(NOISE_MM, 1.0);
    let labels = [
        (0, "EX0C"),
        (1, "EY0C"),
        (2, "EA0C"),
        (3, "EB0C"),
        (4, "pivot on C at (60, 0, 0), x"),
        (6, "pivot on C at (60, 0, 0), z"),
        (16, "zero of bar 100, free zero"),
    ];
    for (due, label) in labels {
        let k =
            problem.unknowns.iter().position(|unknown| unknown.label == label).unwrap_or_else(|| panic!("no {label}"));
        let found_sigma = covariance[(k, k)].sqrt() * problem.unknowns[k].prior_sigma;
        // steps of 1e-4 mm leave the differences good to a millionth; the solver stops below a thousandth of its sigma
        assert!(
            (solution.values[k] - x[due]).abs() < 1e-3 * sigma[due],
            "{label}: {} for {}",
            solution.values[k],
            x[due]
        );
        assert!((found_sigma / sigma[due] - 1.0).abs() < 1e-3, "{label}: sigma {found_sigma} for {}", sigma[due]);
    }
    let fit = identify(&session, &Options::default()).unwrap();
    let (zero, zero_sigma, _) = value(&fit, "zero of bar 100, free zero");
    assert!((zero - TRUTH[16]).abs() < 4.0 * zero_sigma, "{zero} ± {zero_sigma}");
}

#[test]
fn a_free_zero_takes_away_what_the_bars_length_told() {
    // one sweep about the axis, the bar along its radius: a cup farther out and a longer bar move all readings alike
    let mut calibrated = session("", plain).unwrap();
    calibrated.tests.truncate(1);
    calibrated.tests[0].pivot.at = Vector3::new(BAR_MM, 0.0, 0.0);
    calibrated.tests[0].spindle_ball.at = Vector3::zeros();
    let traces = simulate(&calibrated, Composition::Exact).unwrap();
    calibrated.tests[0].recording.as_mut().unwrap().length_mm = traces[0].length_mm.clone();
    let mut free = calibrated.clone();
    free.tests[0].zero = Zero::Free;
    free.tests[0].recording.as_mut().unwrap().length_mm.iter_mut().for_each(|length| *length += 0.3);
    let [free, calibrated] = [free, calibrated].map(|session| identify(&session, &Options::default()).unwrap());
    let pivot = "pivot on C at (100, 0, 0), x";
    let (known, unknown) = (value(&calibrated, pivot).1, value(&free, pivot).1);
    // calibrated to 0.5 µm, or with nothing but the 20 µm of a cup placed by hand
    assert!((known - 0.5e-3).abs() < 0.05e-3 && (unknown - 20e-3).abs() < 0.1e-3, "{known} {unknown}");
    let (zero, zero_sigma, determined) = value(&free, "zero of bar 100, free zero");
    assert!((zero_sigma - 20e-3).abs() < 0.1e-3 && (zero - 0.3).abs() < 1e-3, "{zero} ± {zero_sigma}");
    // what is known of it comes from the cup's spread and from no reading
    assert!(!determined);
}

#[test]
fn figures_that_need_a_radius_are_left_out_of_circles_with_a_free_zero() {
    let file = Path::new("examples/gallery/03-lost-motion/session.yaml");
    let mut session = load_session(file).unwrap();
    let calibrated = circles(&session).unwrap();
    for test in &mut session.tests {
        test.zero = Zero::Free;
        test.recording.as_mut().unwrap().length_mm.iter_mut().for_each(|length| *length += 0.2);
    }
    let free = circles(&session).unwrap();
    assert_eq!(free.len(), calibrated.len());
    for (free, calibrated) in free.iter().zip(&calibrated) {
        assert_eq!(free.radius_deviation_um, None);
        assert_eq!(free.mean_bidirectional_radial_deviation_um, None);
        let (free, calibrated) = (free.ccw.as_ref().unwrap(), calibrated.ccw.as_ref().unwrap());
        assert_eq!((free.radial_deviation_max_um, free.radial_deviation_min_um), (None, None));
        assert!(calibrated.radial_deviation_max_um.is_some());
        // an offset of the radius is no form: 0.2 mm · 35 µm of centre / 100 mm at second order
        assert!((free.circular_deviation_um - calibrated.circular_deviation_um).abs() < 0.1);
    }
}

#[test]
fn wrong_deviations_get_one_message() {
    let header = |from: &'static str, to: &'static str| {
        move |rows: &Rows| String::from_utf8(plain(rows)).unwrap().replacen(from, to, 1).into_bytes()
    };
    let scaled = |factor: f64, offset: f64| {
        move |rows: &Rows| plain(&rows.iter().map(|&(t, c, d)| (t, c, factor * d + offset)).collect::<Vec<_>>())
    };
    let refused = |more: &str, write: &Writer| session(more, write).unwrap_err();
    assert_eq!(
        refused("", &header("deviation_mm", "deviation_inch")),
        "t0.csv:1: column 'deviation_inch': deviations are deviation_um or deviation_mm; rename or convert the column"
    );
    assert_eq!(
        refused("", &header("time_s,C_deg,deviation_mm", "length_mm,C_deg,deviation_mm")),
        "t0.csv:1: length_mm and deviation_mm both hold readings; keep one of them"
    );
    assert_eq!(
        refused(", zero: hand", &plain),
        "session.yaml:3:170: test 't0': zero 'hand' is not understood; write free (set by hand) or calibrated"
    );
    let lengths = refused("", &scaled(1.0, BAR_MM));
    assert!(lengths.ends_with("the column seems to hold absolute lengths, name it length_mm"), "{lengths}");
    let micrometres = refused("", &scaled(1e3, 0.0));
    assert!(micrometres.ends_with("the column seems to be in µm, name it deviation_um"), "{micrometres}");
    let millimetres = refused("", &header("deviation_mm", "deviation_um"));
    assert!(millimetres.ends_with("the column seems to be in mm, name it deviation_mm"), "{millimetres}");
    let without_bar = |more: &str| {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("machine.yaml"), MACHINE).unwrap();
        let text = session_yaml(more).replace(&format!("bar_length: {BAR_MM}, "), "");
        fs::write(folder.path().join("session.yaml"), text).unwrap();
        fs::write(folder.path().join("t0.csv"), plain(&[(0.0, 0.0, 0.0), (0.1, 1.0, 0.0)])).unwrap();
        let why = load_session(&folder.path().join("session.yaml")).unwrap_err().to_string();
        why.rsplit('/').next().unwrap_or_default().to_string()
    };
    assert_eq!(
        without_bar(""),
        "t0.csv:1: deviation_mm is the reading minus the bar's calibrated length, and the test states no bar_length; add it to the test"
    );
    assert!(without_bar(", zero: free").contains("test 't0': a free zero is an offset of a bar's readings"));
}

#[test]
fn simulate_writes_deviations_that_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        let ended = Command::new(env!("CARGO_BIN_EXE_fiveaxis")).args(arguments).output().unwrap();
        assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    };
    let file = "examples/thesis/chapter5/session.yaml";
    let [lengths, deviations] = ["lengths", "deviations"].map(|name| folder.path().join(name).display().to_string());
    run(&["simulate", file, "--out", &lengths]);
    run(&["simulate", file, "--out", &deviations, "--readings", "deviation-um"]);
    let session = load_session(Path::new(file)).unwrap();
    for test in &session.tests {
        let name = test.recording_file.as_ref().unwrap();
        let read = |folder: &str| {
            let file = Path::new(folder).join(name);
            let text = fs::read_to_string(&file).unwrap();
            fiveaxis::load::recording_from_csv(&file, &text, &session.machine, test.bar_length_mm).unwrap()
        };
        let (one, other) = (read(&lengths), read(&deviations));
        assert_eq!(other.column, LengthColumn::DeviationUm);
        for (one, other) in one.length_mm.iter().zip(&other.length_mm) {
            assert!((one - other).abs() < 1.1e-10, "{one} {other}");
        }
    }
}

#[test]
fn simulate_repeats_channels() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::write(
        path("machine.yaml"),
        "name: t\ncode: \"[wCAbYXZt]\"\naxes: {A: {origin: [0, 0, 0]}, C: {origin: [0, 0, 0]}}\n",
    )
    .unwrap();
    let session = "machine: machine.yaml\ntests:\n  - name: a\n    recording: a.csv\n    bar_length: 100\n    pivot: {link: C, at: [0, 0, 0]}\n    \
                   spindle_ball: {link: Z, at: [100, 0, 0]}\n    positions: {X: 0, Y: 0, Z: 0, A: 0}\n";
    fs::write(path("session.yaml"), session).unwrap();
    // a thermometer that is read less often, and a name with a comma
    let warm = |row: usize| if row.is_multiple_of(3) { format!("{}", 20.0 + 0.25 * row as f64) } else { String::new() };
    let rows: String = (0..40).map(|row| format!("{row},{}.0,{},{row},100.0\n", 6 * row, warm(row))).collect();
    fs::write(path("a.csv"), format!("time_s,C_deg,temperature_degC,\"load, spindle\",length_mm\n{rows}")).unwrap();
    let out = path("out");
    let simulated = Command::new(env!("CARGO_BIN_EXE_fiveaxis"))
        .args(["simulate", path("session.yaml").to_str().unwrap(), "--out", out.to_str().unwrap()])
        .output()
        .unwrap();
    assert!(simulated.status.success(), "{}", String::from_utf8_lossy(&simulated.stderr));
    let session = load_session(&path("session.yaml")).unwrap();
    let text = fs::read_to_string(out.join("a.csv")).unwrap();
    let read = fiveaxis::load::recording_from_csv(&out.join("a.csv"), &text, &session.machine, Some(100.0)).unwrap();
    let recorded = session.tests[0].recording.as_ref().unwrap();
    assert_eq!(recorded.channels.len(), 2);
    for ((name, values), (other, again)) in recorded.channels.iter().zip(&read.channels) {
        assert!(
            name == other
                && values.iter().zip(again).all(|(one, other)| one == other || one.is_nan() && other.is_nan())
        );
    }
}
