//! A fit as one self-contained HTML page: no scripts, no fonts or pictures to fetch, light and dark, fit for printing.

use std::fmt::Write as _;

use super::fit::{FitJson, LocationErrorJson};
use super::fit_text::{by_remedy, reasons, setup_rows, unit, verdict};
use crate::identify::Fit;
use crate::methods::CircleFigures;
use crate::report::pictures::cards::{Card, cards};
use crate::report::pictures::trace_plots::{PassPlots, RoundPlots};
use crate::report::wording::markup::{escape, session_head};
use crate::report::wording::number::shown;
use crate::report::wording::sense_words::as_marks_show;
use crate::session::Session;

/// The page.
pub fn fit_page(session: &Session, json: &FitJson, fit: &Fit, plots: &[PassPlots]) -> String {
    let (name, machine) = (&json.session, (json.machine.as_str(), json.code.as_str()));
    let kind = if session.has_parts() { "Identification" } else { "Ball-bar identification" };
    let mut page = session_head(kind, name, name, machine, "");
    doubts(&mut page, json);
    figures(&mut page, json);
    errors(&mut page, json, fit);
    open_directions(&mut page, fit);
    control(&mut page, json);
    senses(&mut page, json);
    setups(&mut page, json);
    circles_section(&mut page, &json.circles);
    tests(&mut page, json, plots);
    method(&mut page, json);
    let _ = write!(
        page,
        "<footer>fiveaxis {} · every number of this page stands in <code>fiveaxis identify --json</code></footer>\n\
         </main>\n</body>\n</html>\n",
        env!("CARGO_PKG_VERSION")
    );
    page
}

/// What stands against the fit, before any figure of it.
fn doubts(page: &mut String, json: &FitJson) {
    for (k, reason) in reasons(json).iter().enumerate() {
        let or = if k > 0 { "or " } else { "" };
        let _ = writeln!(page, "<p class=\"warning\">{or}{}</p>", escape(reason));
    }
    for warning in &json.warnings {
        let _ = writeln!(page, "<p class=\"warning\">{}</p>", escape(warning));
    }
}

fn figures(page: &mut String, json: &FitJson) {
    let determined = json.location_errors.values().filter(|error| error.determined).count();
    let left_out = match json.left_out {
        0 => "none left out".to_string(),
        count => format!("{count} left out as gross outliers"),
    };
    let shown = [
        Card {
            label: "determined",
            figure: format!("{determined} of {}", json.location_errors.len()),
            note: "location errors".to_string(),
        },
        Card {
            label: "residual", figure: format!("{:.2} µm", json.rms_um), note: "rms, measured − model".to_string()
        },
        Card {
            label: "noise",
            figure: format!("{:.2} µm", json.noise_um),
            note: match json.repeats_um {
                Some(repeats_um) => format!("of one reading, fitted; rows repeat to {repeats_um:.2} µm"),
                None => "of one reading, fitted".to_string(),
            },
        },
        Card {
            label: "readings",
            figure: json.readings.to_string(),
            note: format!("in {} tests; {left_out}", json.tests.len()),
        },
    ];
    cards(page, &shown);
}

