//! A test of the adapter's f32 arithmetic, run once for each device.
//!
//! WGSL lets an adapter flush subnormal numbers, round in either direction, and fuse or reassociate
//! operations. Posed positions have to be right to the bit, so the passes hide each operation from the
//! compiler, and this module asks the adapter for results of which each known deviation would get some
//! wrong. If it does, the passes pose in integers, which are tried likewise.

use crate::GpuError;
use crate::device::release;
use crate::layout::Trial;
use crate::pass::{Arithmetic, Pass, Target};
use crate::read::read_now;
use bytemuck::Zeroable;
use pfront_core::Pose;
use pfront_shaders::{PROBE, constants::GROUP};
use wgpu::util::DeviceExt;
use wgpu::{BufferUsages, Device, Queue};

/// Finds the arithmetic that gives posed positions to the bit.
pub(crate) async fn arithmetic(device: &Device, queue: &Queue) -> Result<Arithmetic, GpuError> {
    let trials = trials();
    for arithmetic in [Arithmetic::Hardware, Arithmetic::Flushing, Arithmetic::Integer] {
        if passes(device, queue, &trials, arithmetic).await? {
            return Ok(arithmetic);
        }
    }
    Err(GpuError::Device { reason: "its integer arithmetic is wrong".to_owned() })
}

async fn passes(
    device: &Device,
    queue: &Queue,
    trials: &[Trial],
    arithmetic: Arithmetic,
) -> Result<bool, GpuError> {
    let pass = Pass::new(device, &PROBE, Target::new(device, arithmetic))?;
    let buffer = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("trials"),
        contents: bytemuck::cast_slice(trials),
        usage: BufferUsages::STORAGE | BufferUsages::COPY_SRC,
    });
    let group = pass.bind(device, 0, |_| Some(buffer.as_entire_binding()))?;
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut compute = encoder.begin_compute_pass(&Default::default());
    compute.set_pipeline(&pass.pipeline);
    compute.set_bind_group(0, &group, &[]);
    compute.dispatch_workgroups((trials.len() as u32).div_ceil(GROUP), 1, 1);
    drop(compute);
    let found: Vec<Trial> = read_now(device, queue, encoder, &buffer, trials.len(), None).await?;
    release([&buffer]);
    Ok(found.iter().zip(trials).all(|(found, asked)| {
        let bits = |found: [f32; 3]| found.map(f32::to_bits);
        // The sign of zero changes no answer, and adapters differ in it.
        let same = |(&x, y): (&u32, u32)| x == y || (x | y) << 1 == 0;
        found.doubted != 0 || bits(found.found).iter().zip(bits(answer(asked))).all(same)
    }))
}

/// Product, sum and coordinate.
fn answer(trial: &Trial) -> [f32; 3] {
    let Trial { row, point, .. } = *trial;
    let [_, _, coordinate] = Pose::new([row; 3]).apply(point);
    [row[0] * point[0], row[0] + point[0], coordinate]
}

/// Operands: all pairs of numbers that round in a special way, and rows that a fused or reassociated
/// sum gets wrong.
fn trials() -> Vec<Trial> {
    let trial = |row, point| Trial { row, point, ..Trial::zeroed() };
    let special = special();
    let pairs = special.iter().flat_map(|&x| special.iter().map(move |&y| (x, y)));
    let finite = |&(x, y): &(f32, f32)| (x * y).is_finite() && (x + y).is_finite();
    let pairs = pairs.filter(finite).map(|(x, y)| trial([x, 0.0, 0.0, y], [y, 0.0, 0.0]));
    let mut random = random();
    let rows = (0..2048).map(|i| {
        let scale = [1.0, 1e-3, 1e-19, 1e-22, 1e4][i % 5];
        let [x, y, z, t, u, v, w] = [0; 7].map(|_| random());
        // Terms that nearly cancel leave what a fused operation would have kept.
        let t = if i % 2 == 0 { t } else { -(x * u + y * v + z * w) };
        trial([x, y, z, t * scale * scale], [u, v, w].map(|p| p * scale)).scaled(scale)
    });
    let rows: Vec<Trial> = rows.collect();
    let mut all: Vec<Trial> = pairs.collect();
    all.retain(|t| answer(t).iter().all(|x| x.is_finite()));
    all.extend(rows);
    all
}

impl Trial {
    fn scaled(mut self, scale: f32) -> Self {
        self.row[..3].iter_mut().for_each(|x| *x *= scale);
        self
    }
}

/// Numbers around which f32 arithmetic goes wrong: odd significands, ties, both ends of the range.
fn special() -> Vec<f32> {
    let mut all = vec![0.0, 1.0, 1.5, 3.0, 1.0 / 3.0, 16_777_215.0, 16_777_216.0, 0.1, 1e-19, 1e19];
    for e in [-149, -148, -127, -126, -125, -75, -63, -24, -12, -1, 0, 12, 23, 24, 63, 100, 126] {
        let power = f64::exp2(f64::from(e)) as f32;
        all.extend([power, power.next_up(), power.next_down(), power * 1.999_999_9, power * 1.5]);
    }
    all.extend(all.clone().iter().map(|x| -x));
    all.retain(|x| x.is_finite());
    all
}

/// In −1 .. 1, with all bits of the significand in use.
fn random() -> impl FnMut() -> f32 {
    let mut state = 1_u64;
    move || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1 << 23) as f32 - 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Gpu;

    #[test]
    fn integers_round_as_they_should() {
        let gpu = Gpu::new().unwrap_or_else(|error| panic!("{error}"));
        let trials = trials();
        let passes = passes(gpu.device(), gpu.queue(), &trials, Arithmetic::Integer);
        assert!(pollster::block_on(passes).unwrap());
    }

    #[test]
    fn the_trials_tell_every_known_deviation() {
        let flush = |x: f32| if x.is_subnormal() { 0.0 } else { x };
        type Coordinate = fn([f32; 4], [f32; 3]) -> f32;
        let deviations: [Coordinate; 3] = [
            |[r, s, q, t], [x, y, z]| q.mul_add(z, s.mul_add(y, r * x)) + t,
            |[r, s, q, t], [x, y, z]| (r * x + s * y) + (q * z + t),
            |[r, s, q, t], [x, y, z]| q.mul_add(z, r * x + s * y) + t,
        ];
        for wrong in deviations {
            let differs = |t: &&Trial| wrong(t.row, t.point) != answer(t)[2];
            assert!(trials().iter().filter(differs).count() > 100);
        }
        let subnormal = |t: &&Trial| flush(answer(t)[0]) != answer(t)[0];
        assert!(trials().iter().filter(subnormal).count() > 100);
    }
}
