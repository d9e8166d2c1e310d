//! Positions from a buffer that is on the device, against those from the host.

use crate::common::{Both, gpu, sorted, truth};
use pfront_core::{Aabb, Pose, bvtt};
use pfront_gpu::wgpu::{Buffer, BufferDescriptor, BufferUsages};
use pfront_gpu::{Deforming, GpuError, GpuQuery, GpuQuestion, GpuVerb, VertexBuffer};
use pfront_testkit::scenes::Scene;
use pfront_testkit::shapes::{sheet, sphere};

/// As far as any of these meshes goes.
const BOX: Aabb = Aabb { min: [-20.0; 3], max: [20.0; 3] };

fn buffer(bytes: u64, usage: BufferUsages) -> Buffer {
    let usage = usage | BufferUsages::COPY_DST;
    let descriptor =
        BufferDescriptor { label: None, size: bytes, usage, mapped_at_creation: false };
    gpu().device().create_buffer(&descriptor)
}

/// Vertices of so many words, in a buffer with as many words before the first; all else in it is NaN.
struct Vertices {
    buffer: Buffer,
    first: usize,
    stride: usize,
    count: usize,
}

impl Vertices {
    fn new(count: usize, first: usize, stride: usize) -> Self {
        let words = first + (count - 1) * stride + 3;
        Self { buffer: buffer(4 * words as u64, BufferUsages::STORAGE), first, stride, count }
    }

    fn write(&self, positions: &[[f32; 3]]) {
        let mut words = vec![f32::NAN; self.buffer.size() as usize / 4];
        assert_eq!(positions.len(), self.count);
        for (i, position) in positions.iter().enumerate() {
            words[self.first + i * self.stride..][..3].copy_from_slice(position);
        }
        gpu().queue().write_buffer(&self.buffer, 0, bytemuck::cast_slice(&words));
    }

    fn read(&self, bounds: Aabb) -> VertexBuffer<'_> {
        let [offset, stride] = [self.first, self.stride].map(|words| 4 * words as u64);
        VertexBuffer { buffer: &self.buffer, offset, stride, bounds }
    }
}

#[test]
fn a_sheet_that_folds_in_buffers_of_any_layout() {
    let scene = Scene::by_name("sheet", Some(5_000)).unwrap();
    let mut positions = Vec::new();
    scene.positions(0, &mut positions);
    let mut sheet = Both::new(&positions, &scene.meshes[0].triangles, 4);
    let ball = sphere(16).map(|p| p.map(|x| x * 0.3));
    let ball = Both::new(&ball.positions, &ball.triangles, 4);
    let mut moving = Deforming::new(gpu(), sheet.bvh()).unwrap();
    let (mut own, mut pair) = (GpuQuery::new(gpu()).unwrap(), GpuQuery::new(gpu()).unwrap());
    let layouts = [(0, 3), (5, 8), (64, 4), (67, 3), (1, 5)];
    let layouts = layouts.map(|(first, stride)| Vertices::new(positions.len(), first, stride));
    let mut found = 0;
    let frames = (0..scene.frames()).step_by(scene.frames() / 14).skip(1);
    for (turn, frame) in frames.enumerate() {
        scene.positions(frame, &mut positions);
        sheet.set_positions(&positions);
        // The host, a buffer as last time, and another take turns; and so do the old tree and a new one.
        let vertices = &layouts[turn / 2 % layouts.len()];
        vertices.write(&positions);
        match turn % 5 {
            4 => moving.set_positions(&positions).unwrap(),
            _ => moving.set_positions_from(&vertices.read(BOX)).unwrap(),
        }
        if turn == 7 {
            moving.rebuild().unwrap();
        }
        let within = sorted(&bvtt::SelfBvtt::new(sheet.bvh()));
        for _ in 0..2 {
            assert!(own.all(&GpuQuestion::itself(&moving)).unwrap() == within, "frame {frame}");
        }
        let pose = Pose::from_translation(positions[frame]);
        let question = GpuQuestion::pair(&moving, &ball.model, &pose);
        assert!(pair.all(&question).unwrap() == truth(&sheet, &ball, &pose), "frame {frame}");
        found += within.len();
    }
    assert!(found > 0);
}

