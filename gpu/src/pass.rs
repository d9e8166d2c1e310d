//! A pass on the device: its pipeline, with bind group layouts as the shader declares them.
//!
//! Rust names the buffers and nothing else: where a pass binds them, and whether it writes them, is what
//! the WGSL says.

use crate::GpuError;
use crate::device::checked;
use pfront_shaders::{Access, Binding};
use wgpu::{BindGroupLayoutEntry, BindingType, BufferBindingType, Device, ShaderRuntimeChecks};

/// Buffers under the names that shaders give them.
pub(crate) type Named<'a> = &'a [(&'a str, &'a wgpu::Buffer)];

/// A compiled pass.
#[derive(Debug)]
pub(crate) struct Pass {
    pub(crate) entry: &'static str,
    pub(crate) pipeline: wgpu::ComputePipeline,
    groups: Vec<Group>,
}

/// A bind group layout, and the name of the buffer at each binding.
#[derive(Debug)]
struct Group {
    layout: wgpu::BindGroupLayout,
    names: Vec<(u32, &'static str)>,
}

/// The arithmetic that computes the posed position of a vertex. Chosen by a test of the adapter; the result is the
/// same to the bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arithmetic {
    /// The adapter's f32 units, which round as they should.
    Hardware,
    /// The same, and integers for what may have been subnormal: the adapter flushes such numbers.
    Flushing,
    /// Integers: the adapter rounds in another way.
    Integer,
}

/// The target that passes are compiled for: the values of their overrides.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Target {
    /// The arithmetic of poses.
    pub(crate) arithmetic: Arithmetic,
    /// Rounds that a workgroup does in a pass before it gives up.
    pub(crate) rounds: u32,
    /// Whether the host decides what f32 leaves open.
    pub(crate) certify: bool,
}

impl Target {
    pub(crate) fn new(device: &Device, arithmetic: Arithmetic) -> Self {
        let rounds = rounds(device.adapter_info().device_type);
        Self { arithmetic, rounds, certify: false }
    }

    fn overrides(self) -> [(&'static str, f64); 3] {
        [
            ("ARITHMETIC", f64::from(self.arithmetic as u8)),
            ("MOST_ROUNDS", self.rounds.into()),
            ("CERTIFY", u8::from(self.certify).into()),
        ]
    }
}

/// Rounds of a workgroup on an adapter.
///
/// Mesa's lavapipe (tried: 22.3.6) counts the turns of all loops of an invocation together and ends
/// every loop from 65,535 on, without a word; 800 rounds take some 50,000. A GPU needs a limit only so
/// that a dispatch ends whatever it reads: 2^16 rounds take some tenths of a second, and drivers give a
/// dispatch two seconds at least.
pub(crate) fn rounds(adapter: wgpu::DeviceType) -> u32 {
    if adapter == wgpu::DeviceType::Cpu { 800 } else { 1 << 16 }
}

impl Pass {
    pub(crate) fn new(
        device: &Device,
        pass: &pfront_shaders::Pass,
        target: Target,
    ) -> Result<Self, GpuError> {
        checked(device, || Self::compile(device, pass, target))
    }

    fn compile(
        device: &Device,
        pass: &pfront_shaders::Pass,
        target: Target,
    ) -> Result<Self, GpuError> {
        let groups = groups(device, pass);
        let layouts: Vec<_> = groups.iter().map(|group| Some(&group.layout)).collect();
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(pass.entry),
            bind_group_layouts: &layouts,
            immediate_size: 0,
        });
        let shader = shader_module(device, pass.entry, pass.source());
        let mut constants = target.overrides().to_vec();
        constants.retain(|(name, _)| pass.has_override(name));
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(pass.entry),
            layout: Some(&layout),
            module: &shader,
            entry_point: Some(pass.entry),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: &constants,
                // Every pass writes what it reads.
                zero_initialize_workgroup_memory: false,
            },
            cache: None,
        });
        Ok(Self { entry: pass.entry, pipeline, groups })
    }

    /// A bind group of this pass, of the buffers that `find` gives by name.
    pub(crate) fn bind<'a>(
        &self,
        device: &Device,
        group: usize,
        find: impl Fn(&str) -> Option<wgpu::BindingResource<'a>>,
    ) -> Result<wgpu::BindGroup, GpuError> {
        let Group { layout, names } = &self.groups[group];
        let entry = |(binding, name): &(u32, &str)| {
            let unknown = || GpuError::Device { reason: format!("a shader has no buffer {name}") };
            let resource = find(name).ok_or_else(unknown)?;
            Ok(wgpu::BindGroupEntry { binding: *binding, resource })
        };
        let entries = names.iter().map(entry).collect::<Result<Vec<_>, GpuError>>()?;
        let descriptor = wgpu::BindGroupDescriptor { label: None, layout, entries: &entries };
        checked(device, || Ok(device.create_bind_group(&descriptor)))
    }

    /// A bind group of this pass, of buffers that may be more than it uses.
    pub(crate) fn bind_buffers(
        &self,
        device: &Device,
        group: usize,
        buffers: Named<'_>,
    ) -> Result<wgpu::BindGroup, GpuError> {
        self.bind(device, group, |name| {
            let (_, buffer) = buffers.iter().find(|(own, _)| *own == name)?;
            Some(buffer.as_entire_binding())
        })
    }
}

/// Compiles without a counter in every loop, which naga otherwise adds lest a driver take a loop
/// without end for one that has none: 5 % of a query on an H200. Bounds stay checked.
#[expect(unsafe_code, reason = "checks of loops cost 5 % of a query")]
fn shader_module(device: &Device, entry: &str, source: String) -> wgpu::ShaderModule {
    let checks =
        ShaderRuntimeChecks { force_loop_bounding: false, ..ShaderRuntimeChecks::checked() };
    let descriptor = wgpu::ShaderModuleDescriptor {
        label: Some(entry),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    };
    // SAFETY: every loop of the passes ends: it counts to a bound that does not change, halves or
    // doubles a number, or stops after MOST_ROUNDS or a multiple, whatever trees and lists hold.
    unsafe { device.create_shader_module_trusted(descriptor, checks) }
}

/// The layout of each bind group.
fn groups(device: &Device, pass: &pfront_shaders::Pass) -> Vec<Group> {
    let count = pass.bindings().map(|own| own.group + 1).max().unwrap_or(0);
    let group = |index: u32| {
        let own = || pass.bindings().filter(move |own| own.group == index);
        let entry = |Binding { binding, access, .. }| BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: BindingType::Buffer {
                ty: match access {
                    Access::Uniform => BufferBindingType::Uniform,
                    Access::Read => BufferBindingType::Storage { read_only: true },
                    Access::ReadWrite => BufferBindingType::Storage { read_only: false },
                },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let entries: Vec<_> = own().map(entry).collect();
        let descriptor = wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries };
        let layout = device.create_bind_group_layout(&descriptor);
        Group { layout, names: own().map(|own| (own.binding, own.name)).collect() }
    };
    (0..count).map(group).collect()
}
