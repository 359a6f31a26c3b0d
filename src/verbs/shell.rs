//! `fiveaxis completions` and `fiveaxis man`: what a shell and a manual reader take from the command line's own description.

use std::path::PathBuf;

use clap::{Args, Command};
use clap_complete::Shell;

use super::Refusal;
use super::output::{OutputFolder, print};

/// Name of the program.
const PROGRAM: &str = "fiveaxis";

/// Arguments of `completions`.
#[derive(Args)]
#[command(after_help = "Example: fiveaxis completions bash > ~/.local/share/bash-completion/completions/fiveaxis")]
pub struct CompletionsArguments {
    /// Shell that will read the script
    shell: Shell,
}

/// Arguments of `man`.
#[derive(Args)]
#[command(after_help = "Examples:\n  fiveaxis man | man -l -\n  fiveaxis man --out man/man1")]
pub struct ManArguments {
    /// Verb whose page is printed; that of the program itself unless given
    verb: Option<String>,
    /// Write the pages of the program and all its verbs into this folder
    #[arg(long, value_name = "DIR", conflicts_with = "verb")]
    out: Option<PathBuf>,
}

/// Prints the script that completes verbs, options and file names.
pub fn completions(arguments: &CompletionsArguments, mut command: Command) -> Result<(), Refusal> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut command, PROGRAM, &mut script);
    print(&String::from_utf8_lossy(&script))
}

/// Prints or writes manual pages.
pub fn man(arguments: &ManArguments, command: Command) -> Result<(), Refusal> {
    let mut command = command.name(PROGRAM);
    command.build();
    let verbs = || command.get_subcommands().filter(|verb| verb.get_name() != "help");
    if let Some(folder) = &arguments.out {
        let mut output = OutputFolder::default();
        output.add(format!("{PROGRAM}.1"), page(&command)?);
        for verb in verbs() {
            output.add(format!("{PROGRAM}-{}.1", verb.get_name()), page(verb)?);
        }
        return output.write(folder, &[]);
    }
    let Some(name) = &arguments.verb else { return print(&String::from_utf8_lossy(&page(&command)?)) };
    match verbs().find(|verb| verb.get_name() == name) {
        Some(verb) => print(&String::from_utf8_lossy(&page(verb)?)),
        None => {
            let known: Vec<&str> = verbs().map(Command::get_name).collect();
            Err(format!("there is no verb '{name}' (allowed: {})", known.join(", ")).into())
        }
    }
}

fn page(command: &Command) -> Result<Vec<u8>, Refusal> {
    let mut roff = Vec::new();
    // `fiveaxis plan` is the page fiveaxis-plan(1)
    let name = command.get_bin_name().unwrap_or(PROGRAM).replace(' ', "-");
    clap_mangen::Man::new(command.clone()).title(name).render(&mut roff)?;
    Ok(roff)
}
