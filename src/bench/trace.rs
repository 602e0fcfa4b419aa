//! How many rays a second the tracer follows, beside the crate that builds its trees, which follows the same rays with the
//! processor's vector units through a tree over the same triangles: once as land on its grid, which has a tree of its own, and once
//! as a model, whose tree is the very same.

use super::clock::{self, Stopwatch};
use super::{Error, memory};
use crate::{
    core::camera::Pinhole,
    core::grid::Grid,
    core::hash::mix,
    core::mesh::Mesh,
    gpu::{DeviceKind, Gpu, Image},
    scene::{Camera, Ground, Instance, Level, Material, Model, Part, Population, Scene, View},
    terrain::Simulation,
    trace::{Ray, Settings, Tracer, Tracing, ground, tree},
    world::{self, Overrides, World},
};
use glam::{Quat, Vec3, Vec3A};
use obvhs::{cwbvh::CwBvh, ray, triangle::Triangle};
use rayon::prelude::*;
use serde::Serialize;
use std::fmt::{self, Display, Formatter};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// What was measured, and on what.
#[derive(Clone, Debug, Serialize)]
pub struct Rays {
    #[serde(skip)]
    pub device: String,
    pub driver: String,
    pub cores: usize,
    pub triangles: usize,
    /// To build the native tree, seconds of work.
    pub build_seconds: f64,
    pub rows: Vec<Row>,
    /// Of a million triangles of land on its grid, bytes on the device.
    pub land_bytes: u64,
    /// Of a million triangles of a model, the same.
    pub model_bytes: u64,
    /// Of a million instances, the same.
    pub instance_bytes: u64,
    /// Most memory that this process has had at once, bytes, where the system tells it.
    pub peak_memory: Option<u64>,
}

/// Rays of a kind. Of several runs the fastest counts.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    pub name: &'static str,
    pub rays: usize,
    /// Million rays a second on the device: on a CPU by the work of all cores, on a GPU by its own clock.
    pub mrays: f64,
    pub native_mrays: f64,
    /// `mrays` over `native_mrays`.
    pub ratio: f64,
}

/// A million triangles: hills of 709 × 709 samples.
const WORLD: &str = r#"
format = 1
terrain.cells = 709
terrain.extent = 2000
terrain.layers = [{ simplex = { amplitude = 180, wavelength = 900, octaves = 9 } }]
erosion = "none"
reef = "none"
sea.level = -2000
camera.view = { look_at = { position = [-900, 500, 900], target = [0, 0, 0] } }
"#;

/// Rays of each kind: a picture of this side.
const SIDE: u32 = 512;
const RUNS: usize = 5;

/// Measures; between two steps `stops` is asked whether to end, and `done` is told each row.
///
/// # Errors
/// No memory; [`Error::Stopped`].
pub fn rays(gpu: &Gpu, stops: impl Fn() -> bool, mut done: impl FnMut(&Row)) -> Result<Rays, Error> {
    let info = gpu.info();
    let (device, driver) = (info.name.clone(), info.driver.clone());
    let world = world::parse("rays.toml", WORLD.as_bytes(), Path::new(""), &Overrides::default())?;
    let scene = scene(gpu, &world)?;
    let grid = scene.ground.grid;
    let camera = camera(&world);
    let heights = {
        let mut rec = crate::gpu::Recorder::new(gpu);
        let heights = rec.download(&scene.ground.height);
        heights.take(&rec.submit()?.wait()?)
    };
    let triangles: Vec<Triangle> = ground::triangles(grid, &heights, 0..grid.cells - 1)
        .iter()
        .map(|[a, b, c]| Triangle { v0: (*a).into(), v1: (*b).into(), v2: (*c).into() })
        .collect();
    let watch = Stopwatch::start();
    let native = Native::new(&triangles);
    let build_seconds = watch.stop().work.as_secs_f64();
    let tracer = Tracer::new(gpu)?;
    let mut rays = Rays {
        device,
        driver,
        cores: clock::cores(),
        triangles: triangles.len(),
        build_seconds,
        rows: Vec::new(),
        land_bytes: 0,
        model_bytes: 0,
        instance_bytes: 0,
        peak_memory: None,
    };
    let primary = primary(&camera);
    let diffuse = native.diffuse(&primary);
    let model = Scene { population: standing(grid, &heights), ground: plain(gpu)?, ..scene.clone() };
    let names = [["land, primary", "land, diffuse"], ["model, primary", "model, diffuse"]];
    for (names, scene) in names.iter().zip([&scene, &model]) {
        let tracing = tracer.begin(scene, &world.film, &camera, Settings::default())?;
        let bytes = tree_bytes(gpu) as f64 / (triangles.len() as f64 / 1e6);
        if scene.population.instances.is_empty() {
            rays.land_bytes = bytes as u64;
        } else {
            rays.model_bytes = bytes as u64;
        }
        for (name, of) in names.iter().zip([&primary, &diffuse]) {
            if stops() {
                return Err(Error::Stopped);
            }
            let row = row(gpu, name, &tracing, &native, of)?;
            done(&row);
            rays.rows.push(row);
        }
    }
    rays.instance_bytes = instances(gpu, &tracer, &model, &world, &camera)?;
    rays.peak_memory = memory::peak();
    Ok(rays)
}

