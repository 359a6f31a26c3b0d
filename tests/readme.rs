//! The README's commands run as shown and print what is shown; its links and verbs exist.

use std::path::Path;
use std::process::Command;

fn readme() -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md")).unwrap()
}

/// Blocks of a language, in order.
fn blocks(text: &str, language: &str) -> Vec<String> {
    let opening = format!("```{language}\n");
    text.split(&opening).skip(1).map(|rest| rest.split("```").next().unwrap().to_string()).collect()
}

/// First place where texts differ by more than one step of a number's last digit: processors add up in different orders.
fn difference(printed: &str, shown: &str) -> Option<String> {
    if printed.trim_end().lines().count() != shown.trim_end().lines().count() {
        return Some("another number of lines".into());
    }
    let number = |word: &str| {
        let word = word.trim_matches([',', '(', ')']);
        let decimals = word.split_once('.').map_or(0, |(_, decimals)| decimals.len());
        Some((word.parse::<f64>().ok()?, decimals))
    };
    for (printed, shown) in printed.lines().zip(shown.lines()) {
        let (left, right): (Vec<&str>, Vec<&str>) =
            (printed.split_whitespace().collect(), shown.split_whitespace().collect());
        let is_same = |(left, right): (&&str, &&str)| match (number(left), number(right)) {
            (Some((a, decimals)), Some((b, shown))) => {
                decimals == shown && (a - b).abs() < 1.5 * 10f64.powi(-(decimals as i32)) && (decimals > 0 || a == b)
            }
            _ => left == right,
        };
        // lines under headers are as long as their table is wide
        let is_rule = right.first().is_some_and(|word| word.starts_with('─'));
        if left.len() != right.len() || !(is_rule || left.iter().zip(&right).all(is_same)) {
            return Some(format!("'{printed}' where the page shows '{shown}'"));
        }
    }
    None
}

#[test]
fn commands_print_what_the_pages_on_plans_and_diagnosis_show() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let of_page = |page: &str| blocks(&std::fs::read_to_string(root.join("docs").join(page)).unwrap(), "console");
    let (plans, diagnoses) = (of_page("plan.md"), of_page("diagnosis.md"));
    assert!(plans.len() >= 2 && !diagnoses.is_empty());
    let consoles = [plans, diagnoses].concat();
    for console in consoles {
        let (command, shown) = console.split_once('\n').unwrap();
        let arguments = command.strip_prefix("$ fiveaxis ").expect(command).split_whitespace();
        let output = Command::new(env!("CARGO_BIN_EXE_fiveaxis")).args(arguments).current_dir(root).output().unwrap();
        assert!(output.status.success(), "{command}: {}", String::from_utf8_lossy(&output.stderr));
        let printed = String::from_utf8(output.stdout).unwrap();
        if let Some(difference) = difference(&printed, shown) {
            panic!("{command}: {difference}\nprinted:\n{printed}");
        }
    }
}

#[test]
fn commands_print_what_the_readme_shows() {
    let text = readme();
    let scratch = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    // the files of the worked example, as a reader would type them
    for block in blocks(&text, "yaml") {
        let (name, content) = block.split_once('\n').unwrap();
        let file = scratch.path().join(name.trim_start_matches("# "));
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        std::fs::write(file, content).unwrap();
    }
    let examples = scratch.path().join("examples/real/positioner");
    std::fs::create_dir_all(&examples).unwrap();
    for entry in std::fs::read_dir(root.join("examples/real/positioner")).unwrap() {
        let file = entry.unwrap().path();
        std::fs::copy(&file, examples.join(file.file_name().unwrap())).unwrap();
    }
    let consoles = blocks(&text, "console");
    assert!(consoles.len() >= 2);
    for console in consoles {
        let (command, shown) = console.split_once('\n').unwrap();
        let arguments = command.strip_prefix("$ cargo run --release -- ").expect(command);
        let output = Command::new(env!("CARGO_BIN_EXE_fiveaxis"))
            .args(arguments.split_whitespace())
            .current_dir(scratch.path())
            .output()
            .unwrap();
        assert!(output.status.success(), "{command}: {}", String::from_utf8_lossy(&output.stderr));
        let printed = String::from_utf8(output.stdout).unwrap();
        if let Some(difference) = difference(&printed, shown) {
            panic!("{command}: {difference}\nprinted:\n{printed}");
        }
    }
}

#[test]
fn links_and_verbs_of_the_readme_exist() {
    let text = readme();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for link in text.split("](").skip(1).map(|rest| rest.split(')').next().unwrap()) {
        assert!(root.join(link).is_file(), "{link} is not there");
    }
    let output = Command::new(env!("CARGO_BIN_EXE_fiveaxis")).arg("--help").output().unwrap();
    let help = String::from_utf8(output.stdout).unwrap();
    let verbs: Vec<&str> = text
        .lines()
        .filter_map(|line| line.strip_prefix("| `")?.split('`').next())
        .filter(|verb| verb.chars().all(|c| c.is_ascii_lowercase()))
        .collect();
    assert!(verbs.len() >= 5);
    for verb in verbs {
        assert!(help.lines().any(|line| line.trim_start().starts_with(&format!("{verb} "))), "no verb {verb}");
    }
}
