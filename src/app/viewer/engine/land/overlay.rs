//! Layers of the land in false colours, over the picture.

use super::Land;
use crate::app::Error;
use crate::gpu::{Gpu, Image, Recorder, format::R32f};
use crate::raster::{self, Scale, Shown};
use crate::terrain::{self, Layer};

/// What is laid over the picture in false colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlay {
    pub map: Map,
    pub opacity: f32,
}

/// What can be looked at in false colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Map {
    Layer(Layer),
    /// Degrees.
    Slope,
    Materials,
}

impl Map {
    /// All that a world with these processes has.
    pub fn all(plan: &terrain::Plan) -> Vec<Map> {
        let layers = Layer::ALL.into_iter().filter(|layer| layer.exists_in(plan)).map(Map::Layer);
        layers.chain([Map::Slope, Map::Materials]).collect()
    }

    pub fn name(self) -> &'static str {
        match self {
            Map::Layer(layer) => layer.name(),
            Map::Slope => "slope",
            Map::Materials => "materials",
        }
    }

    pub fn unit(self) -> &'static str {
        match self {
            Map::Layer(Layer::Flow) => "m³/s",
            Map::Layer(Layer::Wetness) | Map::Materials => "",
            Map::Layer(_) => "m",
            Map::Slope => "°",
        }
    }

    /// Depths and flows run through powers of ten.
    fn scale(self) -> Scale {
        match self {
            Map::Layer(Layer::Water | Layer::Flow | Layer::Sediment) => Scale::Logarithmic,
            _ => Scale::Linear,
        }
    }
}

/// What the colours of an overlay stand for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Legend {
    pub map: Map,
    pub bounds: [f32; 2],
    pub scale: Scale,
}

impl Land {
    /// The layer over the picture, of the land as it is.
    pub(super) fn overlay(&mut self, gpu: &Gpu) -> Result<Option<raster::Overlay>, Error> {
        let Some(Overlay { map, opacity }) = self.overlay else { return Ok(None) };
        if self.shown.is_none() {
            let scale = map.scale();
            let (shown, bounds) = match map {
                Map::Materials => {
                    let maps = self.live.maps()?;
                    (Shown::Materials(maps.splat), [0.0, 1.0])
                }
                Map::Slope | Map::Layer(_) => {
                    let image = match map {
                        Map::Layer(layer) => self.simulation.layer(layer)?,
                        Map::Slope | Map::Materials => self.live.maps()?.slope,
                    };
                    let bounds = bounds(gpu, &image, scale)?;
                    (Shown::Values { image, bounds, scale }, bounds)
                }
            };
            self.shown = Some((raster::Overlay { shown, opacity }, Legend { map, bounds, scale }));
        }
        Ok(self.shown.as_ref().map(|(overlay, _)| raster::Overlay { opacity, ..overlay.clone() }))
    }
}

/// What the colours of a layer stand for: nearly all of its values.
fn bounds(gpu: &Gpu, image: &Image<R32f>, scale: Scale) -> Result<[f32; 2], Error> {
    let mut rec = Recorder::new(gpu);
    let values = rec.download(image);
    let mut values = values.take(&rec.submit()?.wait()?);
    if scale == Scale::Logarithmic {
        values.retain(|value| *value > 1e-6);
    }
    values.retain(|value| value.is_finite());
    if values.is_empty() {
        return Ok(if scale == Scale::Logarithmic { [1e-3, 1.0] } else { [0.0, 1.0] });
    }
    let mut at = |share: f64| {
        let index = (share * (values.len() - 1) as f64) as usize;
        *values.select_nth_unstable_by(index, f32::total_cmp).1
    };
    let [low, high] = [at(0.005), at(0.995)];
    Ok([low, if high > low { high } else { low + low.abs().max(1e-3) }])
}