/// Of several runs the fastest counts.
fn row(
    gpu: &Gpu,
    name: &'static str,
    tracing: &Tracing,
    native: &Native,
    rays: &[Ray],
) -> Result<Row, Error> {
    let volley = tracing.volley(rays)?;
    // Programs are compiled when they first run.
    volley.trace()?;
    let cores = clock::cores() as u32;
    let (mut best, mut native_best) = (Duration::MAX, Duration::MAX);
    for _ in 0..RUNS {
        let watch = Stopwatch::start();
        let stamped = volley.trace()?;
        let work = watch.stop().work / cores;
        let spent = if gpu.info().kind == DeviceKind::Cpu { work } else { stamped.unwrap_or(work) };
        best = best.min(spent);
        let watch = Stopwatch::start();
        native.meet(rays);
        native_best = native_best.min(watch.stop().work / cores);
    }
    let rate = |time: Duration| rays.len() as f64 / time.as_secs_f64() / 1e6;
    let (mrays, native_mrays) = (rate(best), rate(native_best));
    Ok(Row { name, rays: rays.len(), mrays, native_mrays, ratio: mrays / native_mrays })
}

/// Bytes on the device of what rays go through now.
fn tree_bytes(gpu: &Gpu) -> u64 {
    let usage = gpu.memory().by_name;
    ["nodes", "triangles", "coats", "placements", "acceleration"]
        .iter()
        .filter_map(|name| usage.get(*name))
        .sum()
}

/// Bytes of a million instances more.
fn instances(
    gpu: &Gpu,
    tracer: &Tracer,
    model: &Scene,
    world: &World,
    camera: &Pinhole,
) -> Result<u64, Error> {
    const MANY: u32 = 100_000;
    let bytes = |count: u32| -> Result<u64, Error> {
        let mut scene = model.clone();
        let at = |index: u32| Instance {
            position: Vec3::new((index % 317) as f32, 0.0, (index / 317) as f32) * 20.0,
            scale: 0.01,
            ..model.population.instances[0]
        };
        scene.population.instances = (0..count).map(at).collect();
        let _tracing = tracer.begin(&scene, &world.film, camera, Settings::default())?;
        Ok(tree_bytes(gpu))
    };
    Ok((bytes(MANY)? - bytes(1)?) * 1_000_000 / u64::from(MANY))
}

/// The land's triangles as a model that stands where it lies.
fn standing(grid: Grid, heights: &[f32]) -> Population {
    let at = |index: usize| {
        let [x, z] = grid.position(index as u32 % grid.cells, index as u32 / grid.cells);
        [x, heights[index], z]
    };
    let last = grid.cells - 1;
    let cell = |index: u32| {
        let nw = index / last * grid.cells + index % last;
        let [ne, sw, se] = [nw + 1, nw + grid.cells, nw + grid.cells + 1];
        [[nw, sw, ne], [ne, sw, se]]
    };
    let mesh = Mesh {
        positions: (0..grid.samples()).map(at).collect(),
        normals: vec![[0.0, 1.0, 0.0]; grid.samples()],
        uvs: Vec::new(),
        triangles: (0..last * last).flat_map(cell).collect(),
    };
    let levels = vec![Level { detail: 0.0, parts: vec![Part { material: 0, mesh }] }];
    let model = Model { name: "hills".into(), materials: vec![Material::default()], levels };
    let instance =
        Instance { model: 0, random: 0, position: Vec3::ZERO, rotation: Quat::IDENTITY, scale: 1.0 };
    Population { models: vec![Arc::new(model)], instances: [instance].into() }
}

/// Ground that is hardly any: a metre across.
fn plain(gpu: &Gpu) -> Result<Ground, Error> {
    let grid = Grid { cells: 2, extent: 1.0 };
    let image = |name: &str| Image::new(gpu, name, [grid.cells; 2]);
    let [height, water, wetness, reef] =
        [image("height")?, image("water")?, image("wetness")?, image("reef")?];
    Ok(Ground { grid, height, water, wetness, reef, sea_level: -1e6 })
}

