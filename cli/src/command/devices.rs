//! `pfront devices`: each adapter is opened and tested as a query would.

use anyhow::Result;
use pfront::gpu::wgpu::{Adapter, DeviceDescriptor, DeviceType, Features};
use pfront::gpu::{Arithmetic, Gpu};
use pfront_cli::executor::adapters;
use pfront_cli::json::write_json;
use pfront_cli::output::out;
use pfront_files::escape::escaped;
use serde::Serialize;
use std::io::{self, Write};

/// The description of an adapter.
#[derive(Serialize)]
struct Device {
    name: String,
    #[serde(rename = "type")]
    kind: &'static str,
    backend: String,
    driver: String,
    /// Whether it is what a query takes.
    chosen: bool,
    max_binding_bytes: u64,
    max_buffer_bytes: u64,
    /// Invocations of a subgroup, at least and at most, if there are any.
    subgroups: Option<[u32; 2]>,
    timestamps: bool,
    /// How posed positions are computed, or why queries do not run.
    #[serde(flatten)]
    works: Works,
}

#[derive(Serialize)]
#[serde(rename_all = "lowercase")]
enum Works {
    Poses(&'static str),
    Refused(String),
}

pub(crate) fn run(json: bool) -> Result<bool> {
    let chosen = Gpu::new()?.device().adapter_info();
    let device = |adapter: &Adapter| Device::of(adapter, adapter.get_info() == chosen);
    let devices: Vec<Device> = adapters().iter().map(device).collect();
    let mut out = out();
    if json {
        write_json(&mut out, &devices)?;
    } else {
        devices.iter().try_for_each(|device| device.print(&mut out))?;
    }
    Ok(true)
}

impl Device {
    fn of(adapter: &Adapter, chosen: bool) -> Self {
        let (info, limits, features) = (adapter.get_info(), adapter.limits(), adapter.features());
        let subgroups = [info.subgroup_min_size, info.subgroup_max_size];
        let driver = [info.driver, info.driver_info];
        Self {
            name: info.name,
            kind: match info.device_type {
                DeviceType::DiscreteGpu => "discrete GPU",
                DeviceType::IntegratedGpu => "integrated GPU",
                DeviceType::VirtualGpu => "virtual GPU",
                DeviceType::Cpu => "CPU",
                DeviceType::Other => "unknown",
            },
            backend: format!("{:?}", info.backend),
            driver: driver.join(" ").trim().to_owned(),
            chosen,
            max_binding_bytes: limits.max_storage_buffer_binding_size,
            max_buffer_bytes: limits.max_buffer_size,
            subgroups: features.contains(Features::SUBGROUP).then_some(subgroups),
            timestamps: features.contains(Features::TIMESTAMP_QUERY_INSIDE_PASSES),
            works: match arithmetic(adapter) {
                Ok(Arithmetic::Hardware) => Works::Poses("hardware"),
                Ok(Arithmetic::Flushing) => Works::Poses("hardware, integer near zero"),
                Ok(Arithmetic::Integer) => Works::Poses("integer"),
                Err(error) => Works::Refused(format!("{error:#}")),
            },
        }
    }

    fn print(&self, out: &mut impl Write) -> io::Result<()> {
        let mebibytes = |bytes: u64| bytes >> 20;
        writeln!(
            out,
            "{}{}",
            escaped(&self.name),
            if self.chosen { ", which queries take" } else { "" }
        )?;
        writeln!(out, "  type        {}", self.kind)?;
        writeln!(out, "  driver      {}, through {}", escaped(&self.driver), self.backend)?;
        let [binding, buffer] = [self.max_binding_bytes, self.max_buffer_bytes].map(mebibytes);
        writeln!(out, "  memory      {binding} MiB in a binding, {buffer} MiB in a buffer")?;
        match self.subgroups {
            Some([least, most]) if least == most => writeln!(out, "  subgroups   of {least}")?,
            Some([least, most]) => writeln!(out, "  subgroups   of {least} to {most}")?,
            None => writeln!(out, "  subgroups   none")?,
        }
        writeln!(out, "  timestamps  {}", if self.timestamps { "yes" } else { "no" })?;
        match &self.works {
            Works::Poses(arithmetic) => writeln!(out, "  poses       {arithmetic}"),
            Works::Refused(why) => writeln!(out, "  refused     {}", escaped(why)),
        }
    }
}

/// Opens the adapter with all that it offers, and tests it.
fn arithmetic(adapter: &Adapter) -> Result<Arithmetic> {
    let descriptor = DeviceDescriptor { required_limits: adapter.limits(), ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))?;
    Ok(Gpu::from_device(device, queue)?.arithmetic())
}
