//! Shards: what some samples of a picture have gathered, as a file. The checkpoint of an unfinished picture is one, too.
//!
//! A shard says of which picture it is by all that decides its bits ([`Render`]), and holds exact sums. So a picture comes out the
//! same to the last bit, whether it was traced in one go, was interrupted and resumed, or put together from shards.

use super::{Renderer, World};
use crate::core::hash::hexadecimal;
use crate::formats::{Error, sealed};
use crate::gpu::DeviceInfo;
use crate::scene::{Film, Sky, ToneMap};
use crate::shaders::Pixel;
use crate::trace::{Crop, Flaws, Sums, Traversal};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fmt::{self, Write};
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// All that decides the bits of a picture's samples.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Render {
    /// Version of the program.
    pub terrane: String,
    /// A hash of its code, as far as that is known to matter.
    pub build: String,
    pub renderer: String,
    /// Name of the world.
    pub world: String,
    /// SHA-256 of its file.
    pub world_file: String,
    /// SHA-256 of the world with what the command line changes in it.
    pub changes: String,
    /// SHA-256 of what the world becomes, with what its files hold.
    pub contents: String,
    pub seed: u32,
    /// Width and height of all of the picture, pixels.
    pub size: [u32; 2],
    /// Number of the frame, in a film.
    pub frame: Option<u32>,
    /// What radiance is multiplied by, m²/cd.
    pub exposure: f64,
    pub tone_map: Curve,
    pub device: String,
    pub driver: String,
    /// The exact build of the driver.
    pub driver_build: String,
}

/// [`ToneMap`], as it is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Curve {
    None,
    Filmic,
}

/// What a shard says about itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Header {
    pub render: Render,
    pub crop: Crop,
    /// Number of its first sample.
    pub first: u32,
    /// Samples that the whole picture has, of which these are a part.
    pub of: Option<u32>,
    pub flaws: Flaws,
    /// Of a frame that is finished: what it was to be. Its sums are not kept.
    pub finished: Option<String>,
    /// SHA-256 of the picture that was made of the sums when they were complete, and how it was made.
    pub picture: Option<String>,
}

/// A shard that is whole. Its sums are not in memory yet.
pub struct Shard {
    pub header: Header,
    path: PathBuf,
    reader: sealed::Reader,
}

impl Render {
    /// The picture of `world` with this film, made on `device`; it is no frame.
    ///
    /// # Errors
    /// Those of [`crate::terrain::Plan::digests`].
    pub fn of(
        world: &World,
        film: &Film,
        renderer: (Renderer, Traversal),
        device: &DeviceInfo,
    ) -> serde_json::Result<Render> {
        let renderer = match renderer {
            (Renderer::Raster, _) => "raster",
            (Renderer::Trace, Traversal::Bvh) => "trace",
            // A ray at an edge may meet the triangle on the other side.
            (Renderer::Trace, Traversal::Query) => "trace by VK_KHR_ray_query",
        };
        Ok(Render {
            terrane: env!("CARGO_PKG_VERSION").into(),
            build: concat!(env!("TERRANE_CODE"), env!("TERRANE_SHADERS")).into(),
            renderer: renderer.into(),
            world: shortened(&world.name),
            world_file: world.sha256.clone(),
            changes: hexadecimal(&Sha256::digest(world.document.to_string())),
            contents: contents(world)?,
            seed: world.seed,
            size: [film.width, film.height],
            frame: None,
            exposure: film.exposure.into(),
            tone_map: match film.tone_map {
                ToneMap::None => Curve::None,
                ToneMap::Filmic => Curve::Filmic,
            },
            device: shortened(&device.name),
            driver: shortened(&device.driver),
            driver_build: device.identity.clone(),
        })
    }

    pub fn film(&self) -> Film {
        let [width, height] = self.size;
        let tone_map = match self.tone_map {
            Curve::None => ToneMap::None,
            Curve::Filmic => ToneMap::Filmic,
        };
        Film { width, height, exposure: self.exposure as f32, tone_map }
    }

    /// What is different in another picture, a few words each: first here, then there. Empty if both are the same.
    pub fn differences(&self, other: &Render) -> Vec<String> {
        let mut differences = Vec::new();
        let mut compare = |what: &str, here: &dyn ToString, there: &dyn ToString| {
            let [here, there] = [here, there].map(ToString::to_string);
            if here != there {
                differences.push(format!("{what} {here} and {there}"));
            }
        };
        let size = |[width, height]: [u32; 2]| format!("{width}x{height}");
        let frame = |frame: Option<u32>| frame.map_or("none".into(), |frame| frame.to_string());
        let short = |hash: &str| hash.chars().take(12).collect::<String>();
        compare("world", &self.world, &other.world);
        compare("seed", &self.seed, &other.seed);
        compare("size", &size(self.size), &size(other.size));
        compare("renderer", &self.renderer, &other.renderer);
        compare("frame", &frame(self.frame), &frame(other.frame));
        compare("device", &self.device, &other.device);
        compare("driver", &self.driver, &other.driver);
        compare("version of terrane", &self.terrane, &other.terrane);
        compare("world file with SHA-256", &short(&self.world_file), &short(&other.world_file));
        if self.world_file == other.world_file && self.seed == other.seed {
            compare("world as --set makes it, with SHA-256", &short(&self.changes), &short(&other.changes));
        }
        if self.changes == other.changes {
            compare(
                "contents of the world's files, with SHA-256",
                &short(&self.contents),
                &short(&other.contents),
            );
        }
        // What follows from none of these.
        if differences.is_empty() && self != other {
            differences.push("build of terrane or of the driver".into());
        }
        differences
    }

