//! Pins exported for LinuxCNC's kinematics modules against the chain: the compiled modules themselves are loaded and asked
//! for 10,000 poses. Skipped, and said so, where modules or a C compiler are not there.
//!
//! `FIVEAXIS_LINUXCNC_MODULES` names the folder of the modules; else that of the distribution's package is taken.

use crate::skipped;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use fiveaxis::chain::Chain;
use fiveaxis::control::{held, module_of};
use fiveaxis::inverse::{Kinematics, Tool};
use fiveaxis::load::machine_from_yaml;
use fiveaxis::machine::Machine;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const POSES: usize = 10_000;
/// A nanometre.
const CLOSE_MM: f64 = 1e-6;

/// What a module needs of LinuxCNC's hardware layer, and a loop from joints to places.
const HOST: &str = r#"
#include <dlfcn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
static struct { char name[128]; void *at; int kind; } pins[64];
static int count;
static void *add(const char *name, int kind) {
    void *at = calloc(1, 64);
    snprintf(pins[count].name, 128, "%s", name); pins[count].at = at; pins[count].kind = kind; count++;
    return at;
}
int hal_init(const char *name) { (void)name; return 1; }
int hal_ready(int id) { (void)id; return 0; }
int hal_exit(int id) { (void)id; return 0; }
void *hal_malloc(long size) { return calloc(1, size + 64); }
int hal_pin_float_newf(int dir, void **at, int id, const char *form, ...) {
    char name[128]; va_list rest; (void)dir; (void)id;
    va_start(rest, form); vsnprintf(name, 128, form, rest); va_end(rest);
    *at = add(name, 0); return 0;
}
int hal_pin_bit_newf(int dir, void **at, int id, const char *form, ...) {
    char name[128]; va_list rest; (void)dir; (void)id;
    va_start(rest, form); vsnprintf(name, 128, form, rest); va_end(rest);
    *at = add(name, 1); return 0;
}
int hal_pin_float_new(const char *name, int dir, void **at, int id) { (void)dir; (void)id; *at = add(name, 0); return 0; }
int hal_pin_bit_new(const char *name, int dir, void **at, int id) { (void)dir; (void)id; *at = add(name, 1); return 0; }
int hal_pin_s32_new(const char *name, int dir, void **at, int id) { (void)dir; (void)id; *at = add(name, 2); return 0; }
int hal_pin_u32_new(const char *name, int dir, void **at, int id) { (void)dir; (void)id; *at = add(name, 2); return 0; }
void rtapi_print(const char *form, ...) { (void)form; }
void rtapi_print_msg(int level, const char *form, ...) { (void)level; (void)form; }
int main(int argc, char **argv) {
    void *module = dlopen(argv[1], RTLD_NOW | RTLD_GLOBAL);
    if (!module) { fprintf(stderr, "%s\n", dlerror()); return 1; }
    int (*begin)(void) = (int (*)(void))dlsym(module, "rtapi_app_main");
    int (*forward)(const double *, double *, const unsigned long *, unsigned long *) =
        (int (*)(const double *, double *, const unsigned long *, unsigned long *))dlsym(module, "kinematicsForward");
    if (begin()) { fprintf(stderr, "the module does not start\n"); return 1; }
    for (int k = 2; k < argc; k++) {
        char *value = strchr(argv[k], '='); *value++ = 0; int found = 0;
        for (int p = 0; p < count; p++) if (!strcmp(pins[p].name, argv[k])) {
            found = 1;
            if (pins[p].kind == 0) *(double *)pins[p].at = atof(value); else *(char *)pins[p].at = atoi(value);
        }
        if (!found) { fprintf(stderr, "no pin %s\n", argv[k]); for (int p = 0; p < count; p++) fprintf(stderr, "%s\n", pins[p].name); return 1; }
    }
    double joints[16]; unsigned long forth = 0, back = 0;
    for (;;) {
        memset(joints, 0, sizeof joints);
        for (int k = 0; k < 9; k++) if (scanf("%lf", joints + k) != 1) return 0;
        double place[16] = {0};
        forward(joints, place, &forth, &back);
        printf("%.17g %.17g %.17g\n", place[0], place[1], place[2]);
    }
}
"#;

