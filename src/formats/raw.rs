//! RAW and R16: grey integers of 16 bits and nothing else. Size, byte order and order of rows have to be known; the
//! sidecar says them.

use super::file::{self, Written};
use super::{Error, Window, check_size, collect, open, share};
use serde::{Deserialize, Serialize};
use std::io::{BufReader, Read, Write};
use std::path::Path;

/// Which byte of an integer comes first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ByteOrder {
    /// The least: "Windows" and "PC" in import dialogs.
    #[default]
    Little,
    /// The greatest: "Mac" in import dialogs.
    Big,
}

/// Writes a window of one channel; `range` maps to 0…65535.
///
/// # Errors
/// Those of [`file::write()`], and for any other number of channels.
pub fn write(path: &Path, window: Window, range: [f32; 2], order: ByteOrder) -> Result<Written, Error> {
    if window.channels() != 1 {
        return Err(Error::Target { path: path.into(), reason: "a RAW file holds one channel" });
    }
    file::write(path, |writer| {
        let mut bytes = Vec::new();
        for row in window.rows() {
            bytes.clear();
            for &value in row {
                let integer = (share(value, range) * f64::from(u16::MAX)).round() as u16;
                bytes.extend(match order {
                    ByteOrder::Little => integer.to_le_bytes(),
                    ByteOrder::Big => integer.to_be_bytes(),
                });
            }
            writer.write_all(&bytes)?;
        }
        Ok(())
    })
}

/// Reads values as shares of the largest integer. Without a `size` = [width, height] the file must be a square.
///
/// # Errors
/// When the file can't be read, is too large, or its length is not that of such a raster.
pub fn read(path: &Path, size: Option<[u32; 2]>, order: ByteOrder) -> Result<(u32, u32, Vec<f32>), Error> {
    let (file, file_bytes) = open(path)?;
    let [width, height] = size.map_or_else(|| square(file_bytes), |size| size.map(u64::from));
    check_size(path, "RAW", [width, height], 2, file_bytes)?;
    if width * height == 0 || width * height * 2 != file_bytes {
        let reason = match size {
            Some(_) => format!(
                "its sidecar says {width} × {height} samples of 2 bytes and it has {file_bytes} bytes"
            ),
            None => {
                format!("{file_bytes} bytes make no square of 16-bit integers, and no sidecar gives its size")
            }
        };
        return Err(Error::Corrupt { path: path.into(), format: "RAW", reason });
    }
    let mut reader = BufReader::new(file);
    let mut bytes = vec![0; width as usize * 2];
    let mut values = collect(path, [width, height])?;
    for _ in 0..height {
        reader.read_exact(&mut bytes).map_err(|source| Error::Read { path: path.into(), source })?;
        values.extend(bytes.as_chunks::<2>().0.iter().map(|&pair| {
            let integer = match order {
                ByteOrder::Little => u16::from_le_bytes(pair),
                ByteOrder::Big => u16::from_be_bytes(pair),
            };
            f32::from(integer) / f32::from(u16::MAX)
        }));
    }
    Ok((width as u32, height as u32, values))
}

/// Sides of a square of that many bytes; nearly, where there is none.
fn square(bytes: u64) -> [u64; 2] {
    [(bytes / 2).isqrt(); 2]
}
