//! Traced pictures without their noise, by Intel Open Image Denoise: its program `oidnDenoise` is run on the picture, albedo and normals.

use super::Error;
use std::fs;
use std::io::{self, Write};
use std::path::Path;
use std::process::{Command, Stdio};

/// A program that takes the noise out of pictures.
pub struct Denoiser {
    program: String,
}

/// The name under which it is looked for.
pub const PROGRAM: &str = "oidnDenoise";

impl Denoiser {
    /// Finds out whether `program` can be run, before hours are spent on what it is for.
    ///
    /// # Errors
    /// [`Error::Denoiser`] if it can't.
    pub fn find(program: &str) -> Result<Denoiser, Error> {
        let mut command = Command::new(program);
        let found =
            command.arg("--help").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).status();
        match found {
            Ok(_) => Ok(Denoiser { program: program.into() }),
            Err(error) => Err(Error::Denoiser(format!(
                "cannot run {program}: {error}; get it from openimagedenoise.org and put it on the PATH, name it with \
                 --denoise=PROGRAM, or leave --denoise out"
            ))),
        }
    }

    /// Replaces R, G and B of a picture of `size` = [width, height] pixels by what they are without noise; what they were stays as
    /// `noisy.R`, `noisy.G` and `noisy.B`. Albedo and normals guide it where there are any.
    ///
    /// # Errors
    /// [`Error::Denoiser`] if the program fails; the channels are as they were then.
    pub fn clean(&self, size: [u32; 2], channels: &mut Vec<(String, Vec<f32>)>) -> Result<(), Error> {
        let folder = tempfile::tempdir().map_err(|error| self.failed(&error))?;
        let path = |name: &str| folder.path().join(name);
        let mut command = Command::new(&self.program);
        let inputs = [
            ("--hdr", "colour.pfm", ["R", "G", "B"]),
            ("--alb", "albedo.pfm", ["albedo.R", "albedo.G", "albedo.B"]),
            ("--nrm", "normal.pfm", ["normal.X", "normal.Y", "normal.Z"]),
        ];
        for (option, name, planes) in inputs {
            let [Some(x), Some(y), Some(z)] = planes.map(|plane| find(channels, plane)) else { continue };
            write(&path(name), size, [x, y, z]).map_err(|error| self.failed(&error))?;
            command.arg(option).arg(path(name));
        }
        command.arg("-o").arg(path("clean.pfm")).stdin(Stdio::null());
        let output = command.output().map_err(|error| self.failed(&error))?;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            return Err(self.failed(&format!("{}: {}", output.status, said.trim())));
        }
        let clean = read(&path("clean.pfm"), size).map_err(|error| self.failed(&error))?;
        for (name, clean) in ["R", "G", "B"].into_iter().zip(clean) {
            let Some((_, plane)) = channels.iter_mut().find(|(known, _)| known == name) else { continue };
            let noisy = std::mem::replace(plane, clean);
            channels.push((format!("noisy.{name}"), noisy));
        }
        Ok(())
    }

    fn failed(&self, why: &dyn std::fmt::Display) -> Error {
        Error::Denoiser(format!("{} could not take the noise out of the picture: {why}", self.program))
    }
}

fn find<'a>(channels: &'a [(String, Vec<f32>)], name: &str) -> Option<&'a [f32]> {
    channels.iter().find(|(known, _)| known == name).map(|(_, plane)| plane.as_slice())
}

/// Writes a Portable Float Map: three floats a pixel, the lowest row first.
fn write(path: &Path, [width, height]: [u32; 2], planes: [&[f32]; 3]) -> io::Result<()> {
    let mut out = io::BufWriter::new(fs::File::create(path)?);
    write!(out, "PF\n{width} {height}\n-1.0\n")?;
    for row in (0..height as usize).rev() {
        for pixel in row * width as usize..(row + 1) * width as usize {
            for plane in planes {
                out.write_all(&plane[pixel].to_le_bytes())?;
            }
        }
    }
    out.flush()
}

/// Reads such a map of known size as three planes, the highest row first.
fn read(path: &Path, [width, height]: [u32; 2]) -> io::Result<[Vec<f32>; 3]> {
    let (width, height) = (width as usize, height as usize);
    let bytes = fs::read(path)?;
    let invalid =
        || io::Error::new(io::ErrorKind::InvalidData, "what it has written is not a picture of that size");
    let pixels = 12 * width * height;
    let (header, body) = bytes.split_at_checked(bytes.len().saturating_sub(pixels)).ok_or_else(invalid)?;
    let header = String::from_utf8_lossy(header);
    let words: Vec<&str> = header.split_ascii_whitespace().collect();
    let expected = ["PF", &width.to_string(), &height.to_string()];
    let [kind, columns, rows, scale] = words[..] else { return Err(invalid()) };
    let little = scale.parse::<f32>().is_ok_and(|scale| scale < 0.0);
    if [kind, columns, rows] != expected || !little || body.len() != pixels {
        return Err(invalid());
    }
    let mut planes = [const { Vec::new() }; 3];
    for row in body.chunks_exact(12 * width).rev() {
        for (index, value) in row.as_chunks::<4>().0.iter().enumerate() {
            planes[index % 3].push(f32::from_le_bytes(*value));
        }
    }
    Ok(planes)
}
