//! The matrix.
use pfront_study::stability::*;
#[test]
fn look() {
    let length = if std::env::var("FULL").is_ok() { Length::Full } else { Length::Quick };
    for row in ROWS {
        let clock = std::time::Instant::now();
        let mut scenes = row.scenes(length).unwrap();
        let out = row.run(&mut scenes, &[1, 2, 7, 64, 1024], &mut || ()).unwrap();
        println!("{} {:.1} s, oracle {}", row.name, clock.elapsed().as_secs_f64(), out.by_oracle);
        let mut f = out.findings.clone();
        f.sort_by_key(|f| (f.measure, f.method.name()));
        for f in f {
            println!(
                "  {:15} {:18} {:5} {:8.3} / {:6.3}{} {} {}  {}",
                f.measure,
                f.method.name(),
                f.workers,
                f.figure,
                f.limit,
                if f.widened { "~" } else { " " },
                if f.holds() { "ok" } else { "FAIL" },
                f.sound,
                f.place
            );
        }
    }
}
