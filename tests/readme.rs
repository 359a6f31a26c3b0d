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
    let examples = scratch.path().join("examples/thesis/chapter5");
    std::fs::create_dir_all(&examples).unwrap();
    for entry in std::fs::read_dir(root.join("examples/thesis/chapter5")).unwrap() {
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
        assert_eq!(printed.trim_end(), shown.trim_end(), "{command}");
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
