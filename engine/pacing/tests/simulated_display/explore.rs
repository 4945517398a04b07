//! scratch
use antumbra_pacing::*;
use crate::{measure::*, run::*, scenario::*};
#[test]
fn explore() {
    let only: Option<u64> = std::env::var("SEED").ok().and_then(|s| s.parse().ok());
    let reports = if std::env::var("MISSING").is_ok() { PresentReports::Missing } else { PresentReports::Times };
    let n: u64 = std::env::var("N").ok().and_then(|s| s.parse().ok()).unwrap_or(1000);
    let mode = match std::env::var("MODE").as_deref() { Ok("mailbox") => PresentMode::Mailbox, Ok("immediate") => PresentMode::Immediate, Ok("relaxed") => PresentMode::FifoRelaxed, _ => PresentMode::Fifo };
    let (mut missed, mut total, mut over, mut means, mut p99s) = (0, 0, 0, vec![], vec![]);
    let mut bad = vec![];
    let t = std::time::Instant::now();
    for seed in 0..n {
        if only.is_some_and(|o| o != seed) { continue; }
        let mut s = Scenario::random(seed, mode);
        s.reports = reports;
        s.frames = 400;
        if reports == PresentReports::Missing { s.images = s.images.min(3); s.options.queue_limit = s.options.queue_limit.max(s.images as u32); }
        if std::env::var("NAIVE").is_ok() { s.policy = Policy::AtOnce; }
        let r = run(&s);
        let (m, a) = r.missed_refreshes(120);
        missed += m; total += a;
        if r.most_queued() > s.options.queue_limit as usize { over += 1; }
        let e = r.latency_excess(120);
        means.push(mean(&e)); p99s.push(quantile(&e, 0.99));
        bad.push((m, quantile(&e,0.99), seed));
        if only.is_some() {
            println!("{s:?}");
            for (i, o) in r.outcomes.iter().enumerate() { let p = s.period(); let w = |t: f64| (t - 5e9) / p;
                println!("{i} start {:.3} fin {:.3} shown {:?} exp {:?} q {}", w(o.start), w(o.finish), o.shown.map(w), o.expected.map(w), o.queued); }
            println!("steps {}", r.steps);
        }
    }
    bad.sort_by(|a, b| b.0.cmp(&a.0));
    println!("missed {missed}/{total} = {:.4}%  over {over}  mean excess {:.3} max {:.3}; p99 med {:.3} max {:.3} time {:?}", 100.0*missed as f64/total as f64, mean(&means), quantile(&means, 1.0), quantile(&p99s, 0.5), quantile(&p99s, 1.0), t.elapsed());
    println!("worst missed {:?}", &bad[..bad.len().min(8)]);
    bad.sort_by(|a, b| b.1.total_cmp(&a.1));
    println!("worst p99 {:?}", &bad[..bad.len().min(8)]);
}
