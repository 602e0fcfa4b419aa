//! Options that several verbs share.

use clap::{Args, ValueHint};
use std::path::PathBuf;

#[derive(Args)]
pub struct WorldOptions {
    /// World file (TOML); `terrane schema` tells what may stand in it. Or a folder of settings (`docs/folders.md`)
    #[arg(value_hint = ValueHint::AnyPath)]
    pub world: PathBuf,

    /// Change a key for this run, for example --set terrain.cells=256; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,

    /// Another seed, from 0 to 4294967295: another island
    #[arg(long, value_name = "N")]
    pub seed: Option<u32>,

    /// Simulate from the start, whatever earlier runs have left, and leave nothing; `check` simulates nothing and never
    /// looks there
    #[arg(long)]
    pub no_cache: bool,
}

#[derive(Args, Clone, Default)]
pub struct DeviceOptions {
    /// Index of the device to run on, or a part of its name; `terrane devices` lists them
    #[arg(long, value_name = "DEVICE")]
    pub device: Option<String>,

    /// Most device memory to use, for example 2GiB or 512MiB [default: 80 % of what there is]
    #[arg(long, value_name = "SIZE", value_parser = bytes)]
    pub memory_limit: Option<u64>,
}

impl DeviceOptions {
    /// As they are written on a command line.
    #[cfg(feature = "viewer")]
    pub fn words(&self) -> Vec<String> {
        let device = self.device.iter().map(|device| format!("--device={device}"));
        let memory = self.memory_limit.iter().map(|bytes| format!("--memory-limit={bytes}"));
        device.chain(memory).collect()
    }
}

#[derive(Args)]
pub struct OutputOptions {
    /// Print one JSON object about the run on standard output: stages, files, errors
    #[arg(long)]
    pub json: bool,

    /// Show no progress; errors are still told
    #[arg(long, short)]
    pub quiet: bool,
}

/// Width and height of a picture, pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    pub width: u32,
    pub height: u32,
}

/// Longest side of a picture, pixels.
const MAX_SIDE: u32 = 16_384;

/// Reads `1280x720`.
pub fn size(text: &str) -> Result<Size, String> {
    let sides = text.split_once(['x', 'X', '×']).and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    match sides {
        Some((width, height)) if (1..=MAX_SIDE).contains(&width) && (1..=MAX_SIDE).contains(&height) => {
            Ok(Size { width, height })
        }
        Some(_) => Err(format!("both sides must lie between 1 and {MAX_SIDE} pixels")),
        None => Err("it must be width x height in pixels, for example 1280x720".into()),
    }
}

/// Reads a size in bytes, KiB, MiB, GiB or TiB.
pub fn bytes(text: &str) -> Result<u64, String> {
    let (number, unit) = text.split_at(text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len()));
    let shift = match unit.to_ascii_lowercase().as_str() {
        "" | "b" => 0,
        "kib" => 10,
        "mib" => 20,
        "gib" => 30,
        "tib" => 40,
        _ => return Err("the unit must be KiB, MiB, GiB or TiB, or none for bytes".into()),
    };
    match number.trim().parse::<f64>() {
        Ok(number) if number >= 1.0 && number.is_finite() => Ok((number * (1_u64 << shift) as f64) as u64),
        _ => Err("it must be a number of bytes, for example 2GiB".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_of_pictures() {
        assert_eq!(size("1280x720"), Ok(Size { width: 1280, height: 720 }));
        assert_eq!(size("1X16384"), Ok(Size { width: 1, height: 16_384 }));
        for wrong in ["", "x", "1280", "1280x", "0x720", "1280x16385", "-1x5", "1280x720x3", "99999999999x1"]
        {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn sizes_of_memory() {
        assert_eq!(bytes("1024"), Ok(1024));
        assert_eq!(bytes("2GiB"), Ok(2 << 30));
        assert_eq!(bytes("1.5 mib"), Ok(3 << 19));
        for wrong in ["", "GiB", "2GB", "-1GiB", "0", "nan", "inf", "2 GiB more"] {
            assert!(bytes(wrong).is_err(), "{wrong}");
        }
    }
}
