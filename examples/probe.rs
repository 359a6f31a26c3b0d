use fiveaxis::*;
fn main() {
    for file in std::env::args().skip(1) {
        let session = match load::load_session(std::path::Path::new(&file)) {
            Ok(s) => s,
            Err(e) => {
                println!("{e}");
                continue;
            }
        };
        let t = std::time::Instant::now();
        let fit = match identify::identify(&session, &identify::Options::default()) {
            Ok(f) => f,
            Err(e) => {
                println!("{file}: {e}");
                continue;
            }
        };
        println!(
            "{file}: rms {:.3} um, noise {:?}, {:?}, left out {}",
            fit.rms_mm * 1e3,
            fit.noise[0],
            t.elapsed(),
            fit.tests.iter().map(|t| t.left_out.len()).sum::<usize>()
        );
        let truth: Option<serde_json::Value> = {
            let p = std::path::Path::new(&file);
            let case = p.parent().unwrap().file_name().unwrap().to_string_lossy().to_string();
            std::fs::read_to_string(p.parent().unwrap().parent().unwrap().join(format!("truth/{case}.json")))
                .ok()
                .and_then(|s| serde_json::from_str(&s).ok())
        };
        for a in &fit.ambiguities {
            println!("  * {}", a.says);
        }
        for (u, e) in fit.unknowns.iter().zip(&fit.estimates) {
            let k = u.measure.to_output(1.0);
            let tv = truth.as_ref().and_then(|t| t["pige"][&u.label].as_f64());
            let z = tv.map(|t| (e.value * k - t) / (e.sigma * k));
            println!(
                "  {:40} {:9.3} +- {:8.3} rel {:8.3} prior {:.2} setup {:.2} {} {} truth {:?} z {:?}",
                u.label,
                e.value * k,
                e.sigma * k,
                e.sigma_to_spindle_ball * k,
                e.prior_share,
                e.setup_share,
                if e.determined { "DET" } else { "-" },
                if e.relative_to_spindle_ball { "REL" } else { "" },
                tv,
                z.map(|z| (z * 100.0).round() / 100.0)
            );
        }
    }
}
