//! The same on a GPU, or on what stands in for one. Without any adapter these tests fail.

use super::{command, folder, out};
use pfront::gpu::{Gpu, wgpu::Features};
use std::path::Path;

#[test]
fn a_gpu_gives_the_same_answers() {
    let folder = folder();
    let at = folder.path();
    let both = |arguments: &str| {
        let [cpu, gpu] = ["cpu", "gpu"].map(|on| out(at, &format!("{arguments} --backend {on}")));
        assert_eq!(cpu, gpu, "{arguments}");
        // Standard error says who answered.
        let auto = command(at, &format!("{arguments} --backend auto")).output().unwrap();
        assert_eq!(cpu.as_bytes(), auto.stdout, "{arguments}");
        cpu
    };
    assert_eq!(both("pairs a.obj b.obj --csv"), "a,b\n0,0\n3,0\n");
    assert!(both("pairs a.obj b.obj --csv --contacts").contains("0,0,crossing,0.2,"));
    assert_eq!(both("pairs a.obj b.obj --csv --translate 5,0,0"), "a,b\n");
    assert_eq!(both("pairs a.obj a.obj --csv").lines().count(), 17);
    assert_eq!(both("self a.obj --csv --skip-neighbours"), "a,b\n");
    both("self a.obj --contacts");
    assert!(out(at, "any a.obj b.obj --backend gpu").ends_with(" meet\n"));
    let no = command(at, "any a.obj b.obj --translate 9,9,9 --backend gpu").output().unwrap();
    assert_eq!((no.status.code(), &no.stdout[..]), (Some(1), &b"nothing meets\n"[..]));
}

#[test]
fn auto_needs_no_adapter_and_says_what_it_took() {
    let folder = folder();
    for arguments in ["any a.obj b.obj", "pairs a.obj b.obj", "self a.obj"] {
        let (code, said) = without_drivers(folder.path(), &format!("{arguments} --backend auto"));
        assert_eq!(code, Some(0));
        assert!(said == "one thread: there is no GPU to choose\n", "{said}");
    }
}

#[test]
fn no_adapter_is_an_error_that_helps() {
    let folder = folder();
    for arguments in ["pairs a.obj b.obj --backend gpu", "devices", "bench --backend gpu"] {
        let (code, error) = without_drivers(folder.path(), arguments);
        assert_eq!(code, Some(2), "{arguments}");
        assert!(error.contains("mesa-vulkan-drivers"), "{arguments}: {error}");
    }
}

/// The exit code and standard error of a run that finds no adapter.
fn without_drivers(folder: &Path, arguments: &str) -> (Option<i32>, String) {
    let mut command = command(folder, arguments);
    command.env_remove("WGPU_BACKEND").env_remove("VK_ADD_DRIVER_FILES");
    let ended = command.env("VK_DRIVER_FILES", "none").env("VK_ICD_FILENAMES", "none").output();
    let ended = ended.unwrap();
    (ended.status.code(), String::from_utf8(ended.stderr).unwrap())
}

#[test]
fn devices_are_listed() {
    let folder = folder();
    let text = out(folder.path(), "devices");
    let json = out(folder.path(), "devices --json");
    let devices: serde_json::Value = serde_json::from_str(&json).unwrap();
    let devices = devices.as_array().unwrap();
    let chosen: Vec<_> = devices.iter().filter(|device| device["chosen"] == true).collect();
    assert_eq!(chosen.len(), 1, "{json}");
    assert!(chosen[0]["poses"].is_string(), "{json}");
    assert!(chosen[0]["max_binding_bytes"].as_u64().unwrap() >= 128 << 20, "{json}");
    assert!(
        text.contains(&format!("{}, which queries take\n", chosen[0]["name"].as_str().unwrap()))
    );
}

#[test]
fn executors_are_compared_on_meshes_of_ones_own() {
    let folder = folder();
    let asked = "bench a.obj b.obj --frames 5 --threads 2 --backend gpu --json";
    let record: serde_json::Value = serde_json::from_str(&out(folder.path(), asked)).unwrap();
    assert_eq!((&record["triangles"], &record["frames"]), (&5.into(), &5.into()));
    // At first the blade is where its file has it.
    assert_eq!(record["pairs"][1], 2);
    let executors = record["executors"].as_array().unwrap();
    assert_eq!(executors.len(), 3);
    assert!(executors.iter().all(|times| times["median_ms"].as_f64().unwrap() > 0.0), "{record}");
    // The passes of a GPU are a part of what a user waits for, where it can tell their time.
    let features = Gpu::new().unwrap().device().features();
    let tells = features.contains(Features::TIMESTAMP_QUERY_INSIDE_PASSES);
    let has_device =
        |times: &serde_json::Value| times["device_ms"].as_f64().is_some_and(|ms| ms > 0.0);
    assert_eq!(
        executors.iter().map(has_device).collect::<Vec<_>>(),
        [false, false, tells],
        "{record}"
    );
    assert_eq!(record["name"], "a.obj and b.obj");
    let table = out(folder.path(), "bench a.obj b.obj --frames 2 --threads 2 --backend gpu");
    let widths: Vec<_> = table.lines().skip(1).take(4).map(|row| row.chars().count()).collect();
    assert!(widths.iter().all(|width| *width == widths[0]), "{table}");
}
