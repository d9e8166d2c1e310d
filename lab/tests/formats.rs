//! Workload files: what is written is read again, and no file that lies is believed. Files of arbitrary bytes:
//! `fuzz/fuzz_targets/workload.rs`.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use pfront::Pose;
use pfront_lab::workload::{Frame, Header, Workload, WorkloadWriter};
use pfront_testkit::MeshData;
use pfront_testkit::scenes::Kind;
use std::io::Cursor;

fn mesh(vertices: u32) -> MeshData {
    MeshData {
        positions: (0..vertices).map(|v| [v as f32, -0.0, 1e-40]).collect(),
        triangles: (2..vertices).map(|v| [0, v - 1, v]).collect(),
    }
}

fn poses(frame: u32, objects: usize) -> Vec<Pose> {
    let moved = |i: usize| Pose::from_translation([i as f32, frame as f32, 0.5]);
    (0..objects).map(|i| if i == 0 { Pose::IDENTITY } else { moved(i) }).collect()
}

fn header(kind: Kind) -> Header {
    let (meshes, objects) = match kind {
        Kind::Pair => (vec![mesh(4), mesh(3)], vec![0, 1]),
        Kind::SelfMesh => (vec![mesh(5)], vec![0]),
        Kind::Many => (vec![mesh(3)], vec![0, 0, 0]),
    };
    Header { kind, meshes, objects, frames: 3 }
}

fn positions(frame: u32) -> Vec<[f32; 3]> {
    vec![[frame as f32, 1.0, -2.0]; 5]
}

fn written(kind: Kind) -> Vec<u8> {
    let mut bytes = Vec::new();
    let header = header(kind);
    let mut to = WorkloadWriter::new(&mut bytes, &header).unwrap();
    for frame in 0..header.frames {
        match kind {
            Kind::SelfMesh => to.frame(Frame::Positions(&positions(frame))).unwrap(),
            _ => to.frame(Frame::Poses(&poses(frame, header.objects.len()))).unwrap(),
        }
    }
    bytes
}

/// Reads everything; how many frames there were.
fn read(bytes: &[u8]) -> anyhow::Result<u32> {
    let (header, mut workload) = Workload::open(Cursor::new(bytes))?;
    let mut frames = 0;
    while workload.next_frame()?.is_some() {
        frames += 1;
    }
    assert_eq!(frames, header.frames);
    Ok(frames)
}

/// The layout by hand, once: it is a format of others too.
#[test]
fn bytes_are_as_specified() {
    let words = [0_u32, 1, 2, 1, 3, 1];
    let mut bytes = b"TRICOLW1".to_vec();
    bytes.extend(words.iter().flat_map(|w| w.to_le_bytes()));
    bytes.extend(
        [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|x| x.to_le_bytes()),
    );
    bytes.extend([0_u32, 1, 2, 0, 0].iter().flat_map(|w| w.to_le_bytes()));
    for translation in [0.0_f32, 7.0] {
        let rows = [1.0, 0.0, 0.0, translation, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        bytes.extend(rows.iter().flat_map(|x| x.to_le_bytes()));
    }
    let (header, mut workload) = Workload::open(Cursor::new(&bytes)).unwrap();
    assert_eq!(header.meshes[0].triangles, [[0, 1, 2]]);
    let poses = [Pose::IDENTITY, Pose::from_translation([7.0, 0.0, 0.0])];
    let mut again = Vec::new();
    let mut to = WorkloadWriter::new(&mut again, &header).unwrap();
    assert_eq!(workload.next_frame().unwrap(), Some(Frame::Poses(&poses)));
    assert_eq!(workload.next_frame().unwrap(), None);
    to.frame(Frame::Poses(&poses)).unwrap();
    assert_eq!(again, bytes);
}

#[test]
fn every_truncation_is_noticed_with_its_offset() {
    for kind in [Kind::Pair, Kind::SelfMesh, Kind::Many] {
        let bytes = written(kind);
        for length in 0..bytes.len() {
            let error = read(&bytes[..length]).unwrap_err().to_string();
            let told = format!("the file has {length} bytes, too few for");
            assert!(error.starts_with("at byte ") && error.contains(&told), "{kind:?}: {error}");
        }
        let longer = [&bytes[..], &[0]].concat();
        assert!(read(&longer).unwrap_err().to_string().contains("1 bytes more than"));
    }
}

#[test]
fn lies_are_refused_where_they_are() {
    let with = |kind, at: usize, word: u32| {
        let mut bytes = written(kind);
        bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
        read(&bytes).unwrap_err().to_string()
    };
    assert!(with(Kind::Pair, 0, 0).starts_with("at byte 0: this is not a workload"));
    assert!(with(Kind::Pair, 8, 3).starts_with("at byte 8: kind 3"));
    assert!(with(Kind::SelfMesh, 12, 2).starts_with("at byte 12: a self workload of 2 meshes"));
    assert!(with(Kind::Pair, 16, 3).starts_with("at byte 16: a Pair workload of 3 objects"));
    // Billions of meshes, frames, vertices: no such memory is asked for.
    assert!(with(Kind::Many, 12, u32::MAX).contains("too few for the meshes"));
    assert!(with(Kind::Many, 20, u32::MAX).contains("too few for the frames"));
    assert!(with(Kind::Many, 24, u32::MAX).contains("too few for the positions of a mesh"));
    // The object table of `Many` follows one mesh of 3 vertices and 1 triangle.
    let table = 24 + 8 + 36 + 12;
    assert!(with(Kind::Many, table + 4, 1).contains(&format!("at byte {}: object 1", table + 4)));
    let nothing = [&b"TRICOLW1"[..], bytemuck::bytes_of(&[2_u32, 0, 0, u32::MAX])].concat();
    assert!(read(&nothing).unwrap_err().to_string().ends_with("4294967295 frames of nothing"));
    // The first object of a pair stays.
    let poses = written(Kind::Pair).len() - 3 * 2 * 48;
    let error = with(Kind::Pair, poses + 2 * 48 + 12, 1.0_f32.to_bits());
    assert!(error.starts_with(&format!("at byte {}: object 0", poses + 2 * 48)), "{error}");
}
