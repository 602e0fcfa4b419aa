//! The state of a run: a place in its schedule, and the images that hold the land there. A run that is given both goes on
//! to the same bits.

use super::{Fields, Stage};
use crate::gpu::{
    self, Gpu, Image, Recorder,
    format::{Format, R32f, Rgba32f},
};
use serde::{Deserialize, Serialize};

/// A place in the schedule of a run, between two passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Position {
    pub stage: Stage,
    /// Iterations of it that are done; all of them where it is over.
    pub iteration: u32,
    /// Of the next one, processes that are done …
    pub process: u32,
    /// … and of the next one of these, passes.
    pub pass: u32,
}

/// An image of the state. Every texel is made of 32-bit floats.
pub struct Part {
    pub name: &'static str,
    image: Texels,
}

enum Texels {
    R(Image<R32f>),
    Rgba(Image<Rgba32f>),
}

impl Part {
    /// Number of floats.
    pub fn floats(&self) -> usize {
        let (size, channels) = match &self.image {
            Texels::R(image) => (image.size(), 1),
            Texels::Rgba(image) => (image.size(), 4),
        };
        size[0] as usize * size[1] as usize * channels
    }

    /// The floats, texel by texel, row by row.
    pub fn download(&self, gpu: &Gpu) -> gpu::Result<Vec<f32>> {
        match &self.image {
            Texels::R(image) => download(gpu, image),
            Texels::Rgba(image) => download(gpu, image),
        }
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        4 * self.floats() as u64
    }

    /// A copy on the device, as it is now.
    ///
    /// # Errors
    /// No memory for it.
    pub(super) fn copied(&self, gpu: &Gpu, rec: &mut Recorder) -> gpu::Result<Part> {
        let image = match &self.image {
            Texels::R(image) => Texels::R(copied(gpu, rec, image)?),
            Texels::Rgba(image) => Texels::Rgba(copied(gpu, rec, image)?),
        };
        Ok(Part { name: self.name, image })
    }

    /// Replaces all of it by a part of the same name.
    pub(super) fn fill(&self, rec: &mut Recorder, from: &Part) {
        match (&self.image, &from.image) {
            (Texels::R(image), Texels::R(from)) => rec.copy(from, image),
            (Texels::Rgba(image), Texels::Rgba(from)) => rec.copy(from, image),
            (Texels::R(_), Texels::Rgba(_)) | (Texels::Rgba(_), Texels::R(_)) => {}
        }
    }

    /// Replaces all of it, in the order of [`Part::download`].
    pub fn upload(&self, gpu: &Gpu, floats: &[f32]) -> gpu::Result<()> {
        match &self.image {
            Texels::R(image) => upload(gpu, image, floats),
            Texels::Rgba(image) => upload(gpu, image, floats),
        }
    }
}

/// The images that hold the land at `position`, where the stage has `iterations`. All others are zero there, or are written
/// before they are read again: the other halves of pairs, for example.
pub(super) fn parts(fields: &Fields, position: Position, iterations: u32) -> Vec<Part> {
    // Without `..`, so that an image that is added is kept, or left out for a reason.
    let Fields {
        grid: _,
        sea_level: _,
        height,
        start,
        change,
        water,
        sediment,
        axis,
        diagonal,
        slope,
        reef,
        carbon,
        // Filled from the plan.
        controls: _,
    } = fields;
    let stage = position.stage;
    let under_way = position.iteration < iterations;

    let mut parts = vec![
        Part { name: "height", image: Texels::R(height.src().clone()) },
        Part { name: "start", image: Texels::R(start.clone()) },
        Part { name: "change", image: Texels::R(change.clone()) },
    ];
    if stage >= Stage::Hydraulic {
        parts.extend([
            Part { name: "water", image: Texels::Rgba(water.src().clone()) },
            Part { name: "sediment", image: Texels::R(sediment.src().clone()) },
            Part { name: "axis", image: Texels::Rgba(axis.src().clone()) },
            Part { name: "diagonal", image: Texels::Rgba(diagonal.src().clone()) },
        ]);
    }
    if stage == Stage::Hydraulic && under_way {
        parts.push(Part { name: "slope", image: Texels::R(slope.clone()) });
    }
    if stage == Stage::Reef {
        parts.push(Part { name: "reef", image: Texels::R(reef.clone()) });
    }
    if stage == Stage::Reef && under_way {
        parts.push(Part { name: "carbon", image: Texels::R(carbon.src().clone()) });
    }
    parts
}

/// Clears every image that a state may leave out: there it is zero.
pub(super) fn clear(rec: &mut Recorder, fields: &Fields) {
    // Without `..`, as above.
    let Fields {
        grid: _,
        sea_level: _,
        height,
        start,
        change,
        water,
        sediment,
        axis,
        diagonal,
        slope,
        reef,
        carbon,
        controls: _,
    } = fields;
    rec.concurrent(|rec| {
        for image in [height.src(), height.dst(), start, change, sediment.src(), sediment.dst(), slope, reef] {
            rec.clear(image);
        }
        for image in [carbon.src(), carbon.dst()] {
            rec.clear(image);
        }
        for pair in [water, axis, diagonal] {
            rec.clear(pair.src());
            rec.clear(pair.dst());
        }
    });
}

fn copied<F: Format>(gpu: &Gpu, rec: &mut Recorder, image: &Image<F>) -> gpu::Result<Image<F>> {
    let copy = Image::new(gpu, "snapshot", image.size())?;
    rec.copy(image, &copy);
    Ok(copy)
}

fn download<F: Format>(gpu: &Gpu, image: &Image<F>) -> gpu::Result<Vec<f32>> {
    let mut rec = Recorder::new(gpu);
    let download = rec.download(image);
    let texels = download.take(&rec.submit()?.wait()?);
    Ok(bytemuck::cast_vec(texels))
}

fn upload<F: Format>(gpu: &Gpu, image: &Image<F>, floats: &[f32]) -> gpu::Result<()> {
    let mut rec = Recorder::new(gpu);
    rec.upload(image, bytemuck::cast_slice(floats));
    rec.submit()?.wait()?;
    Ok(())
}
