//! Layers of the land, as rasters on the host.

use crate::app::{Error, land};
use crate::core::color::{linear_from_srgb, srgb8_from_linear};
use crate::core::resample::resample;
use crate::formats::{Window, extremes, sidecar::Range};
use crate::gpu::{self, Gpu, Image, Recorder, format::R32f, format::Rgba32f};
use crate::raster::{Maps, Renderer};
use crate::scene::Population;
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
    /// First row north; the channels of a sample lie together.
    pub values: Vec<f32>,
    /// What files of integers map to their range.
    pub range: [f32; 2],
}

impl Raster {
    pub fn window(&self) -> Window<'_> {
        Window::whole(&self.values, self.size, self.layer.channels().len())
    }

    /// The range as sidecars say it.
    pub fn in_words(&self) -> Range {
        let [min, max] = self.range;
        Range { min, max, unit: self.layer.unit().into() }
    }

    /// The same land with so many samples along each side.
    fn resized(mut self, cells: u32) -> Self {
        let size = [cells; 2];
        if self.size == size {
            return self;
        }
        let channels = self.layer.channels().len();
        let [least, most] = self.range;
        self.values = resample(&self.values, self.size, size, channels);
        self.size = size;
        // Interpolation overshoots at steps: there is no water less than none.
        self.values.iter_mut().for_each(|value| *value = value.clamp(least, most));
        match self.layer {
            Layer::Normal => self.values.as_chunks_mut().0.iter_mut().for_each(normalise),
            Layer::Splat => self.values.as_chunks_mut().0.iter_mut().for_each(share_out),
            Layer::Simulated(_) | Layer::Slope => self.range = extremes(&self.values),
        }
        self
    }
}

/// Gives a normal that is stored as n·½ + ½ the length 1.
fn normalise(stored: &mut [f32; 3]) {
    let normal = stored.map(|component| 2.0 * component - 1.0);
    let length = normal.iter().map(|component| component * component).sum::<f32>().sqrt();
    *stored = normal.map(|component| component / length * 0.5 + 0.5);
}

/// Makes weights sum to 1.
fn share_out(weights: &mut [f32; 4]) {
    let sum: f32 = weights.iter().sum();
    *weights = weights.map(|weight| weight / sum);
}

/// Where layers come from.
pub struct Source<'a> {
    gpu: &'a Gpu,
    world: &'a World,
    simulation: &'a Simulation,
    /// Samples along a side of what it yields.
    cells: u32,
    /// Once a layer has needed them.
    maps: Option<Maps>,
}

impl<'a> Source<'a> {
    /// Rasters will have `cells` samples along a side.
    pub fn new(gpu: &'a Gpu, world: &'a World, simulation: &'a Simulation, cells: u32) -> Self {
        Source { gpu, world, simulation, cells, maps: None }
    }

    pub fn raster(&mut self, layer: Layer) -> Result<Raster, Error> {
        let (size, values) = match layer {
            Layer::Simulated(layer) => scalar(self.gpu, &self.simulation.layer(layer)?)?,
            Layer::Slope => scalar(self.gpu, &self.maps()?.slope)?,
            Layer::Normal => vector::<3>(self.gpu, &self.maps()?.normal)?,
            Layer::Splat => vector::<4>(self.gpu, &self.maps()?.splat)?,
        };
        let range = if layer.channels().len() == 1 { extremes(&values) } else { [0.0, 1.0] };
        Ok(Raster { layer, size, values, range }.resized(self.cells))
    }

    /// The ground's own colour as an sRGB picture, three bytes a pixel, first row north, of at most `most` pixels a side: the
    /// mean of so many samples each.
    pub fn albedo(&mut self, most: u32) -> Result<([u32; 2], Vec<u8>), Error> {
        let gpu = self.gpu;
        let image = &self.maps()?.albedo;
        let mut rec = Recorder::new(gpu);
        let download = rec.download(image);
        let [cells, _] = image.size();
        let finished = rec.submit()?.wait()?;
        Ok(reduced(&download.take(&finished), cells, cells.min(most)))
    }

    fn maps(&mut self) -> Result<&Maps, Error> {
        let maps = match self.maps.take() {
            Some(maps) => maps,
            None => {
                let camera = land::camera(self.gpu, self.world, self.simulation)?;
                let scene = land::scene(self.world, self.simulation.land()?, camera, Population::default());
                Renderer::new(self.gpu)?.maps(&scene)?
            }
        };
        Ok(self.maps.insert(maps))
    }
}

/// A square picture of sRGB and a fourth byte with `to` pixels a side instead of `from`, without that byte. Light is averaged,
/// not its code.
fn reduced(pixels: &[[u8; 4]], from: u32, to: u32) -> ([u32; 2], Vec<u8>) {
    let linear: [f32; 256] = std::array::from_fn(|byte| linear_from_srgb(byte as f32 / 255.0));
    let edge = |index: u32| (u64::from(index) * u64::from(from) / u64::from(to)) as usize;
    let mut bytes = Vec::with_capacity(3 * to as usize * to as usize);
    for row in 0..to {
        for column in 0..to {
            let (mut sum, mut count) = ([0.0_f32; 3], 0.0);
            for row in edge(row)..edge(row + 1) {
                for column in edge(column)..edge(column + 1) {
                    let pixel = pixels[row * from as usize + column];
                    sum = std::array::from_fn(|channel| sum[channel] + linear[usize::from(pixel[channel])]);
                    count += 1.0;
                }
            }
            bytes.extend(sum.map(|sum| srgb8_from_linear(sum / count, 0.5)));
        }
    }
    ([to; 2], bytes)
}

fn scalar(gpu: &Gpu, image: &Image<R32f>) -> gpu::Result<([u32; 2], Vec<f32>)> {
    let mut rec = Recorder::new(gpu);
    let download = rec.download(image);
    let finished = rec.submit()?.wait()?;
    Ok((image.size(), download.take(&finished)))
}

/// The first `COUNT` channels of an image.
fn vector<const COUNT: usize>(gpu: &Gpu, image: &Image<Rgba32f>) -> gpu::Result<([u32; 2], Vec<f32>)> {
    let mut rec = Recorder::new(gpu);
    let download = rec.download(image);
    let finished = rec.submit()?.wait()?;
    // Large lands leave no room for a second copy.
    let mut values: Vec<f32> = bytemuck::cast_vec(download.take(&finished));
    let count = values.len() / 4;
    if COUNT < 4 {
        for texel in 0..count {
            values.copy_within(4 * texel..4 * texel + COUNT, COUNT * texel);
        }
        values.truncate(COUNT * count);
    }
    Ok((image.size(), values))
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

    /// What each of the values of a sample is; one without a name where there is one.
    pub fn channels(self) -> &'static [&'static str] {
        match self {
            Layer::Simulated(_) | Layer::Slope => &[""],
            Layer::Normal => &["east", "north", "up"],
            Layer::Splat => &["grass", "rock", "sand", "sea_floor"],
        }
    }

    pub fn is_height(self) -> bool {
        self == Layer::Simulated(Simulated::Height)
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
