//! The survey as one HTML page that opens offline: the answer about single pivot setups, counts by family, the table with filters. It computes no plans.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::survey::{ENVELOPE, Family, Outcome, tallies};
use crate::units::Measure;

const STYLE: &str = "body{font:14px/1.5 sans-serif;margin:2em auto;max-width:76em;padding:0 1em;color:#222}\
table{border-collapse:collapse;margin:.6em 0}td,th{border:1px solid #bbb;padding:2px 8px;text-align:right}\
td:first-child,th:first-child,td.l,th.l{text-align:left}th{background:#f2f2f2}#rows th{cursor:pointer;position:sticky;top:0}\
.no{color:#999}code{font-family:monospace}details{margin:.4em 0}input,select{font:inherit;margin-right:1em}";

const SCRIPT: &str = "const t=document.getElementById('rows'),b=t.tBodies[0],f=document.getElementById('f'),o=document.getElementById('o'),c=document.getElementById('c');\
function show(){let n=0;for(const r of b.rows){const s=r.cells[0].textContent.toLowerCase().includes(f.value.toLowerCase())&&(o.value==''||r.dataset.k.split(' ').includes(o.value));r.hidden=!s;n+=s}c.textContent=n+' topologies'}\
f.oninput=o.onchange=show;show();\
[...t.tHead.rows[0].cells].forEach((h,i)=>h.onclick=()=>{const d=h.dataset.d=h.dataset.d=='1'?'-1':'1';const v=r=>{const x=r.cells[i].textContent;return x==''?NaN:isNaN(x)?x:+x};\
[...b.rows].sort((p,q)=>{const x=v(p),y=v(q);return (x!==x)-(y!==y)||(x>y?1:x<y?-1:0)*d}).forEach(r=>b.append(r))});";

/// How the page begins: a page of an older survey is known by it.
pub const PAGE_HEAD: &str =
    "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>Survey of five-axis topologies</title>";

/// The page.
pub fn survey_page(outcomes: &[Outcome]) -> String {
    let mut out = String::new();
    let _ = write!(
        out,
        "{PAGE_HEAD}<style>{STYLE}</style></head><body><h1>What a ball bar determines on {} serial five-axis topologies</h1>",
        outcomes.len()
    );
    answer(&mut out, outcomes);
    families(&mut out, outcomes);
    conditions(&mut out);
    rows(&mut out, outcomes);
    let _ = write!(out, "<script>{SCRIPT}</script></body></html>");
    out
}

/// Which configurations can be fully tested with one pivot setup?
fn answer(out: &mut String, outcomes: &[Outcome]) {
    let full: Vec<&Outcome> = outcomes.iter().filter(|outcome| outcome.is_fully_tested_from_one_pivot()).collect();
    let all_errors = full.iter().filter(|outcome| outcome.visible == outcome.errors).count();
    let _ = write!(
        out,
        "<h2>Which configurations can be fully tested with one pivot setup?</h2><p><b>{} of {}</b>: {all_errors} with all their errors \
         determined, {} with all that ball-bar lengths can show of them (the rest moves the balls alike, or only against pivots \
         whose places nobody knows). Codes by where the rotary axes are, workpiece first:</p>",
        full.len(),
        outcomes.len(),
        full.len() - all_errors
    );
    // by the order of rotary axes and bed: what the linear axes' places change is then seen as a share
    let mut groups: BTreeMap<(Family, String), (Vec<&Outcome>, usize)> = BTreeMap::new();
    for outcome in outcomes {
        let pattern: String = outcome.code.to_string().chars().filter(|c| "wABCbt[]".contains(*c)).collect();
        let group = groups.entry((outcome.family, pattern)).or_default();
        group.1 += 1;
        if outcome.is_fully_tested_from_one_pivot() {
            group.0.push(outcome);
        }
    }
    let _ = write!(
        out,
        "<table><tr><th>rotary axes</th><th class=\"l\">family</th><th>topologies</th><th>fully tested from one pivot</th>\
         <th>quickest, min</th><th class=\"l\">for example</th></tr>"
    );
    for ((family, pattern), (full, count)) in &groups {
        let minutes = |outcome: &Outcome| outcome.one_pivot.map_or(f64::MAX, |one| one.minutes);
        let quickest = full.iter().min_by(|a, b| minutes(a).total_cmp(&minutes(b)));
        let _ = write!(
            out,
            "<tr><td><code>{pattern}</code></td><td class=\"l\">{}</td><td>{count}</td><td>{}</td><td>{}</td><td class=\"l\"><code>{}</code></td></tr>",
            family.name(),
            full.len(),
            quickest.map_or_else(String::new, |outcome| format!("{:.1}", minutes(outcome))),
            quickest.map_or_else(String::new, |outcome| outcome.code.to_string())
        );
    }
    out.push_str("</table><details><summary>All of them</summary><p><code>");
    let codes: Vec<String> = full.iter().map(|outcome| outcome.code.to_string()).collect();
    out.push_str(&codes.join(" "));
    out.push_str("</code></p></details>");
}