fn errors(page: &mut String, json: &FitJson, fit: &Fit) {
    page.push_str(
        "<section>\n<h2>Location errors</h2>\n<div class=\"wide\"><table>\n<thead><tr><th>error</th><th class=\"n\">value</th>\
         <th class=\"n\">σ</th><th>unit</th><th class=\"n\">σ to spindle ball</th><th class=\"n\">σ of noise alone</th><th>data | priors</th><th>verdict</th></tr></thead>\n<tbody>\n",
    );
    let names: Vec<&String> =
        fit.unknowns.iter().filter(|unknown| !unknown.quantity.is_setup()).map(|unknown| &unknown.label).collect();
    for name in &names {
        let error = &json.location_errors[*name];
        let (value, sigma) = shown(error.value, error.sigma);
        let class = if error.determined { "" } else { " class=\"open\"" };
        let _ = writeln!(
            page,
            "<tr{class}><th scope=\"row\">{}</th><td class=\"n\">{}</td><td class=\"n\">{sigma}</td><td>{}</td>\
             <td class=\"n\">{}</td><td class=\"n\">{}</td><td>{}</td><td>{}</td></tr>",
            escape(name),
            minus(&value),
            unit(error),
            shown(0.0, error.sigma_to_spindle_ball).1,
            shown(0.0, error.sigma_noise).1,
            share_bar(error),
            verdict(json, error)
        );
    }
    page.push_str("</tbody></table></div>\n<details><summary>What the signs mean on the machine</summary>\n<ul>\n");
    for name in names {
        let _ = writeln!(page, "<li>{}</li>", escape(&json.location_errors[name].sign));
    }
    page.push_str("</ul>\n</details>\n<p class=\"small\">σ is one standard deviation and includes the priors and what the linear axes may be off. <em>Determined</em>: the data and not a \
        prior fix it (share of priors below half), given the spindle ball and exact linear axes. <em>Relative to the spindle ball</em>: it moves with \
        the assumed place of that ball; the column σ to spindle ball holds if the ball stands exactly where the session says, σ of noise alone if the linear axes are exact too.</p>\n</section>\n");
}

/// Data and prior shares as a bar.
fn share_bar(error: &LocationErrorJson) -> String {
    let prior = (100.0 * error.prior_share).clamp(0.0, 100.0);
    let data = 100.0 - prior;
    format!(
        "<svg class=\"bar\" width=\"110\" height=\"12\" viewBox=\"0 0 110 12\" role=\"img\" aria-label=\"{data:.0} % data, {prior:.0} % priors\">\
         <rect class=\"data\" width=\"{:.1}\" height=\"12\"/><rect class=\"prior\" x=\"{:.1}\" width=\"{:.1}\" height=\"12\"/></svg> {data:.0} | {prior:.0} %",
        1.1 * data,
        1.1 * data,
        1.1 * prior
    )
}

fn open_directions(page: &mut String, fit: &Fit) {
    page.push_str("<section>\n<h2>What the recordings cannot tell apart</h2>\n");
    if fit.ambiguities.is_empty() {
        page.push_str("<p>Nothing: every free error is seen on its own.</p>\n");
    }
    for (remedy, facts) in by_remedy(&fit.ambiguities) {
        page.push_str("<div class=\"open-group\">");
        let list = |page: &mut String, facts: &[&str]| {
            page.push_str("<ul>");
            for fact in facts {
                let _ = write!(page, "<li>{}</li>", escape(fact));
            }
            page.push_str("</ul>");
        };
        let split = facts.len().min(6);
        list(page, &facts[..split]);
        if facts.len() > split {
            let _ = write!(page, "<details><summary>{} more</summary>", facts.len() - split);
            list(page, &facts[split..]);
            page.push_str("</details>");
        }
        let _ = writeln!(page, "<p class=\"remedy\">→ {}</p></div>", escape(remedy));
    }
    page.push_str("</section>\n");
}

fn senses(page: &mut String, json: &FitJson) {
    if let Some(shown) = as_marks_show(&json.senses) {
        let _ = writeln!(page, "<p>{}</p>", escape(&shown));
    }
    let untold: Vec<&str> =
        json.senses.iter().map(|sense| sense.says.as_str()).filter(|says| !says.is_empty()).collect();
    if untold.is_empty() {
        return;
    }
    page.push_str("<section>\n<h2>All this holds for the senses of the machine file</h2>\n<ul>\n");
    for says in untold {
        let _ = writeln!(page, "<li>{}</li>", minus(&escape(says)));
    }
    page.push_str("</ul>\n</section>\n");
}