/// A mesh that is written, refitted and asked about in one submission is asked about as it was written.
#[test]
fn one_encoder_for_all() {
    let flat = sheet(30, |x, y| 0.1 * (9.0 * x * y).sin());
    let mut core = Both::new(&flat.positions, &flat.triangles, 4);
    let mut moving = Deforming::new(gpu(), core.bvh()).unwrap();
    let mut query = GpuQuery::new(gpu()).unwrap();
    let vertices = Vertices::new(flat.positions.len(), 0, 3);
    let mut pairs = Vec::new();
    let copied = buffer(vertices.buffer.size(), BufferUsages::COPY_SRC);
    for fold in [1.0, -0.7, 0.3, 1.4] {
        let positions: Vec<_> = flat
            .positions
            .iter()
            .map(|p| [p[0] * (1.0 - fold * p[0].abs()), p[1], p[2] + fold * p[0] * p[1]])
            .collect();
        core.set_positions(&positions);
        gpu().queue().write_buffer(&copied, 0, bytemuck::cast_slice(&positions));
        let mut encoder = gpu().device().create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(&copied, 0, &vertices.buffer, 0, copied.size());
        moving.record_positions_from(&mut encoder, &vertices.read(BOX)).unwrap();
        query.record(&mut encoder, &GpuQuestion::itself(&moving), GpuVerb::All).unwrap();
        gpu().queue().submit([encoder.finish()]);
        query.read(&mut pairs).unwrap();
        assert_eq!(pairs, sorted(&bvtt::SelfBvtt::new(core.bvh())), "{fold}");
    }
}

#[test]
fn a_vertex_outside_of_the_box_is_told_by_every_question_until_all_are_inside() {
    let soup = sheet(20, |x, y| x * y);
    let n = soup.positions.len();
    let mesh = Both::new(&soup.positions, &soup.triangles, 4);
    let ball = sphere(6);
    let ball = Both::new(&ball.positions, &ball.triangles, 4);
    let mut moving = Deforming::new(gpu(), mesh.bvh()).unwrap();
    let vertices = Vertices::new(n, 2, 7);
    let mut query = GpuQuery::new(gpu()).unwrap();
    let pose = Pose::IDENTITY;
    let right = truth(&ball, &mesh, &pose);
    assert!(!right.is_empty());
    let (nan, inf) = (f32::NAN, f32::INFINITY);
    let next = 20.0f32.next_up();
    for (turn, bad) in [nan, -nan, inf, -inf, next, -next, f32::MAX].into_iter().enumerate() {
        let mut positions = soup.positions.clone();
        positions[n - 1][1] = nan;
        positions[17 + turn][turn % 3] = bad;
        vertices.write(&positions);
        moving.set_positions_from(&vertices.read(BOX)).unwrap();
        let outside = GpuError::OutsideBox { vertex: 17 + turn as u32 };
        let (own, pair) =
            (GpuQuestion::itself(&moving), GpuQuestion::pair(&ball.model, &moving, &pose));
        assert_eq!(query.all(&own).unwrap_err(), outside);
        assert_eq!(query.all(&pair).unwrap_err(), outside);
        assert_eq!(query.any(&pair).unwrap_err(), outside);
        assert_eq!(query.count(&pair).unwrap_err(), outside);
        match turn % 2 {
            0 => {
                vertices.write(&soup.positions);
                moving.set_positions_from(&vertices.read(BOX)).unwrap();
            }
            _ => moving.set_positions(&soup.positions).unwrap(),
        }
        let pair = GpuQuestion::pair(&ball.model, &moving, &pose);
        assert_eq!(query.all(&pair).unwrap(), right);
    }
}

/// Both zeros are in a box that ends at either, and numbers that a device may flush stay what they are.
#[test]
fn small_numbers_are_inside() {
    let tiny = f32::from_bits(3);
    let positions = [[0.0, -0.0, tiny], [1.0, 0.0, 0.0], [0.0, 1.0, -tiny], [-0.0, 0.0, 1.0]];
    let mesh = Both::new(&positions, &[[0, 1, 2], [0, 2, 3]], 4);
    let mut moving = Deforming::new(gpu(), mesh.bvh()).unwrap();
    let vertices = Vertices::new(4, 0, 3);
    vertices.write(&positions);
    let mut query = GpuQuery::new(gpu()).unwrap();
    for zero in [0.0, -0.0] {
        let bounds = Aabb { min: [zero, zero, -tiny], max: [1.0; 3] };
        moving.set_positions_from(&vertices.read(bounds)).unwrap();
        assert_eq!(query.count(&GpuQuestion::itself(&moving)).unwrap(), 0);
        let within = Aabb { min: bounds.min, max: [1.0, 1.0, 1.0f32.next_down()] };
        moving.set_positions_from(&vertices.read(within)).unwrap();
        let refused = query.count(&GpuQuestion::itself(&moving)).unwrap_err();
        assert_eq!(refused, GpuError::OutsideBox { vertex: 3 });
    }
}

