//! The meshes that a device has, of which those that nobody holds any more are kept within a budget.

use crate::gpu::{Gpu, GpuError, GpuModel};
use crate::{Model, Stamp};
use std::collections::HashMap;
use std::sync::Arc;

/// Rigid meshes by what they hold.
#[derive(Debug, Default)]
pub(super) struct DeviceMeshes {
    kept: HashMap<Stamp, Kept>,
    /// Bytes of all of them.
    bytes: u64,
    /// How often one was asked for.
    time: u64,
}

#[derive(Debug)]
struct Kept {
    model: Arc<GpuModel>,
    /// When it was last asked for.
    used: u64,
}

impl DeviceMeshes {
    /// A model on the device, which is uploaded unless it is there.
    pub(super) fn get(&mut self, gpu: &Gpu, model: &Model) -> Result<Arc<GpuModel>, GpuError> {
        self.time += 1;
        if let Some(kept) = self.kept.get_mut(&model.stamp()) {
            kept.used = self.time;
            return Ok(kept.model.clone());
        }
        let uploaded = Arc::new(GpuModel::new(gpu, model.bvh())?);
        self.bytes += uploaded.bytes();
        self.kept.insert(model.stamp(), Kept { model: uploaded.clone(), used: self.time });
        Ok(uploaded)
    }

    /// Gives back meshes that nobody else holds, the least recently used first, until those that are left take at most so
    /// many bytes.
    ///
    /// # Complexity
    /// O(1) while all meshes together take no more; else O(n log n) for n meshes.
    pub(super) fn trim(&mut self, most: u64) {
        if self.bytes <= most {
            return;
        }
        let is_idle = |kept: &Kept| Arc::strong_count(&kept.model) == 1;
        let idle = self.kept.iter().filter(|(_, kept)| is_idle(kept));
        let mut idle: Vec<_> =
            idle.map(|(&stamp, kept)| (kept.used, stamp, kept.model.bytes())).collect();
        idle.sort_unstable_by_key(|&(used, ..)| used);
        let mut left: u64 = idle.iter().map(|&(.., bytes)| bytes).sum();
        for (_, stamp, bytes) in idle {
            if left <= most {
                break;
            }
            left -= bytes;
            self.bytes -= bytes;
            self.kept.remove(&stamp);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pfront_testkit::scenes::icosphere;

    fn balls() -> Vec<Model> {
        let ball = |_| {
            let ball = icosphere(80);
            Model::new(ball.positions, ball.triangles).unwrap()
        };
        (0..4).map(ball).collect()
    }

    #[test]
    fn meshes_that_nobody_holds_are_given_back_the_least_recently_used_first() {
        let (gpu, balls) = (Gpu::new().unwrap(), balls());
        let mut meshes = DeviceMeshes::default();
        let held = meshes.get(&gpu, &balls[0]).unwrap();
        let bytes = held.bytes();
        for ball in &balls[1..] {
            meshes.get(&gpu, ball).unwrap();
            meshes.trim(2 * bytes);
        }
        let uploads = gpu.totals().uploads;
        assert_eq!(uploads, 4);
        // One is held, and two of the other three are within the budget.
        for (ball, is_there) in [(0, true), (3, true), (2, true), (1, false)] {
            let before = gpu.totals().uploads;
            meshes.get(&gpu, &balls[ball]).unwrap();
            assert_eq!(gpu.totals().uploads == before, is_there, "{ball}");
        }
        drop(held);
        meshes.trim(0);
        assert_eq!((meshes.bytes, meshes.kept.len()), (0, 0));
    }
}
