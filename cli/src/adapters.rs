//! What this machine has to compute on.

use pfront::gpu::wgpu::{Adapter, AdapterInfo, Backends, DeviceType, Instance, InstanceDescriptor};

/// All adapters that WGPU_BACKEND admits, or else all.
pub(crate) fn all() -> Vec<Adapter> {
    let instance = Instance::new(InstanceDescriptor::new_without_display_handle_from_env());
    pollster::block_on(instance.enumerate_adapters(Backends::all()))
}

/// Whether one of them is more than a program that runs on the CPU.
pub(crate) fn any_is_a_gpu() -> bool {
    all().iter().any(|adapter| adapter.get_info().device_type != DeviceType::Cpu)
}

/// A name that tells two drivers of the same device apart.
pub(crate) fn name(info: &AdapterInfo) -> String {
    format!("{} ({:?})", info.name, info.backend)
}
