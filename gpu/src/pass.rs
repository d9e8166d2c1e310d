//! A pass on the device: its pipeline, with bind group layouts read off the shader by naga.
//!
//! Rust names the buffers and nothing else: which of them a pass binds, where, and whether it writes
//! them, is what the WGSL says.

use crate::GpuError;
use crate::device::checked;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{AddressSpace, GlobalVariable, Module, StorageAccess};
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
    names: Vec<(u32, String)>,
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
        let source = pass.source();
        let (module, info) = parse(&source)?;
        let groups = groups(device, &module, &info);
        let layouts: Vec<_> = groups.iter().map(|group| Some(&group.layout)).collect();
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(pass.entry),
            bind_group_layouts: &layouts,
            immediate_size: 0,
        });
        let shader = shader_module(device, pass.entry, source);
        let names: Vec<_> =
            module.overrides.iter().filter_map(|(_, o)| o.name.as_deref()).collect();
        let mut constants = target.overrides().to_vec();
        constants.retain(|(name, _)| names.contains(name));
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
        let entry = |(binding, name): &(u32, String)| {
            let resource = find(name).ok_or_else(|| shader_error(&format!("no buffer {name}")))?;
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

/// Parses and validates WGSL.
pub(crate) fn parse(source: &str) -> Result<(Module, ModuleInfo), GpuError> {
    let module = naga::front::wgsl::parse_str(source)
        .map_err(|error| shader_error(&error.emit_to_string(source)))?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::default())
        .validate(&module)
        .map_err(|error| shader_error(&error.emit_to_string(source)))?;
    Ok((module, info))
}

fn shader_error(reason: &str) -> GpuError {
    GpuError::Device { reason: format!("a shader is wrong: {reason}") }
}

/// The buffers that the entry point uses: name, group, binding, type.
pub(crate) fn bindings<'m>(
    module: &'m Module,
    info: &ModuleInfo,
) -> Vec<(&'m str, u32, u32, BufferBindingType)> {
    let entry = info.get_entry_point(0);
    let used = module.global_variables.iter().filter(|(handle, _)| !entry[*handle].is_empty());
    let bound = |(_, variable): (_, &'m GlobalVariable)| {
        let binding = variable.binding?;
        let ty = match variable.space {
            AddressSpace::Uniform => BufferBindingType::Uniform,
            AddressSpace::Storage { access } => {
                BufferBindingType::Storage { read_only: !access.contains(StorageAccess::STORE) }
            }
            _ => return None,
        };
        Some((variable.name.as_deref()?, binding.group, binding.binding, ty))
    };
    used.filter_map(bound).collect()
}

fn groups(device: &Device, module: &Module, info: &ModuleInfo) -> Vec<Group> {
    let bindings = bindings(module, info);
    let count = bindings.iter().map(|&(_, group, ..)| group + 1).max().unwrap_or(0);
    let group = |index: u32| {
        let own = || bindings.iter().filter(move |&&(_, group, ..)| group == index);
        let entries: Vec<_> = own()
            .map(|&(_, _, binding, ty)| BindGroupLayoutEntry {
                binding,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty: BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
                count: None,
            })
            .collect();
        let descriptor = wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries };
        let layout = device.create_bind_group_layout(&descriptor);
        let names = own().map(|&(name, _, binding, _)| (binding, name.to_owned())).collect();
        Group { layout, names }
    };
    (0..count).map(group).collect()
}
