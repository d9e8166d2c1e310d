//! The passes for meshes that move.

use crate::GpuError;
use crate::pass::{Pass, Target};
use pfront_shaders::{ARRANGE, COUNT, FIT, KEYS, REFIT, SCAN, SCATTER, SURVEY, TAKE};
use wgpu::Device;

/// Each of them, compiled.
#[derive(Debug)]
pub(crate) struct MovingPasses {
    pub(crate) refit: Pass,
    pub(crate) take: Pass,
    pub(crate) survey: Pass,
    pub(crate) keys: Pass,
    pub(crate) count: Pass,
    pub(crate) scan: Pass,
    pub(crate) scatter: Pass,
    pub(crate) arrange: Pass,
    pub(crate) fit: Pass,
}

impl MovingPasses {
    pub(crate) fn new(device: &Device, target: Target) -> Result<Self, GpuError> {
        let pass = |pass| Pass::new(device, pass, target);
        Ok(Self {
            refit: pass(&REFIT)?,
            take: pass(&TAKE)?,
            survey: pass(&SURVEY)?,
            keys: pass(&KEYS)?,
            count: pass(&COUNT)?,
            scan: pass(&SCAN)?,
            scatter: pass(&SCATTER)?,
            arrange: pass(&ARRANGE)?,
            fit: pass(&FIT)?,
        })
    }
}