fn scene(gpu: &Gpu, world: &World) -> Result<Scene, Error> {
    let mut simulation = Simulation::new(gpu, &world.plan)?;
    while !simulation.step(Duration::from_millis(100))?.finished {}
    Ok(Scene {
        ground: simulation.land()?,
        light: world.light.clone(),
        sea: world.sea,
        surface: world.surface.clone(),
        population: Population::default(),
        camera: Camera {
            view: View::LookAt { position: Vec3::Y, target: Vec3::ZERO, roll: 0.0 },
            fov: world.fov,
        },
    })
}

fn camera(world: &World) -> Pinhole {
    match world.viewpoint {
        crate::scene::Viewpoint::Fixed(View::LookAt { position, target, .. }) => {
            Pinhole::look_at(position, target, world.fov, 1.0)
        }
        _ => Pinhole::look_at(Vec3::new(-900.0, 500.0, 900.0), Vec3::ZERO, world.fov, 1.0),
    }
}

/// One through the middle of each pixel, in blocks of 8 × 8, as they lie together in a workgroup.
fn primary(camera: &Pinhole) -> Vec<Ray> {
    let along = |index: u32| {
        let (block, within) = (index / 64, index % 64);
        let column = 8 * (block % (SIDE / 8)) + within % 8;
        let row = 8 * (block / (SIDE / 8)) + within / 8;
        let [x, y] = [column, row].map(|at| 2.0 * (at as f32 + 0.5) / SIDE as f32 - 1.0);
        let screen = x * camera.tangent[0] * camera.right - y * camera.tangent[1] * camera.up;
        Ray { origin: camera.eye, direction: (camera.forward + screen).normalize() }
    };
    (0..SIDE * SIDE).map(along).collect()
}

/// The same tree, followed natively.
struct Native {
    tree: CwBvh,
    /// In the order of the leaves.
    triangles: Vec<Triangle>,
}

impl Native {
    fn new(triangles: &[Triangle]) -> Native {
        let tree = tree::build(triangles);
        let triangles = tree.primitive_indices.iter().map(|index| triangles[*index as usize]).collect();
        Native { tree, triangles }
    }

    /// Range and index of what the ray meets.
    fn nearest(&self, ray: &Ray) -> Option<(f32, usize)> {
        let mut hit = ray::RayHit::none();
        let ray = ray::Ray::new_inf(ray.origin.into(), ray.direction.into());
        let met = self.tree.ray_traverse(ray, &mut hit, |ray, index| self.triangles[index].intersect(ray));
        met.then_some((hit.t, hit.primitive_id as usize))
    }

    fn meet(&self, rays: &[Ray]) -> usize {
        rays.par_chunks(1024).map(|rays| rays.iter().filter(|ray| self.nearest(ray).is_some()).count()).sum()
    }

    /// From where each ray ends one goes on, in a random direction by the cosine to the normal.
    fn diffuse(&self, rays: &[Ray]) -> Vec<Ray> {
        let turned = |(index, ray): (usize, &Ray)| {
            let (range, triangle) = self.nearest(ray)?;
            let normal = self.triangles[triangle].compute_normal();
            let normal = if normal.dot(Vec3A::from(ray.direction)) > 0.0 { -normal } else { normal };
            let random = |stream: u32| mix(index as u32 ^ stream) as f32 / u32::MAX as f32;
            let height = 2.0 * random(1) - 1.0;
            let (sine, cosine) = (std::f32::consts::TAU * random(0x9e37_79b9)).sin_cos();
            let level = (1.0 - height * height).max(0.0).sqrt();
            let direction = normal + Vec3A::new(level * cosine, height, level * sine);
            let origin = ray.origin + range * ray.direction + 0.01 * Vec3::from(normal);
            Some(Ray { origin, direction: direction.normalize_or(normal).into() })
        };
        rays.iter().enumerate().filter_map(turned).collect()
    }
}

/// A table, in Markdown.
impl Display for Rays {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        let Rays { device, driver, cores, triangles, build_seconds, .. } = self;
        writeln!(
            out,
            "{device}, {driver}; {cores} cores; {triangles} triangles, their tree in {build_seconds:.2} s\n"
        )?;
        writeln!(out, "{HEADING}")?;
        self.rows.iter().try_for_each(|row| writeln!(out, "{row}"))?;
        let mebibytes = |bytes: u64| bytes as f64 / f64::from(1 << 20);
        writeln!(
            out,
            "\nmemory: {:.1} MiB a million triangles of land, {:.1} MiB of a model, {:.1} MiB a million instances",
            mebibytes(self.land_bytes),
            mebibytes(self.model_bytes),
            mebibytes(self.instance_bytes)
        )
    }
}

const HEADING: &str = "\
| rays | Mrays/s | native | ratio |
|---|--:|--:|--:|";

impl Display for Row {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        let Row { name, mrays, native_mrays, ratio, .. } = self;
        write!(out, "| `{name}` | {mrays:.2} | {native_mrays:.2} | {ratio:.2} |")
    }
}