    /// What a picture says of itself: no times, no names of machines.
    pub fn comments(&self, samples: u32) -> String {
        let Render { world, world_file, seed, device, .. } = self;
        format!(
            "world {world}, sha256 {world_file}, seed {seed}, {samples} samples a pixel, traced on {device}"
        )
    }
}

/// Headers have a bounded length.
fn shortened(name: &str) -> String {
    name.chars().take(100).collect()
}

/// What the keys and files of a world come to, but for what the picture's own fields say.
fn contents(world: &World) -> serde_json::Result<String> {
    let World { plan, light, sea, surface, plants, viewpoint, camera_path, fov, tracing, .. } = world;
    let mut hasher = Hasher(Sha256::new());
    plan.digests()?.iter().for_each(|digest| hasher.0.update(digest));
    if let Sky::Map(map) = &light.sky {
        hasher.0.update(bytemuck::cast_slice(&map.texels));
    }
    // How values are shown for debugging has all their digits, and every field that is added; but no texels.
    let all = (light, sea, surface, plants, viewpoint, camera_path, fov, tracing);
    // A hash takes any text.
    let _ = write!(hasher, "{all:?}");
    Ok(hexadecimal(&hasher.0.finalize()))
}

struct Hasher(Sha256);

impl Write for Hasher {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.update(text);
        Ok(())
    }
}

/// Writes a shard; the file that bore its name is then called `older`, if that is given.
///
/// # Errors
/// Those of [`sealed::write()`].
pub fn write(path: &Path, older: Option<&Path>, header: &Header, sums: Option<&Sums>) -> Result<(), Error> {
    sealed::write_keeping(path, older, header, |writer| {
        let Some(sums) = sums else { return Ok(()) };
        let (ends, pixels) = sums.parts();
        writer.values(&ends)?;
        writer.values(pixels)
    })
}

/// Opens a shard: `None` if there is no such file. Takes little memory, however long the file is.
///
/// # Errors
/// When it can't be read, or is damaged.
pub fn open(path: &Path) -> Result<Option<Shard>, Error> {
    let (header, reader): (Header, _) = match sealed::Reader::open(path) {
        Err(Error::Read { source, .. }) if source.kind() == io::ErrorKind::NotFound => return Ok(None),
        opened => opened?,
    };
    let Header { render, crop, .. } = &header;
    let [width, height] = render.size;
    if crop.pixels() == 0 || !crop.within(&Crop::whole(width, height)) {
        return Err(corrupt(path, "its pixels are none of its picture"));
    }
    if !(render.exposure > 0.0 && render.exposure.is_finite()) {
        return Err(corrupt(path, "its exposure is none"));
    }
    let sums = u128::from(Sums::blocks_of(crop)) * 4 + u128::from(crop.pixels()) * size_of::<Pixel>() as u128;
    let promised = if header.finished.is_some() { 0 } else { sums };
    if u128::from(reader.left()) != promised + u128::from(sealed::SEAL) {
        return Err(corrupt(path, "it has another length than it should have"));
    }
    // Reads all of it, so that nothing that follows is about damaged bytes.
    sealed::verify(path)?;
    Ok(Some(Shard { header, path: path.into(), reader }))
}

impl Shard {
    /// What it holds; `None` of a frame that is finished.
    ///
    /// # Errors
    /// When it can't be read, is damaged, or there is no memory for it.
    pub fn sums(self) -> Result<Option<Sums>, Error> {
        let Shard { header: Header { crop, first, flaws, finished, .. }, path, mut reader } = self;
        if finished.is_some() {
            return Ok(None);
        }
        let ends = reader.values(Sums::blocks_of(&crop) as usize)?;
        let pixels: Vec<Pixel> = reader.values(crop.pixels() as usize)?;
        reader.finish()?;
        let sums = Sums::from_parts(crop, first, &ends, pixels, flaws);
        sums.map(Some).ok_or_else(|| corrupt(&path, "it has numbers of samples that can't be"))
    }

    /// Numbers of the samples that all of its pixels have: `None` if some have more than others, or if it holds no sums.
    ///
    /// # Errors
    /// Those of [`Shard::sums`].
    pub fn samples(mut self) -> Result<Option<Range<u32>>, Error> {
        if self.header.finished.is_some() {
            return Ok(None);
        }
        let ends: Vec<u32> = self.reader.values(Sums::blocks_of(&self.header.crop) as usize)?;
        let (first, end) = (self.header.first, ends.first().copied().unwrap_or_default());
        Ok((ends.iter().all(|other| *other == end) && end >= first).then_some(first..end))
    }
}

fn corrupt(path: &Path, reason: &str) -> Error {
    Error::Corrupt { path: path.into(), format: "shard", reason: reason.into() }
}
