//! `terrane devices`: what there is to run on.

use super::{options::OutputOptions, output::print};
use crate::app::report::Details;
use crate::app::{Error, Session};
use crate::gpu::{self, DeviceInfo};
use clap::Args;
use serde_json::json;

/// List the Vulkan devices of this machine
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    pub output: OutputOptions,
}

pub fn run(arguments: &Arguments, session: &mut Session) -> Result<(), Error> {
    let devices = gpu::devices()?;
    session.report.details = Some(Details::Devices(devices.iter().map(object).collect()));
    if !arguments.output.json {
        let lines: String = devices.iter().map(|device| line(device) + "\n").collect();
        print(lines.as_bytes())?;
    }
    Ok(())
}

fn object(device: &DeviceInfo) -> serde_json::Value {
    let [major, minor, patch] = device.vulkan;
    json!({
        "index": device.index,
        "name": device.name,
        "kind": device.kind.to_string(),
        "driver": device.driver,
        "vulkan": format!("{major}.{minor}.{patch}"),
        "memory_bytes": device.memory,
        "max_image": device.max_image,
        "max_allocation_bytes": device.max_allocation,
        "ray_query": device.ray_query,
        "usable": device.missing.is_empty(),
        "missing": device.missing,
    })
}

fn line(device: &DeviceInfo) -> String {
    let [major, minor, patch] = device.vulkan;
    let mut line = format!(
        "{}  {}, {}, {}, Vulkan {major}.{minor}.{patch}, {:.1} GiB",
        device.index,
        device.name,
        device.kind,
        device.driver,
        device.memory as f64 / f64::from(1 << 30)
    );
    if device.ray_query {
        line += ", traces rays by itself";
    }
    if !device.missing.is_empty() {
        line += &format!(" (can't be used: lacks {})", device.missing.join(", "));
    }
    line
}
