//! `pfront-lab record`, `replay`, `profile` and `regret`.

use super::{folder, out, refused};
use std::fs;
use std::path::Path;

/// The lines of a run, each split at tabs.
fn lines(text: &str) -> Vec<Vec<&str>> {
    text.lines().map(|line| line.split('\t').collect()).collect()
}

/// The pairs of each frame of a pair file, which are sorted.
fn pairs(file: &Path) -> Vec<Vec<[u32; 2]>> {
    let bytes = fs::read(file).unwrap();
    let words: Vec<u32> =
        bytes.as_chunks().0.iter().map(|&word| u32::from_le_bytes(word)).collect();
    let (mut rest, mut frames) = (&words[4..], Vec::new());
    while let [count, 0, more @ ..] = rest {
        let (pairs, behind) = more.split_at(2 * *count as usize);
        frames.push(pairs.as_chunks().0.to_vec());
        rest = behind;
    }
    assert!(bytes.starts_with(b"TRICOLP1") && words[2] as usize == frames.len() && rest.is_empty());
    assert!(frames.iter().all(|pairs| pairs.is_sorted()));
    frames
}

#[test]
fn recordings_replay_alike_on_threads_and_on_a_gpu() {
    let folder = folder();
    let at = folder.path();
    for (scene, size, kind) in [("worm-gear", 8000, 0), ("sheet", 2000, 1), ("swarm", 9_000, 2)] {
        let recorded = out(at, &format!("record {scene} w.tcw --size {size} --frames 3"));
        assert!(recorded.contains("3 frames"), "{recorded}");
        assert_eq!(fs::read(at.join("w.tcw")).unwrap()[8], kind, "{scene}");
        let mut answers = Vec::new();
        for on in ["--threads 1", "--threads 3", "--backend gpu", "--warm 2"] {
            let text = out(at, &format!("replay w.tcw {on} --pairs w.tcp"));
            let lines = lines(&text);
            assert_eq!(lines.len(), 5, "{text}");
            assert_eq!((lines[0][0], lines[4][0]), ("BUILD", "RSS"));
            assert!(lines[4][1].parse::<u64>().unwrap() > 1 << 20);
            assert_eq!(lines[4][2], "bytes");
            let frames = pairs(&at.join("w.tcp"));
            for (i, (line, frame)) in lines[1..4].iter().zip(&frames).enumerate() {
                let wanted = [i, frame.len()].map(|n| n.to_string());
                assert_eq!([line[0], line[1], line[4]], ["FRAME", &wanted[0], &wanted[1]]);
                // Milliseconds down to the nanosecond, by the clock on the wall and by that of the process.
                for time in [line[2], line[3], line[5], line[6]] {
                    assert_eq!(time.split_once('.').unwrap().1.len(), 6, "{text}");
                }
            }
            answers.push(frames);
        }
        assert!(answers.iter().all(|answer| *answer == answers[0]), "{scene}");
        let any = out(at, "replay w.tcw --mode any --frames 1");
        let meets = u8::from(!answers[0][0].is_empty()).to_string();
        assert_eq!((lines(&any)[1][4], any.lines().count()), (&meets[..], 3), "{any}");
    }
}

#[test]
fn meshes_sway_or_take_turns() {
    let folder = folder();
    let at = folder.path();
    // Two triangles of which the second pierces the first, or not.
    for (file, x) in [("a.obj", 0.2), ("b.obj", 9.0)] {
        let second = format!("v {x} 0.2 -1\nv {x} 0.2 1\nv {x} 0.4 1\n");
        let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{second}f 1 2 3\nf 4 5 6\n");
        fs::write(at.join(file), text).unwrap();
    }
    let counts = |of: &str| {
        let text = out(at, &format!("replay {of} --frames 3"));
        let lines = lines(&text);
        lines[1..4].iter().map(|line| line[4].to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(counts("a.obj,b.obj"), ["1", "0", "1"]);
    // The first pierces what the second copy has of it.
    assert_eq!(counts("a.obj")[0], "3");
    assert!(out(at, "record a.obj w.tcw").contains("64 frames, 2 objects"));
    assert_eq!(counts("w.tcw"), counts("a.obj"));
}

#[test]
fn files_are_replaced_only_by_whole_ones() {
    let folder = folder();
    let at = folder.path();
    out(at, "record sheet s.tcw --size 800 --frames 3");
    let whole = fs::read(at.join("s.tcw")).unwrap();
    // The pairs go where the workload is read from.
    out(at, "replay s.tcw --pairs s.tcw");
    assert_eq!(pairs(&at.join("s.tcw")).len(), 3);
    fs::write(at.join("s.tcw"), &whole).unwrap();
    // A frame that cannot be run leaves what stood there.
    let mut broken = whole.clone();
    let last = broken.len() - 4;
    broken[last..].copy_from_slice(&f32::NAN.to_le_bytes());
    fs::write(at.join("nan.tcw"), broken).unwrap();
    fs::write(at.join("old.tcp"), "as it was").unwrap();
    assert!(refused(at, "replay nan.tcw --pairs old.tcp").contains("frame 2"));
    assert_eq!(fs::read(at.join("old.tcp")).unwrap(), b"as it was");
    assert!(refused(at, "replay s.tcw --mode any --pairs x.tcp").contains("--mode all"));
    let left = fs::read_dir(at).unwrap().count();
    assert_eq!(left, 3, "s.tcw, nan.tcw and old.tcp");
}

#[test]
fn frames_are_profiled_on_threads_and_on_a_gpu() {
    let folder = folder();
    let asked = "profile sheet worm-gear --size 2000 --frames 3 -p 1,2 --gpu";
    let table = out(folder.path(), asked);
    for part in ["sheet: ms", "worm-gear: ms", "balance", "a GPU is timed for two objects"] {
        assert!(table.contains(part), "no '{part}' in:\n{table}");
    }
    let rows = |first: &str| table.lines().filter(|line| line.starts_with(first)).count();
    assert_eq!([rows("   1 "), rows("   2 ")], [2, 2], "{table}");
    assert!(rows(" GPU ") > 3, "{table}");
}

#[test]
fn choices_are_compared_with_fixed_plans() {
    let folder = folder();
    let asked = "regret --frames 3 --size 2000 --rounds 1 --threads 2 --backend gpu";
    let table = out(folder.path(), asked);
    for part in ["one thread, ms", "2 threads, ms", "GPU, ms", "choice, ms", "regret: mean"] {
        assert!(table.contains(part), "no '{part}' in:\n{table}");
    }
    assert_eq!(table.lines().count(), 1 + 1 + 14 + 1, "{table}");
    let played = out(folder.path(), "regret worm-gear --frames 5 --rounds 1 --backend cpu");
    assert!(played.lines().any(|line| line.starts_with("worm-gear")), "{played}");
}