fn control(page: &mut String, json: &FitJson) {
    if let Some(why) = &json.control_withheld {
        let _ = writeln!(page, "<section>\n<h2>Numbers for the control</h2>\n<p>None: {}</p>\n</section>", escape(why));
        return;
    }
    if json.control.is_empty() {
        return;
    }
    page.push_str(
        "<section>\n<h2>Numbers for the control</h2>\n<div class=\"wide\"><table>\n<thead><tr><th>axis</th><th>enter</th>\
         <th>direction of the line</th></tr></thead>\n<tbody>\n",
    );
    for control in &json.control {
        let direction: Vec<String> = control.direction.iter().map(|value| minus(&format!("{value:.7}"))).collect();
        let says = control.says.strip_prefix(&format!("{}: ", control.axis)).unwrap_or(&control.says);
        let class = if control.told { "" } else { " class=\"open\"" };
        let _ = writeln!(
            page,
            "<tr{class}><th scope=\"row\">{}</th><td>{}</td><td><code>({})</code></td></tr>",
            escape(&control.axis),
            minus(&escape(says)),
            direction.join(", ")
        );
    }
    page.push_str(
        "</tbody></table></div>\n<p class=\"small\">Where controls keep them: Heidenhain, the rotary axes' places in the kinematics \
         description; Siemens, <code>$TC_CARR</code> vectors or MD24500, MD24550, MD24558; Fanuc, parameters 19700–19705 (tables) and \
         19709–19714 (heads); LinuxCNC, <code>x-rot-point … z-offset</code> of the trunnion kinematics, whose offsets run from C to A. Check the control's own \
         convention of signs with one test after entering.</p>\n</section>\n",
    );
}

fn setups(page: &mut String, json: &FitJson) {
    page.push_str(
        "<section>\n<h2>Balls and bars</h2>\n<p class=\"small\">Fitted place minus the session's, µm, one standard deviation.</p>\n\
         <div class=\"wide\"><table>\n<thead><tr><th>setup</th><th class=\"n\">x or length</th><th class=\"n\">y</th><th class=\"n\">z</th>\
         <th class=\"n\">spread before</th></tr></thead>\n<tbody>\n",
    );
    for (name, values) in setup_rows(json) {
        let _ = write!(page, "<tr><th scope=\"row\">{}</th>", escape(&name));
        for k in 0..3 {
            let cell = values.get(k).map_or(String::new(), |setup| {
                let (value, sigma) = shown(setup.value_um, setup.sigma_um);
                format!("{} ± {sigma}", minus(&value))
            });
            let _ = write!(page, "<td class=\"n\">{cell}</td>");
        }
        let spread = values.first().map_or(0.0, |setup| (setup.spread_um * 1e6).round() / 1e6);
        let _ = writeln!(page, "<td class=\"n\">{spread}</td></tr>");
    }
    page.push_str("</tbody></table></div>\n</section>\n");
}

/// ISO 230-4 figures of planar circles; nothing without circles.
pub fn circles_section(page: &mut String, circles: &[CircleFigures]) {
    if circles.is_empty() {
        return;
    }
    page.push_str(
        "<section>\n<h2>Planar circles after ISO 230-4</h2>\n<div class=\"wide\"><table>\n<thead><tr><th>plane</th><th class=\"n\">feed</th>\
         <th class=\"n\">G ccw</th><th class=\"n\">G cw</th><th class=\"n\">G(b)</th><th class=\"n\">H</th><th class=\"n\">centre</th>\
         <th class=\"n\">squareness</th><th class=\"n\">scale mismatch</th><th>backlash</th></tr></thead>\n<tbody>\n",
    );
    let um = |value: Option<f64>| value.map_or("–".into(), |value| minus(&format!("{value:.2}")));
    for circle in circles {
        let backlash: Vec<String> =
            circle.axes.iter().map(|axis| format!("{} {}", escape(&axis.axis), um(axis.backlash_um))).collect();
        let _ = writeln!(
            page,
            "<tr><th scope=\"row\">{}</th><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>\
             <td class=\"n\">{}</td><td class=\"n\">{}, {}</td><td class=\"n\">{} µm/m</td><td class=\"n\">{} µm</td><td>{}</td></tr>",
            escape(&circle.plane),
            circle.feed_mm_per_min.map_or("–".into(), |feed| format!("{feed:.0}")),
            um(circle.ccw.as_ref().map(|figures| figures.circular_deviation_um)),
            um(circle.cw.as_ref().map(|figures| figures.circular_deviation_um)),
            um(circle.bidirectional_circular_deviation_um),
            um(circle.circular_hysteresis_um),
            minus(&format!("{:.2}", circle.centre_um[0])),
            minus(&format!("{:.2}", circle.centre_um[1])),
            minus(&format!("{:.1}", circle.squareness.angle_um_per_m)),
            minus(&format!("{:.2}", circle.scale_mismatch_um)),
            backlash.join(", ")
        );
    }
    page.push_str("</tbody></table></div>\n<p class=\"small\">µm unless stated; feed in mm/min.</p>\n</section>\n");
}

