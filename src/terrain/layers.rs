//! Base terrain: a list of layers, each combined with what the ones before it made.

use super::{Fields, Map, Plan, Process, image_of};
use crate::{
    core::grid::Grid,
    gpu::{self, Compute, Gpu, Image, Recorder, format::R32f},
    shaders::terrain::{cone, crater, diamond_square, raster, simplex},
};
use serde::Serialize;
use std::sync::Arc;

#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Layer {
    /// A generator's field, combined with the height so far.
    Generate { generator: Generator, combine: Combine },
    /// Mirrors everything above `level` (m) down: `h = 2C − h` (Korošec & Lebar Bajec (5)).
    Crater { level: f32 },
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Generator {
    /// `height · (1 − (r/radius)^exponent)` inside `radius`, else 0 (1, 2). `center` is world x, z in metres.
    Cone { height: f32, radius: f32, exponent: f32, center: [f32; 2] },
    /// `offset + amplitude · Σ η(p·2^i/wavelength) / 2^i` (3) with p displaced by `warp` metres of three-octave noise
    /// of the same wavelength.
    Simplex { amplitude: f32, offset: f32, wavelength: f32, octaves: u32, warp: f32, seed: u32 },
    /// Diamond–square on (2^n + 1)², sampled bicubically (Fournier, Fussell & Carpenter 1982): corners from
    /// U(−init_height, init_height), offsets from U(−spread, spread), spread times `reduction` after each level.
    DiamondSquare { n: u32, init_height: f32, spread: f32, reduction: f32, seed: u32 },
    /// Heights in metres from a file.
    Heightmap { map: Arc<Map> },
}

/// How a generator's field `v` joins the height `h`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub enum Combine {
    Add,
    Multiply,
    /// `H·(h/H)^max(0.05, 1 + v)`, 0 where h ≤ 0; H = `reference` metres (4).
    Power {
        reference: f32,
    },
    Max,
    Min,
}

impl Layer {
    /// The map that heights are taken from, if they are.
    pub(super) fn map(&self) -> Option<&Arc<Map>> {
        match self {
            Layer::Generate { generator: Generator::Heightmap { map }, .. } => Some(map),
            _ => None,
        }
    }

    /// Device memory of the raster that is sampled, if it has one.
    pub(super) fn raster_bytes(&self) -> u64 {
        let Layer::Generate { generator, .. } = self else { return 0 };
        let points = match generator {
            Generator::Cone { .. } | Generator::Simplex { .. } => 0,
            Generator::DiamondSquare { n, .. } => ((1 << n) + 1_u64).pow(2),
            Generator::Heightmap { map } => map.values.len() as u64,
        };
        4 * points
    }
}

impl Combine {
    /// As the kernels number it, with the reference height that only `Power` has.
    fn code(self) -> (u32, f32) {
        match self {
            Combine::Add => (0, 0.0),
            Combine::Multiply => (1, 0.0),
            Combine::Power { reference } => (2, reference),
            Combine::Max => (3, 0.0),
            Combine::Min => (4, 0.0),
        }
    }
}

/// The list at work: one layer an iteration.
pub struct Base(Vec<Pass>);

enum Pass {
    Cone(Compute<cone::Shader>, cone::Push),
    Simplex(Compute<simplex::Shader>, simplex::Push),
    Raster(Compute<raster::Shader>, raster::Push, Source),
    Crater(Compute<crater::Shader>, crater::Push),
}

/// What fills a raster just before it is sampled.
enum Source {
    DiamondSquare(DiamondSquare),
    Map(Arc<Map>, Image<R32f>),
}

impl Base {
    pub fn new(gpu: &Gpu, plan: &Plan) -> gpu::Result<Base> {
        plan.layers.iter().map(|layer| Pass::new(gpu, plan.grid, layer)).collect::<gpu::Result<_>>().map(Base)
    }
}

impl Process for Base {
    fn pass(&mut self, rec: &mut Recorder, fields: &mut Fields, iteration: u32, _pass: u32) {
        if let Some(pass) = self.0.get(iteration as usize - 1) {
            pass.record(rec, fields.height.src());
        }
        if iteration as usize == self.0.len() {
            fields.rebase(rec);
        }
    }
}

