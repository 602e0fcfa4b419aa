//! Layers of the land, as rasters on the host.

use crate::app::{Error, land};
use crate::formats::extremes;
use crate::gpu::{self, Gpu, Image, Recorder, format::R32f, format::Rgba32f};
use crate::raster::{Maps, Renderer};
use crate::terrain::{Layer as Simulated, Plan, Simulation};
use crate::world::World;

/// What can be exported of the land.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layer {
    Simulated(Simulated),
    Slope,
    Normal,
    Splat,
}

/// One layer on the host.
pub struct Raster {
    pub layer: Layer,
    pub size: [u32; 2],
    /// One list of values a channel.
    pub channels: Vec<Vec<f32>>,
    /// What a 16-bit file maps to 0…65535.
    pub range: [f32; 2],
}

/// Where layers come from.
pub struct Source<'a> {
    gpu: &'a Gpu,
    world: &'a World,
    simulation: &'a Simulation,
    /// Once a layer has needed them.
    maps: Option<Maps>,
}

impl<'a> Source<'a> {
    pub fn new(gpu: &'a Gpu, world: &'a World, simulation: &'a Simulation) -> Self {
        Source { gpu, world, simulation, maps: None }
    }

    pub fn raster(&mut self, layer: Layer) -> Result<Raster, Error> {
        let (size, channels) = match layer {
            Layer::Simulated(layer) => scalar(self.gpu, &self.simulation.layer(layer)?)?,
            Layer::Slope => scalar(self.gpu, &self.maps()?.slope)?,
            Layer::Normal => vector(self.gpu, &self.maps()?.normal, 3)?,
            Layer::Splat => vector(self.gpu, &self.maps()?.splat, 4)?,
        };
        let range = if channels.len() == 1 { extremes(&channels[0]) } else { [0.0, 1.0] };
        Ok(Raster { layer, size, channels, range })
    }

    fn maps(&mut self) -> Result<&Maps, Error> {
        let maps = match self.maps.take() {
            Some(maps) => maps,
            None => Renderer::new(self.gpu)?.maps(&land::scene(self.world, self.simulation.land()?))?,
        };
        Ok(self.maps.insert(maps))
    }
}

fn scalar(gpu: &Gpu, image: &Image<R32f>) -> gpu::Result<([u32; 2], Vec<Vec<f32>>)> {
    let mut rec = Recorder::new(gpu);
    let download = rec.download(image);
    let finished = rec.submit()?.wait()?;
    Ok((image.size(), vec![download.take(&finished)]))
}

/// The first `count` channels of an image.
fn vector(gpu: &Gpu, image: &Image<Rgba32f>, count: usize) -> gpu::Result<([u32; 2], Vec<Vec<f32>>)> {
    let mut rec = Recorder::new(gpu);
    let download = rec.download(image);
    let finished = rec.submit()?.wait()?;
    let texels = download.take(&finished);
    let channels = (0..count).map(|channel| texels.iter().map(|texel| texel[channel]).collect()).collect();
    Ok((image.size(), channels))
}

impl Layer {
    pub const ALL: [Layer; 11] = [
        Layer::Simulated(Simulated::Height),
        Layer::Simulated(Simulated::Water),
        Layer::Simulated(Simulated::Sediment),
        Layer::Simulated(Simulated::Wear),
        Layer::Simulated(Simulated::Deposit),
        Layer::Simulated(Simulated::Reef),
        Layer::Simulated(Simulated::Flow),
        Layer::Slope,
        Layer::Normal,
        Layer::Splat,
        Layer::Simulated(Simulated::Wetness),
    ];

    pub fn name(self) -> &'static str {
        match self {
            Layer::Simulated(layer) => layer.name(),
            Layer::Slope => "slope",
            Layer::Normal => "normal",
            Layer::Splat => "splat",
        }
    }

    /// Unit of the values; 1 for shares.
    pub fn unit(self) -> &'static str {
        match self {
            Layer::Simulated(Simulated::Flow) => "m³/s",
            Layer::Simulated(Simulated::Wetness) | Layer::Normal | Layer::Splat => "1",
            Layer::Simulated(_) => "m",
            Layer::Slope => "degrees",
        }
    }

    /// Whether the simulation has it, and it need not be drawn.
    pub fn is_simulated(self) -> bool {
        matches!(self, Layer::Simulated(_))
    }

    pub fn exists_in(self, plan: &Plan) -> bool {
        match self {
            Layer::Simulated(layer) => layer.exists_in(plan),
            Layer::Slope | Layer::Normal | Layer::Splat => true,
        }
    }
}
