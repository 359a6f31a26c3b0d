//! Text as HTML, SVG and URDF write it, and how the pages of reports begin. It knows no results.

/// Style of all reports.
const STYLE: &str = include_str!("../page.css");

/// Text that may stand in XML: markup escaped, characters that XML 1.0 forbids left out.
pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            letter if letter.is_control() && !matches!(letter, '\t' | '\n') => {}
            letter => escaped.push(letter),
        }
    }
    escaped
}

/// The beginning of a page about a session, up to its first section.
pub fn session_head(kind: &str, title: &str, name: &str, (machine, code): (&str, &str), own_style: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>{}</title>\n<style>\n{STYLE}{own_style}</style>\n</head>\n\
         <body>\n<main>\n<header>\n<p class=\"kind\">{kind}</p>\n<h1>{}</h1>\n\
         <p class=\"machine\">{} <code>{}</code></p>\n</header>\n",
        escape(title),
        escape(name),
        escape(machine),
        escape(code)
    )
}

/// The beginning of a page about a machine, up to its first section; `says` stands below its name.
pub fn machine_head(kind: &str, title: &str, machine: &str, says: &str) -> String {
    let machine = escape(machine);
    format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"><title>{title} of {machine}</title><style>{STYLE}</style></head><body><main><header><p class=\"kind\">{kind}</p><h1>{machine}</h1><p class=\"machine\">{says}</p></header>\n"
    )
}