impl Pass {
    fn new(gpu: &Gpu, grid: Grid, layer: &Layer) -> gpu::Result<Pass> {
        let cell_size = grid.cell_size();
        let [west, north] = grid.position(0, 0);
        let (generator, (combine, reference)) = match layer {
            Layer::Crater { level } => {
                return Ok(Pass::Crater(Compute::new(gpu, ())?, crater::Push { level: *level }));
            }
            Layer::Generate { generator, combine } => (generator, combine.code()),
        };
        Ok(match generator {
            Generator::Cone { height, radius, exponent, center: [x, z] } => Pass::Cone(
                Compute::new(gpu, cone::Constants { combine })?,
                cone::Push {
                    origin: [west - x, north - z],
                    cell_size,
                    peak: *height,
                    radius: *radius,
                    exponent: *exponent,
                    reference,
                },
            ),
            Generator::Simplex { amplitude, offset, wavelength, octaves, warp, seed } => Pass::Simplex(
                Compute::new(gpu, simplex::Constants { combine })?,
                simplex::Push {
                    origin: [west, north],
                    cell_size,
                    amplitude: *amplitude,
                    offset: *offset,
                    wavelength: *wavelength,
                    octaves: *octaves,
                    warp: *warp,
                    seed: *seed,
                    reference,
                },
            ),
            Generator::DiamondSquare { n, init_height, spread, reduction, seed } => {
                let source = DiamondSquare::new(gpu, *n, *init_height, *spread, *reduction, *seed)?;
                Pass::raster(gpu, combine, reference, Source::DiamondSquare(source))?
            }
            Generator::Heightmap { map } => {
                let source = Source::Map(map.clone(), image_of(map, gpu)?);
                Pass::raster(gpu, combine, reference, source)?
            }
        })
    }

    fn raster(gpu: &Gpu, combine: u32, reference: f32, source: Source) -> gpu::Result<Pass> {
        let pass = Compute::new(gpu, raster::Constants { combine })?;
        Ok(Pass::Raster(pass, raster::Push { reference }, source))
    }

    fn record(&self, rec: &mut Recorder, height: &Image<R32f>) {
        let size = height.size();
        match self {
            Pass::Cone(pass, push) => rec.dispatch(pass, size, *push, cone::Bindings { height }),
            Pass::Simplex(pass, push) => rec.dispatch(pass, size, *push, simplex::Bindings { height }),
            Pass::Crater(pass, push) => rec.dispatch(pass, size, *push, crater::Bindings { height }),
            Pass::Raster(pass, push, source) => {
                let raster = source.fill(rec);
                rec.dispatch(pass, size, *push, raster::Bindings { height, raster });
            }
        }
    }
}

impl Source {
    fn fill(&self, rec: &mut Recorder) -> &Image<R32f> {
        match self {
            Source::DiamondSquare(source) => {
                source.record(rec);
                &source.points
            }
            Source::Map(map, image) => {
                rec.upload(image, &map.values);
                image
            }
        }
    }
}

/// Diamond–square on its own raster.
pub struct DiamondSquare {
    corners: Compute<diamond_square::Shader>,
    squares: Compute<diamond_square::Shader>,
    diamonds: Compute<diamond_square::Shader>,
    points: Image<R32f>,
    init_height: f32,
    spread: f32,
    reduction: f32,
    seed: u32,
}

impl DiamondSquare {
    fn new(
        gpu: &Gpu,
        n: u32,
        init_height: f32,
        spread: f32,
        reduction: f32,
        seed: u32,
    ) -> gpu::Result<DiamondSquare> {
        let phase = |phase| Compute::new(gpu, diamond_square::Constants { phase });
        Ok(DiamondSquare {
            corners: phase(0)?,
            squares: phase(1)?,
            diamonds: phase(2)?,
            points: Image::new(gpu, "diamond-square", [(1 << n) + 1; 2])?,
            init_height,
            spread,
            reduction,
            seed,
        })
    }

    fn record(&self, rec: &mut Recorder) {
        let last = self.points.size()[0] - 1;
        let mut pass = |pass: &Compute<_>, spacing: u32, spread: f64| {
            let push =
                diamond_square::Push { spacing: spacing as i32, spread: spread as f32, seed: self.seed };
            let points = last / spacing + 1;
            rec.dispatch(pass, [points; 2], push, diamond_square::Bindings { points: &self.points });
        };
        pass(&self.corners, last, f64::from(self.init_height));
        let mut spread = f64::from(self.spread);
        let mut spacing = last;
        while spacing > 1 {
            spacing /= 2;
            pass(&self.squares, spacing, spread);
            pass(&self.diamonds, spacing, spread);
            spread *= f64::from(self.reduction);
        }
    }
}