#[test]
fn buffers_that_cannot_be_read_change_nothing() {
    let soup = sheet(3, |x, y| x * y);
    let mesh = Both::new(&soup.positions, &soup.triangles, 4);
    let mut moving = Deforming::new(gpu(), mesh.bvh()).unwrap();
    let vertices = Vertices::new(soup.positions.len(), 0, 3);
    let good = vertices.read(BOX);
    let uniform = buffer(4096, BufferUsages::UNIFORM);
    let endless = Aabb { min: [f32::NEG_INFINITY; 3], ..BOX };
    for (bad, named) in [
        (VertexBuffer { offset: 2, ..good }, "offset of 2 bytes"),
        (VertexBuffer { stride: 8, ..good }, "stride of 8"),
        (VertexBuffer { stride: 14, ..good }, "stride of 14"),
        (VertexBuffer { offset: 4, ..good }, "it has 192 bytes, too few for 16 vertices"),
        (VertexBuffer { stride: 1 << 63, ..good }, "too few"),
        (VertexBuffer { buffer: &uniform, ..good }, "STORAGE"),
        (VertexBuffer { bounds: endless, ..good }, "not finite"),
    ] {
        let refused = moving.set_positions_from(&bad).unwrap_err().to_string();
        assert!(refused.contains(named), "{refused}");
    }
    vertices.write(&soup.positions);
    moving.set_positions_from(&good).unwrap();
    assert_eq!(GpuQuery::new(gpu()).unwrap().count(&GpuQuestion::itself(&moving)).unwrap(), 0);
    let empty = Both::new(&[], &[], 4);
    let mut moving = Deforming::new(gpu(), empty.bvh()).unwrap();
    moving.set_positions_from(&good).unwrap();
}

/// Positions from the host and from more buffers than are remembered, in any order, with new trees and questions by two queries in
/// between, or none.
#[test]
fn refits_in_any_order() {
    let flat = sheet(12, |x, y| 0.1 * (9.0 * x * y).sin());
    let ball = sphere(8).map(|p| p.map(|x| x * 0.4));
    let ball = Both::new(&ball.positions, &ball.triangles, 4);
    let mut core = Both::new(&flat.positions, &flat.triangles, 4);
    let mut moving = Deforming::new(gpu(), core.bvh()).unwrap();
    let (mut own, mut pair) = (GpuQuery::new(gpu()).unwrap(), GpuQuery::new(gpu()).unwrap());
    let buffers = [3, 4, 5, 6, 7, 8].map(|stride| Vertices::new(flat.positions.len(), 1, stride));
    let (mut state, mut found) = (7_u32, 0);
    for _ in 0..120 {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let [way, next, fold, _] = state.to_be_bytes();
        let fold = f32::from(fold) / 90.0 - 1.0;
        let crumple =
            |p: &[f32; 3]| [p[0] * (1.0 - fold * p[0].abs()), p[1], p[2] + fold * p[0] * p[1]];
        let positions: Vec<_> = flat.positions.iter().map(crumple).collect();
        core.set_positions(&positions);
        match way % 9 {
            0 | 1 => moving.set_positions(&positions).unwrap(),
            2 => moving.rebuild_at(&positions).unwrap(),
            way => {
                let vertices = &buffers[way as usize - 3];
                vertices.write(&positions);
                moving.set_positions_from(&vertices.read(BOX)).unwrap();
                // The refit has read it before.
                vertices.write(&flat.positions);
            }
        }
        if next & 1 != 0 {
            let within = sorted(&bvtt::SelfBvtt::new(core.bvh()));
            assert_eq!(own.all(&GpuQuestion::itself(&moving)).unwrap(), within);
            found += within.len();
        }
        if next & 2 != 0 {
            let question = GpuQuestion::pair(&ball.model, &moving, &Pose::IDENTITY);
            assert_eq!(pair.all(&question).unwrap(), truth(&ball, &core, &Pose::IDENTITY));
        }
    }
    assert!(found > 0);
}
