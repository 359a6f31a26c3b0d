//! Questions on a terminal for what the options leave open: a wrong answer is told and asked for again. It judges no answer.

use std::io::{BufRead, IsTerminal, Write};

use crate::verbs::Refusal;
use crate::verbs::output::complain;

/// A figure that an option gives or an answer.
#[derive(Clone, Copy)]
pub(super) struct Question {
    pub option: &'static str,
    pub asks: &'static str,
}

impl Question {
    /// The line about a figure that no option gave.
    pub fn missing(self) -> String {
        format!("{} is missing: {}", self.option, self.asks)
    }
}

/// Whether someone sits at a terminal.
pub(super) fn at_terminal() -> bool {
    std::io::stdin().is_terminal() && std::io::stderr().is_terminal()
}

/// Asks until `read` takes the answer; Enter alone is the answer `offer`. The end of the input ends the verb.
pub(super) fn ask<T>(
    question: &str,
    offer: Option<&str>,
    read: impl Fn(&str) -> Result<T, Refusal>,
) -> Result<T, Refusal> {
    loop {
        let answer = line(question, offer)?;
        match read(answer.as_deref().or(offer).unwrap_or_default()) {
            Ok(value) => return Ok(value),
            Err(why) => complain(&why),
        }
    }
}

/// Asks as [`ask`] does, where Enter alone leaves the figure open.
pub(super) fn ask_or_leave<T>(
    question: &str,
    offer: &str,
    read: impl Fn(&str) -> Result<T, Refusal>,
) -> Result<Option<T>, Refusal> {
    loop {
        let Some(answer) = line(question, Some(offer))? else { return Ok(None) };
        match read(&answer) {
            Ok(value) => return Ok(Some(value)),
            Err(why) => complain(&why),
        }
    }
}

/// One answer without blanks around it; `None` for Enter alone.
fn line(question: &str, offer: Option<&str>) -> Result<Option<String>, Refusal> {
    let mut terminal = std::io::stderr().lock();
    let offer = offer.map(|offer| format!(" [{offer}]")).unwrap_or_default();
    write!(terminal, "{question}{offer}: ").and_then(|()| terminal.flush())?;
    let mut answer = Vec::new();
    if std::io::stdin().lock().read_until(b'\n', &mut answer)? == 0 {
        return Err(format!(
            "the input ended at the question '{question}'; nothing is written, start again or give options"
        )
        .into());
    }
    let answer = String::from_utf8_lossy(&answer).trim().to_string();
    Ok(Some(answer).filter(|answer| !answer.is_empty()))
}