fn families(out: &mut String, outcomes: &[Outcome]) {
    out.push_str(
        "<h2>By family</h2><table><tr><th>family</th><th>topologies</th><th>all errors determined</th>\
         <th>all visible errors determined</th><th>these from one pivot</th><th>no test possible</th></tr>",
    );
    for tally in tallies(outcomes) {
        let _ = write!(
            out,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            tally.family.name(),
            tally.topologies,
            tally.all_determined,
            tally.all_visible_determined,
            tally.from_one_pivot,
            tally.without_test
        );
    }
    out.push_str("</table>");
}

fn conditions(out: &mut String) {
    let _ = write!(
        out,
        "<h2>Conditions</h2><p>{ENVELOPE}</p><p><b>determined</b>: less than half of the error's variance stems from priors of errors, \
         pivots and bars, the spindle ball held, as in <code>identify</code>. <b>visible</b>: reachable setups would determine it if \
         nothing stood in the way of any. <b>from one pivot</b>: the best plan whose tests all use one pivot setup determines every \
         visible error. Times include mounting. Sigmas are those of the determined errors of the cheapest plan that reaches 4 µm and 4″.</p>"
    );
}

fn rows(out: &mut String, outcomes: &[Outcome]) {
    out.push_str(
        "<h2>All topologies</h2><p><input id=\"f\" placeholder=\"code contains, e.g. wCA\"><select id=\"o\"><option value=\"\">all</option>\
         <option value=\"one\">fully tested from one pivot</option><option value=\"all\">all errors determined</option>\
         <option value=\"table-table\">table-table</option><option value=\"table-head\">table-head</option>\
         <option value=\"head-head\">head-head</option><option value=\"none\">no test possible</option></select><span id=\"c\"></span></p>\
         <table id=\"rows\"><thead><tr><th>code</th><th class=\"l\">family</th><th>errors</th><th>visible</th><th>determined</th>\
         <th class=\"l\">undetermined</th><th>tests</th><th>pivot setups</th><th>minutes</th><th>worst µm</th><th>worst ″</th>\
         <th>one pivot: determined</th><th>one pivot: minutes</th></tr></thead><tbody>",
    );
    for outcome in outcomes {
        let mut kinds = vec![outcome.family.name()];
        for (holds, kind) in [
            (outcome.is_fully_tested_from_one_pivot(), "one"),
            (outcome.determined == outcome.errors, "all"),
            (outcome.tests == 0, "none"),
        ] {
            if holds {
                kinds.push(kind);
            }
        }
        let number =
            |value: Option<f64>, digits: usize| value.map_or_else(String::new, |value| format!("{value:.digits$}"));
        let _ = write!(
            out,
            "<tr data-k=\"{}\"><td><code>{}</code></td><td class=\"l\">{}</td><td>{}</td><td>{}</td><td>{}</td><td class=\"l\">{}</td>\
             <td>{}</td><td>{}</td><td>{:.1}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            kinds.join(" "),
            outcome.code,
            outcome.family.name(),
            outcome.errors,
            outcome.visible,
            outcome.determined,
            outcome.undetermined.join(" "),
            outcome.tests,
            outcome.pivot_setups,
            outcome.minutes,
            number(outcome.position_mm.map(|mm| Measure::Length.to_output(mm)), 2),
            number(outcome.orientation_rad.map(|rad| Measure::Angle.to_output(rad)), 2),
            outcome.one_pivot.map_or_else(String::new, |one| one.determined.to_string()),
            number(outcome.one_pivot.map(|one| one.minutes), 1)
        );
    }
    out.push_str("</tbody></table>");
}
