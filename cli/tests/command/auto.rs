//! `--backend auto`, and `pfront regret`.

use super::{command, folder, out, refused};
use std::fs;

#[test]
fn auto_answers_as_all_others_do_and_says_who_did() {
    let folder = folder();
    let at = folder.path();
    for (arguments, said) in [
        ("pairs a.obj b.obj --format csv", "one thread: "),
        ("self a.obj --format csv", "one thread: "),
        ("any a.obj b.obj", "one thread: "),
        ("replay epicyclic --frames 3 --pairs auto.tcp", "3 frames: "),
    ] {
        let auto = format!("{arguments} --backend auto");
        let ended = command(at, &auto).output().unwrap();
        let [found, why] = [ended.stdout, ended.stderr].map(|o| String::from_utf8(o).unwrap());
        assert!(ended.status.success() && why.starts_with(said), "{auto}: {why}");
        if !arguments.starts_with("replay") {
            assert_eq!(found, out(at, arguments), "{arguments}");
        }
    }
    out(at, "replay epicyclic --frames 3 --pairs cpu.tcp");
    let [auto, cpu] = ["auto.tcp", "cpu.tcp"].map(|file| fs::read(at.join(file)).unwrap());
    assert!(auto == cpu);
}

#[test]
fn regret_of_a_few_cases() {
    let folder = folder();
    let at = folder.path();
    let facts = |on: &str| {
        let asked = format!("regret --quick --cases 4 --seed 5 --threads 2 --csv r.csv {on}");
        let table = out(at, &asked);
        for part in
            ["seed 5, 2 threads", "pair 1", "self 3", "scene 4", "4 cases", "regret      mean"]
        {
            assert!(table.contains(part), "no '{part}' in:\n{table}");
        }
        let csv = fs::read_to_string(at.join("r.csv")).unwrap();
        let head = csv.lines().next().unwrap();
        assert_eq!(head.contains(",GPU_ms,"), on.contains("gpu"), "{head}");
        let facts = |line: &str| line.split(',').take(6).collect::<Vec<_>>().join(",");
        csv.lines().skip(1).map(facts).collect::<Vec<_>>()
    };
    let cpu = facts("--backend cpu");
    assert_eq!(cpu.len(), 4);
    assert_eq!(cpu, facts("--backend gpu --rounds 2"));
    assert!(refused(at, "regret --cases 0").contains("invalid value"));
}