fn modules() -> Option<PathBuf> {
    let named = std::env::var_os("FIVEAXIS_LINUXCNC_MODULES").map(PathBuf::from);
    let folder = named.unwrap_or_else(|| PathBuf::from("/usr/lib/linuxcnc/modules"));
    let is_there = folder.join("xyzac-trt-kins.so").is_file();
    let compiles = Command::new("cc").arg("--version").output().is_ok_and(|output| output.status.success());
    if is_there && compiles {
        return Some(folder);
    }
    skipped::skipped("LinuxCNC's kinematics modules or a C compiler are not there");
    None
}

/// Places of joints by a module.
fn places(
    folder: &Path,
    scratch: &Path,
    module: &str,
    pins: &[(String, f64)],
    joints: &[[f64; 9]],
) -> Vec<Vector3<f64>> {
    let (source, host) = (scratch.join("host.c"), scratch.join("host"));
    if !host.is_file() {
        std::fs::write(&source, HOST).expect("source");
        let built =
            Command::new("cc").args(["-O1", "-rdynamic", "-o"]).arg(&host).arg(&source).args(["-ldl", "-lm"]).output();
        let built = built.expect("cc");
        assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    }
    let mut running = Command::new(&host)
        .arg(folder.join(format!("{module}.so")))
        .args(pins.iter().map(|(pin, value)| format!("{module}.{pin}={value:.17e}")))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("host");
    let mut text = String::new();
    for row in joints {
        let row: Vec<String> = row.iter().map(|joint| format!("{joint:.17e}")).collect();
        let _ = writeln!(text, "{}", row.join(" "));
    }
    let mut input = running.stdin.take().expect("input");
    let writer = std::thread::spawn(move || input.write_all(text.as_bytes()));
    let output = running.wait_with_output().expect("output");
    let _ = writer.join();
    assert!(output.status.success(), "{module}: {}", String::from_utf8_lossy(&output.stderr));
    let line = |line: &str| {
        let numbers: Vec<f64> = line.split_whitespace().map(|word| word.parse().expect("number")).collect();
        Vector3::new(numbers[0], numbers[1], numbers[2])
    };
    String::from_utf8_lossy(&output.stdout).lines().map(line).collect()
}

/// Largest distance of the module's places from the erring machine's tool tips; both from those at zero.
fn off(machine: &Machine, module: &str, pins: &[(String, f64)], order: &[(&str, usize)], tip: Vector3<f64>) -> f64 {
    let Some(folder) = modules() else { return 0.0 };
    let scratch = tempfile::tempdir().expect("folder");
    let chain = Chain::of(machine);
    let kinematics = Kinematics::actual(machine, &chain, Tool::new(tip, Vector3::z()));
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let (mut joints, mut tips) = (Vec::new(), Vec::new());
    for pose in 0..=POSES {
        let mut row = [0.0; 9];
        let mut q = vec![0.0; machine.axes.len()];
        for &(name, place) in order {
            let axis = machine.axis_index(name).expect(name);
            let kind = machine.axes[axis].kind;
            let most = if kind == fiveaxis::machine::AxisKind::Linear { 300.0 } else { 100.0 };
            let value = if pose == 0 { 0.0 } else { random.random_range(-most..most) };
            row[place] = value;
            q[axis] = kind.from_file_unit(value);
        }
        joints.push(row);
        tips.push(kinematics.pose(&q).tip_mm);
    }
    let found = places(&folder, scratch.path(), module, pins, &joints);
    assert_eq!(found.len(), POSES + 1);
    let differences = found.iter().zip(&tips).map(|(place, tip)| ((place - found[0]) - (tip - tips[0])).norm());
    differences.fold(0.0, f64::max)
}

fn machine(yaml: &str) -> Machine {
    machine_from_yaml(Path::new("machine.yaml"), yaml.to_string()).expect("machine")
}