fn tests(page: &mut String, json: &FitJson, plots: &[PassPlots]) {
    page.push_str(
        "<section>\n<h2>Tests</h2>\n<p class=\"small\">Round plots show deviations from the nominal length, outward longer; both directions \
         of a pass stand in one. The angle is where the bar points, from the ball that stands to the ball that moves, \
         counter-clockwise from the first letter's axis (ISO 230-4); for a bar that keeps its direction it is the position of \
         the axis. Grey readings and crosses were left out.</p>\n<div class=\"tests\">\n",
    );
    for (index, plot) in plots.iter().enumerate() {
        page.push_str("<div class=\"pass\">\n");
        if let Some(round) = &plot.round {
            page.push_str("<figure>\n");
            round_plots(page, index, round);
            page.push_str("</figure>\n");
        }
        for (name, residual) in plot.tests.iter().zip(&plot.residuals) {
            let rms = json.tests.iter().find(|test| test.name == *name).map_or(f64::NAN, |test| test.rms_um);
            let _ = writeln!(
                page,
                "<figure id=\"test-{}\">{residual}<figcaption>{} · residual {rms:.2} µm rms</figcaption>\n</figure>",
                identifier(name),
                escape(name)
            );
        }
        page.push_str("</div>\n");
    }
    page.push_str("</div>\n</section>\n");
}

/// A round plot with a switch that takes the centre off; it works without a script.
pub fn round_plots(page: &mut String, index: usize, round: &RoundPlots) {
    let Some(centred) = &round.centred else {
        page.push_str(&round.as_read);
        return;
    };
    let _ = writeln!(
        page,
        "<div class=\"round\"><input type=\"checkbox\" id=\"centre-{index}\"><label for=\"centre-{index}\">take the centre off</label>\n\
         <div class=\"as-read\">{}</div>\n<div class=\"centred\">{centred}</div></div>",
        round.as_read
    );
}

fn method(page: &mut String, json: &FitJson) {
    let noise = &json.noise;
    let _ = write!(
        page,
        "<section>\n<h2>How it was found</h2>\n<p>One weighted least-squares fit over all recordings, with the location errors, the place of \
         every pivot and spindle ball and the error of every bar as unknowns; balls and bars with the session's spreads as prior \
         knowledge. {}Gross outliers are judged on the residuals of a robust fit. Readings are weighted by a noise model fitted to the \
         residuals (white {:.3} µm, autoregressive {:.3} µm with a correlation of {:.3} from sample to sample, drift {:.3} µm by the end of \
         a trace), so that neighbouring readings do not count as independent.</p>\n</section>\n",
        json.linear_axes.as_ref().map_or(String::new(), |budget| format!(
            "What the linear axes may be off is fitted beside them, with this budget (one standard deviation): {}. ",
            escape(&budget.says)
        )),
        noise.white_um,
        noise.ar_um,
        noise.ar_rho,
        noise.drift_um
    );
}

/// Text with a true minus sign before numbers.
fn minus(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut characters = text.chars().peekable();
    let mut last = ' ';
    while let Some(character) = characters.next() {
        let before_number = characters.peek().is_some_and(char::is_ascii_digit) && !last.is_alphanumeric();
        out.push(if character == '-' && before_number { '−' } else { character });
        last = character;
    }
    out
}

/// A name as an identifier of the page and of files: letters, digits and dashes.
pub fn identifier(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' || c == '_' { c } else { '-' }).collect()
}
