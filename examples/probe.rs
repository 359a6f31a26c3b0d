use fiveaxis::*;
fn main() {
    for file in std::env::args().skip(1) {
        let t0 = std::time::Instant::now();
        let session = match load::load_session(std::path::Path::new(&file)) { Ok(s) => s, Err(e) => { println!("{e}"); continue } };
        let chain = chain::Chain::of(&session.machine);
        let setups = session::Setups::of(&session);
        let free = identify::default_free(&session.machine);
        let unknowns = identify::unknowns(&session, &setups, &free, identify::FreePrior::of(&session.machine));
        let problem = identify::Problem::new(&session, &chain, &setups, unknowns).unwrap();
        let fit = match identify::fit(&problem) { Ok(f) => f, Err(e) => { println!("{file} {e}"); continue } };
        let t1 = t0.elapsed();
        let values: Vec<f64> = fit.estimates.iter().map(|e| e.value).collect();
        let context = effects::Context::of(&session, &chain).unwrap();
        let kept: Vec<Vec<bool>> = fit.tests.iter().map(|t| t.kept.clone()).collect();
        let mut ground = diagnose::Ground::new(&context, &problem, &values, kept.clone());
        let families = diagnose::families(&ground);
        ground.prepare(families.iter().flat_map(|f| &f.outlets));
        let (thin_session, groups) = diagnose::thin(&session, &kept);
        let thin_context = effects::Context::of(&thin_session, &chain).unwrap();
        let mut coarse = ground.thinned(&thin_context, &groups);
        coarse.prepare(families.iter().flat_map(|f| &f.outlets));
        let t2 = t0.elapsed();
        let search = diagnose::search(&diagnose::Grounds { fine: &ground, coarse: &coarse }, &families);
        println!("{file}: fit {t1:?} ground {:?} total {:?}, {} families {} cells, floor {:?} after {:?}", t2 - t1, t0.elapsed(), families.len(), families.iter().map(|f| f.grid.len()).sum::<usize>(), search.floor[0], search.noise_after[0]);
        for found in &search.found {
            let c = &found.chosen;
            println!("   FOUND {:.1} {} {} {:?} {:?} amp {:?}", found.log_odds, c.effect.kind, c.effect.place.name(&session.machine), families[c.family].outlets.iter().map(|o| o.name(&session.machine)).collect::<Vec<_>>(), c.effect.parameters, c.judgement.amplitudes.iter().map(|a| (a * 100.0).round() / 100.0).collect::<Vec<_>>());
        }
    }
}