fn named(pins: &[(&'static str, f64)]) -> Vec<(String, f64)> {
    pins.iter().map(|(pin, value)| (pin.to_string(), *value)).collect()
}

#[test]
fn trunnion_modules_with_the_exported_pins_are_the_erring_chain() {
    if modules().is_none() {
        return;
    }
    let folder = modules().expect("there");
    for directions in ["iso841", "carried"] {
        for (tilt, errors, module) in
            [("A", "EY0A: 31 um, EZ0A: -47 um", "xyzac-trt-kins"), ("B", "EX0B: 31 um, EZ0B: -47 um", "xyzbc-trt-kins")]
        {
            let mut machine = machine(&format!(
                "name: m\ncode: \"[wC{tilt}bYXZt]\"\ndirections: {directions}\naxes:\n  C: {{origin: [10, -20, 0], errors: {{EX0C: 23 um, EY0C: -52 um}}}}\n  {tilt}: {{origin: [4, -35, -60], errors: {{{errors}}}}}\n"
            ));
            let order = [("X", 0), ("Y", 1), ("Z", 2), (tilt, 3), ("C", 4)];
            let exported = module_of(&held(&machine)).expect("a module");
            assert_eq!(exported.name, module);
            let bytes = std::fs::read(folder.join(format!("{module}.so"))).expect("module");
            let knows_both = bytes.windows(23).any(|window| window == b"conventional-directions");
            if directions == "iso841" && !knows_both {
                assert!(exported.pins.contains(&("conventional-directions", 1.0)));
                skipped::skipped("this version of LinuxCNC has no conventional-directions: tables turn right-handed");
                continue;
            }
            // slides of this machine carry the tool: they read alike whatever the sense
            let tip = Vector3::zeros();
            let found = off(&machine, module, &named(&exported.pins), &order, tip);
            println!("{module} {directions}: {:.3} nm", 1e6 * found);
            assert!(found < CLOSE_MM, "{module} {directions}: {found} mm");
            // nominal pins leave the errors, and the module cannot hold a tilt
            let mut nominal = machine.clone();
            nominal.axes.iter_mut().for_each(|axis| axis.location_errors = [0.0; 6]);
            let plain = module_of(&held(&nominal)).expect("a module");
            assert!(off(&machine, module, &named(&plain.pins), &order, tip) > 0.02);
            let c = machine.axis_index("C").expect("C");
            machine.axes[c].location_errors[3] = 1e-4;
            let tilted = module_of(&held(&machine)).expect("a module");
            assert!(off(&machine, module, &named(&tilted.pins), &order, tip) > 1e-3);
        }
    }
}

#[test]
fn head_modules_hold_the_pivot_length() {
    if modules().is_none() {
        return;
    }
    let pivot = 187.0 + 0.043;
    let bridge = machine(
        "name: m\ncode: \"[wbXYZCBt]\"\ndirections: iso841\naxes:\n  B: {origin: [0, 0, 187], reversed: true}\n",
    );
    assert_eq!(module_of(&held(&bridge)).expect("a module").name, "5axiskins");
    let order = [("X", 0), ("Y", 1), ("Z", 2), ("B", 3), ("C", 4)];
    let pins = [("pivot-length".to_string(), pivot)];
    // the tip hangs lower by what the pivot is longer
    let tip = Vector3::new(0.0, 0.0, 187.0 - pivot);
    let found = off(&bridge, "5axiskins", &pins, &order, tip);
    println!("5axiskins: {:.3} nm", 1e6 * found);
    assert!(found < CLOSE_MM, "{found} mm");
    let max = machine(
        "name: m\ncode: \"[wCbXYZBt]\"\ndirections: iso841\naxes:\n  B: {origin: [0, 0, 187], reversed: true}\n",
    );
    let exported = module_of(&held(&max)).expect("a module");
    assert_eq!(exported.name, "maxkins");
    let order = [("X", 0), ("Y", 1), ("Z", 2), ("B", 4), ("C", 5)];
    let found = off(&max, "maxkins", &pins, &order, tip);
    // its equations do not turn the head's swing into the frame of a turned table: what it cannot hold says so
    assert!(found > 100.0 && exported.not_held.contains("while C is turned"), "{found} mm");
    let found = off(&max, "maxkins", &pins, &order[..4], tip);
    println!("maxkins, C at 0: {:.3} nm", 1e6 * found);
    assert!(found < CLOSE_MM, "{found} mm");
}
