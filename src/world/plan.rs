//! From what is written to what the makers take: files are loaded, defaults that depend on other keys are filled in,
//! and what can't go together is refused.

use super::fault::{Cause, Complaint, Fault};
use super::keys::{self, EDGE_OFFSET};
use super::models::{self, Models};
use super::place::{KeyPath, shown};
use super::planting;
use crate::core::grid::Grid;
use crate::core::hash::derive_seed;
use crate::core::memory::mebibytes;
use crate::formats::{self, Hints, Panorama};
use crate::plants;
use crate::scene::{self, SkyMap};
use crate::sky;
use crate::terrain::layers::{Combine, Generator, Layer};
use crate::terrain::{Boundary, Controls, FARTHEST_GROUND, Map, Plan, reef, seabed, thermal};
use glam::DVec3;
use std::path::Path;
use std::sync::Arc;

/// What the keys become, with what is remarkable about them.
pub struct Planned {
    pub plan: Plan,
    pub light: scene::Light,
    pub viewpoint: scene::Viewpoint,
    pub camera_path: scene::CameraPath,
    pub film: scene::Film,
    pub models: Vec<Arc<scene::Model>>,
    pub rules: Vec<plants::planting::Rule>,
    pub standing: Vec<scene::Population>,
    pub warnings: Vec<String>,
}

/// Checks what `world` says as a whole. Paths of files start from `folder`.
///
/// # Errors
/// Everything that can't go together, and every file that can't be used.
pub fn plan(world: &keys::World, folder: &Path) -> Result<Planned, Vec<Fault>> {
    let terrain = &world.terrain;
    let mut check =
        Check { folder, extent: terrain.extent, maps: Vec::new(), faults: Vec::new(), warnings: Vec::new() };
    let plan = Plan {
        grid: Grid { cells: terrain.cells, extent: terrain.extent },
        layers: check.layers(terrain, world.seed),
        sea_level: world.sea.level,
        boundary: world.erosion.as_ref().map_or(Boundary::Sea, |erosion| erosion.boundary),
        controls: check.controls(&world.controls),
        hydraulic: world.erosion.as_ref().and_then(|erosion| erosion.hydraulic),
        thermal: check.thermal(world.erosion.as_ref()),
        seabed_smoothing: world.erosion.as_ref().map_or(0.0, |erosion| erosion.seabed_smoothing),
        reef: check.reef(world.reef.as_ref()),
    };
    check.passes(&plan);
    check.surface(&world.surface);
    let light = check.light(world);
    let viewpoint = check.viewpoint(&world.camera.view, &plan);
    let camera_path = check.camera_path(&world.camera, plan.final_sea_level());
    let [width, height] = world.render.size;
    let film =
        scene::Film { width, height, exposure: world.render.exposure, tone_map: world.render.tone_map };
    let species: Vec<&str> = world.species.iter().map(|(name, _)| name.as_str()).collect();
    let Models { models, mut rules, standing } =
        models::models(&world.models, &species, world.seed, &mut check);
    let count = species.len();
    let of_models = models.iter().map(|model| model.name.as_str());
    let names: Vec<&str> = species.into_iter().chain(of_models).collect();
    rules.extend(planting::rules(&world.plants, &names, world.seed, plan.hydraulic.is_some(), &mut check));
    models::warn_of_unused(&models, count, &rules, &mut check);
    let Check { faults, warnings, .. } = check;
    if faults.is_empty() {
        Ok(Planned { plan, light, viewpoint, camera_path, film, models, rules, standing, warnings })
    } else {
        Err(faults)
    }
}

/// Most memory, bytes, that all maps of a world take together.
const MOST_MAPS: u64 = 1 << 30;

/// What the values of a map are read as.
#[derive(Clone, Copy, PartialEq)]
enum Use {
    /// Metres, by the ends of the scale where the world gives them.
    Heights(Option<[f32; 2]>),
    Factors,
}

/// A map as it was read, for whoever names the same file in the same way.
struct Read {
    path: String,
    hints: Hints,
    as_what: Use,
    map: Arc<Map>,
}

/// Gathers what is wrong, and the maps that were read.
pub struct Check<'a> {
    pub folder: &'a Path,
    /// Of the terrain, metres.
    pub extent: f32,
    maps: Vec<Read>,
    faults: Vec<Fault>,
    warnings: Vec<String>,
}

impl Check<'_> {
    fn layers(&mut self, terrain: &keys::Terrain, seed: u32) -> Vec<Layer> {
        // The height that a later `combine = "power"` leaves as it is.
        let mut cone_height = None;
        let mut layers = Vec::new();
        for (index, layer) in terrain.layers.iter().enumerate() {
            let place = KeyPath::from("terrain.layers").join(index);
            let own_seed = |own: Option<u32>| own.unwrap_or_else(|| derive_seed(seed, &place.to_string()));
            let (place, generator, combine, reference) = match layer {
                keys::Layer::Crater(keys::Crater { level }) => {
                    if index == 0 {
                        self.refuse(
                            &[place],
                            Complaint::new("is a crater with nothing to sink into", NO_FIRST),
                        );
                    }
                    layers.push(Layer::Crater { level: *level });
                    continue;
                }
                keys::Layer::Cone(cone) => {
                    let place = place.join("cone");
                    self.cone(cone, terrain.extent, &place);
                    let &keys::Cone { height, radius, exponent, center, combine, reference } = cone;
                    (place, Some(Generator::Cone { height, radius, exponent, center }), combine, reference)
                }
                keys::Layer::Simplex(simplex) => {
                    let &keys::Simplex { wavelength, octaves, warp, combine, reference, .. } = simplex;
                    let plain = matches!(combine, keys::Combine::Power | keys::Combine::Multiply);
                    let amplitude = simplex.amplitude.unwrap_or(if plain { 0.2 } else { 20.0 });
                    let one = if combine == keys::Combine::Multiply { 1.0 } else { 0.0 };
                    let (offset, seed) = (simplex.offset.unwrap_or(one), own_seed(simplex.seed));
                    let generator = Generator::Simplex { amplitude, offset, wavelength, octaves, warp, seed };
                    (place.join("simplex"), Some(generator), combine, reference)
                }
                keys::Layer::DiamondSquare(square) => {
                    let &keys::DiamondSquare {
                        n, init_height, spread, reduction, combine, reference, ..
                    } = square;
                    let seed = own_seed(square.seed);
                    let generator = Generator::DiamondSquare { n, init_height, spread, reduction, seed };
                    (place.join("diamond_square"), Some(generator), combine, reference)
                }
                keys::Layer::Heightmap(heightmap) => {
                    let place = place.join("heightmap");
                    let map = self.heightmap(heightmap, &place);
                    let generator = map.map(|map| Generator::Heightmap { map });
                    (place, generator, heightmap.combine, heightmap.reference)
                }
            };
            let combine = self.combine(combine, reference, cone_height, index, &place);
            if let keys::Layer::Cone(cone) = layer {
                cone_height = Some(cone.height);
            }
            layers.extend(generator.map(|generator| Layer::Generate { generator, combine }));
        }
        layers
    }

    fn cone(&mut self, cone: &keys::Cone, extent: f32, place: &KeyPath) {
        if cone.radius > extent {
            let label = format!("allowed: up to the terrain's extent, {extent} m");
            let paths = [place.join("radius"), "terrain.extent".into()];
            self.refuse(&paths, Complaint::new("is wider than the terrain", label));
        }
        if cone.center.iter().any(|along| along.abs() > extent / 2.0) {
            let label = format!("allowed: up to {} m from the middle, half of the extent", extent / 2.0);
            let paths = [place.join("center"), "terrain.extent".into()];
            self.refuse(&paths, Complaint::new("lies outside the terrain", label));
        }
    }

    fn combine(
        &mut self,
        combine: keys::Combine,
        reference: Option<f32>,
        cone_height: Option<f32>,
        index: usize,
        place: &KeyPath,
    ) -> Combine {
        if index == 0 && !matches!(combine, keys::Combine::Add | keys::Combine::Max) {
            self.refuse(&[place.join("combine")], Complaint::new("has nothing to combine with", NO_FIRST));
        }
        if reference.is_some() && combine != keys::Combine::Power {
            let complaint = Complaint::new("has no use here", "goes with `combine = \"power\"`").about_key();
            self.refuse(&[place.join("reference")], complaint);
        }
        match combine {
            keys::Combine::Add => Combine::Add,
            keys::Combine::Multiply => Combine::Multiply,
            keys::Combine::Max => Combine::Max,
            keys::Combine::Min => Combine::Min,
            keys::Combine::Power => {
                let reference = reference.or(cone_height).unwrap_or_else(|| {
                    if index > 0 {
                        let complaint =
                            Complaint::new("is missing", "no cone before this layer gives the height")
                                .help("`reference` is the height in metres that the power leaves as it is");
                        self.refuse(&[place.join("reference"), place.join("combine")], complaint);
                    }
                    1.0
                });
                Combine::Power { reference }
            }
        }
    }

    fn heightmap(&mut self, heightmap: &keys::Heightmap, place: &KeyPath) -> Option<Arc<Map>> {
        let (min, max, file) = (place.join("min"), place.join("max"), place.join("file"));
        let range = match (heightmap.min, heightmap.max) {
            (Some(least), Some(most)) if least < most => Some([least, most]),
            (None, None) => None,
            (Some(_), Some(_)) => {
                self.refuse(
                    &[max, min],
                    Complaint::new("must be above `min`", "heights rise from `min` to `max`"),
                );
                return None;
            }
            (least, _) => {
                let (missing, other) = if least.is_none() { (min, max) } else { (max, min) };
                self.refuse(
                    &[missing, other],
                    Complaint::new("is missing", "give both `min` and `max`").about_key(),
                );
                return None;
            }
        };
        let path = heightmap.file.as_ref()?;
        let hints = Hints { byte_order: heightmap.byte_order, first_row: heightmap.first_row };
        let raw = matches!(formats::extension(Path::new(path)).as_str(), "raw" | "r16");
        if hints.byte_order.is_some() && !raw {
            let complaint = Complaint::new("has no use here", "only a RAW file leaves it open").about_key();
            self.refuse(&[place.join("byte_order"), file.clone()], complaint);
        }
        let map = self.map(path, &file, hints, Use::Heights(range))?;
        if map.values.iter().any(|height| height.abs() > FARTHEST_GROUND) {
            let label = format!("a map of heights within {FARTHEST_GROUND} m of the datum");
            self.refuse(&[file], Complaint::new("holds heights that no ground has", label));
        }
        Some(map)
    }

    fn controls(&mut self, controls: &keys::Controls) -> Controls {
        let mut map = |path: &Option<String>, name: &str| {
            let place = KeyPath::from("controls").join(name);
            let map = self.map(path.as_ref()?, &place, Hints::default(), Use::Factors)?;
            if map.values.iter().any(|value| *value < 0.0) {
                let place = place.clone();
                self.refuse(&[place], Complaint::new("holds values below 0", "a map of factors, from 0 up"));
            }
            // More of what is just stable is not.
            if name == "mask" && map.values.iter().any(|value| *value > 1.0) {
                self.refuse(&[place], Complaint::new("holds values above 1", "a map of shares, from 0 to 1"));
            }
            Some(map)
        };
        Controls {
            rain: map(&controls.rain, "rain"),
            erodibility: map(&controls.erodibility, "erodibility"),
            mask: map(&controls.mask, "mask"),
        }
    }

    /// A map of factors.
    pub fn factors(&mut self, path: &str, place: &KeyPath) -> Option<Arc<Map>> {
        self.map(path, place, Hints::default(), Use::Factors)
    }

    pub fn warn(&mut self, warning: String) {
        self.warnings.push(warning);
    }

    fn map(&mut self, path: &str, place: &KeyPath, hints: Hints, as_what: Use) -> Option<Arc<Map>> {
        let same = |read: &&Read| read.path == path && read.hints == hints && read.as_what == as_what;
        if let Some(read) = self.maps.iter().find(same) {
            return Some(read.map.clone());
        }
        let map = formats::read_map(&self.folder.join(path), hints).and_then(|map| match as_what {
            Use::Heights(range) => map.into_metres(range),
            Use::Factors => Ok(map),
        });
        match map {
            Ok(map) => {
                self.warn_of_another_land(path, place, &map);
                let formats::Map { width, height, values, .. } = map;
                let map = Arc::new(Map { width, height, values });
                let others: u64 = self.maps.iter().map(|read| read.map.bytes()).sum();
                if others + map.bytes() > MOST_MAPS {
                    let label = format!(
                        "it takes {} of memory beside {} of other maps, and all may take {}",
                        mebibytes(map.bytes()),
                        mebibytes(others),
                        mebibytes(MOST_MAPS)
                    );
                    let complaint = Complaint::new(format!("names \"{}\"", shown(path)), label)
                        .help("scale maps down, or name the same file with the same keys where one will do");
                    self.refuse(std::slice::from_ref(place), complaint);
                    return None;
                }
                self.maps.push(Read { path: path.into(), hints, as_what, map: map.clone() });
                Some(map)
            }
            Err(error) => {
                let cause = match error {
                    formats::Error::NoRange { .. } | formats::Error::Unsuitable { .. } => Cause::World,
                    _ => Cause::File,
                };
                let complaint = Complaint::new(format!("names \"{}\"", shown(path)), error.to_string());
                self.refuse(std::slice::from_ref(place), Complaint { cause, ..complaint });
                None
            }
        }
    }

    /// A map is stretched over the terrain, whatever it was made for.
    fn warn_of_another_land(&mut self, path: &str, place: &KeyPath, map: &formats::Map) {
        let Some(whole) = map.extent else { return };
        let [across, down] = map.tile.map_or([1, 1], |tile| tile.of);
        let covered = [across, down].map(|tiles| whole / tiles as f32);
        let terrain = self.extent;
        if covered.iter().all(|length| (length - terrain).abs() <= 1e-4 * terrain) {
            return;
        }
        let land = match map.tile {
            Some(tile) => format!(
                "{} × {} m, tile {}, {} of {across} × {down} of a land of {whole} × {whole} m",
                covered[0], covered[1], tile.column, tile.row
            ),
            None => format!("{whole} × {whole} m"),
        };
        self.warnings.push(format!(
            "`{place}` names \"{}\", which by its sidecar covers {land}, and is stretched over the terrain's \
             {terrain} × {terrain} m; change `terrain.extent` if that isn't meant",
            shown(path)
        ));
    }

    fn thermal(&mut self, erosion: Option<&keys::Erosion>) -> Option<thermal::Params> {
        let erosion = erosion?;
        let thermal = erosion.thermal.as_ref()?;
        let refuse = |key: &str, label: &str| {
            let place = KeyPath::from("erosion.thermal").join(key);
            (place, Complaint::new("has no use here", label).about_key())
        };
        let useless = match (&erosion.hydraulic, thermal.every, thermal.duration) {
            (None, Some(_), _) => {
                Some(refuse("every", "counts iterations of hydraulic erosion, and there is none"))
            }
            (Some(_), _, Some(_)) => Some(refuse("duration", "hydraulic erosion says how long")),
            _ => None,
        };
        if let Some((place, complaint)) = useless {
            self.refuse(&[place, "erosion.hydraulic".into()], complaint);
        }
        let &keys::Thermal { law, repose, repose_under_water, diffusivity, settle, .. } = thermal;
        let every = thermal.every.unwrap_or(4);
        let duration = thermal.duration.unwrap_or(5000.0);
        Some(thermal::Params { law, repose, repose_under_water, diffusivity, every, duration, settle })
    }

    fn reef(&mut self, reef: Option<&reef::Params>) -> Option<reef::Params> {
        let reef = reef?;
        if reef.ocean_depth < reef.max_depth {
            let label = format!("allowed: `max_depth`, {} m, and more", reef.max_depth);
            let complaint = Complaint::new("must not be less than `reef.max_depth`", label)
                .help("coral would grow in the open ocean, where its carbon never runs out");
            self.refuse(&["reef.ocean_depth".into(), "reef.max_depth".into()], complaint);
        }
        if reef.keep >= reef.max_depth {
            let label = format!("allowed: less than `max_depth`, {} m", reef.max_depth);
            let complaint = Complaint::new("leaves no depth to grow in", label);
            self.refuse(&["reef.keep".into(), "reef.max_depth".into()], complaint);
        }
        self.warn_of_drowning(reef);
        Some(reef.clone())
    }

    fn warn_of_drowning(&mut self, reef: &reef::Params) {
        let speeds =
            reef.stages.iter().filter(|stage| stage.duration > 0.0).map(|stage| stage.rise / stage.duration);
        let fastest = speeds.fold(0.0, f32::max);
        let least = if reef.rubble.is_some() { 4.0 } else { 3.5 };
        if reef.growth < least * fastest {
            self.warnings.push(format!(
                "the sea rises by {fastest} m/yr and the reef may drown: give `reef.growth` at least {}",
                least * fastest
            ));
        }
    }

    /// Refuses what takes longer than a day even on a fast device, stage by stage.
    fn passes(&mut self, plan: &Plan) {
        let grid = plan.grid;
        if let Some(settle) = plan.thermal.and_then(|thermal| thermal.settle) {
            self.bound(&[(settle.passes(grid).into(), &["erosion.thermal.settle.length"], LARGER_CELLS)]);
        }
        if let Some(water) = &plan.hydraulic {
            let steps = water.steps(grid);
            let count = f64::from(steps.count);
            let slides = plan.thermal.map_or(0.0, |thermal| {
                let every = f64::from(thermal.every);
                count / every * f64::from(thermal.passes(grid, every * steps.step))
            });
            let sweeps = count * f64::from(water.sediment_sweeps(grid));
            let help = "less time, a larger `safety`, or larger cells: fewer `terrain.cells`, a larger `terrain.extent`";
            self.bound(&[
                (count, &["erosion.hydraulic.duration", "erosion.hydraulic.safety"], help),
                (sweeps, &["erosion.hydraulic.sediment_diffusivity"], LARGER_CELLS),
                (slides, &["erosion.thermal.diffusivity"], LARGER_CELLS),
            ]);
        } else if let Some(thermal) = &plan.thermal {
            let passes = thermal.passes(grid, thermal.duration.into());
            let keys = ["erosion.thermal.diffusivity", "erosion.thermal.duration"];
            self.bound(&[(passes.into(), &keys, LARGER_CELLS)]);
        }
        let sweeps = seabed::sweeps(plan.seabed_smoothing, grid);
        self.bound(&[(sweeps.into(), &["erosion.seabed_smoothing"], LARGER_CELLS)]);
        if let Some(reef) = &plan.reef {
            let steps = f64::from(reef.steps());
            let sweeps = steps * f64::from(reef.sweeps(grid));
            let rubble = reef.rubble.map_or(0.0, |rubble| f64::from(rubble.passes) / f64::from(rubble.every));
            self.bound(&[
                (steps, &["reef.step", "reef.stages"], "longer steps, or a shorter history"),
                (sweeps, &["reef.diffusivity"], LARGER_CELLS),
                (steps * rubble, &["reef.rubble.passes"], "fewer passes, or a larger `every`"),
            ]);
        }
    }

    /// Refuses a stage by the first of its rows that is too much: passes, the keys that ask for them, what to do.
    fn bound(&mut self, rows: &[(f64, &[&str], &str)]) {
        const MOST: f64 = 1e7;

        if let Some((_, keys, help)) = rows.iter().find(|(passes, ..)| *passes > MOST) {
            let keys: Vec<KeyPath> =
                keys.iter().chain(&["terrain.cells"]).map(|key| KeyPath::from(*key)).collect();
            let complaint =
                Complaint::new("asks for too much work", "more than ten million passes over the terrain");
            self.refuse(&keys, complaint.help(*help));
        }
    }

    fn surface(&mut self, surface: &scene::Surface) {
        let mut rows = vec![("rock_slope", surface.rock_slope), ("dry_height", surface.dry_height)];
        if let Some(snow) = &surface.snow {
            rows.extend([("snow.height", snow.height), ("snow.slope", snow.slope)]);
        }
        for (name, [begin, end]) in rows {
            if begin >= end {
                let place = name.split('.').fold(KeyPath::from("surface"), |place, part| place.join(part));
                self.refuse(&[place], Complaint::new("must rise", "the first number below the second"));
            }
        }
        if let Some(scene::ByHeight { rock_start, ground_end, .. }) = surface.by_height
            && ground_end <= rock_start
        {
            let place = KeyPath::from("surface.by_height");
            let complaint = Complaint::new("must lie above `rock_start`", format!("{rock_start} m and more"));
            self.refuse(&[place.join("ground_end"), place.join("rock_start")], complaint);
        }
    }

    fn light(&mut self, world: &keys::World) -> scene::Light {
        let turbidity = match &world.sky {
            keys::Sky::Preetham(preetham) => preetham.turbidity,
            keys::Sky::HosekWilkie(model) => model.turbidity,
            // Only the sun's strength asks for it: a clear day.
            _ => 3.0,
        };
        let turbidity = f64::from(turbidity);
        let (direction, sun) = match &world.sun {
            keys::Sun::None => (DVec3::Y, None),
            keys::Sun::Place(place) => self.sun_of_place(place, turbidity),
            keys::Sun::Direct(sun) => {
                let zenith = std::f64::consts::FRAC_PI_2 - f64::from(sun.elevation);
                let direction = sky::sun::Position { zenith, azimuth: sun.azimuth.into() }.direction();
                let &keys::SunDirect { irradiance, diameter, .. } = sun;
                (direction, Some(scene::Sun { direction: direction.as_vec3(), irradiance, diameter }))
            }
        };
        let sky = match &world.sky {
            keys::Sky::None => scene::Sky::None,
            keys::Sky::Constant(constant) => scene::Sky::Constant { radiance: constant.radiance },
            keys::Sky::Preetham(_) => {
                self.warn_of_sky(turbidity, direction);
                sky::preetham::sky(turbidity, direction)
            }
            keys::Sky::HosekWilkie(model) => {
                sky::hosek_wilkie::sky(turbidity, model.albedo.into(), direction)
            }
            keys::Sky::Map(map) => self.sky_map(map),
        };
        let clouds = match &world.sky {
            keys::Sky::Preetham(preetham) => preetham.clouds,
            keys::Sky::HosekWilkie(model) => model.clouds,
            _ => 0.0,
        };
        scene::Light { sky, sun, air: world.render.aerial.then(|| sky::air::air(turbidity)), clouds }
    }

    fn sun_of_place(&mut self, place: &keys::SunPlace, turbidity: f64) -> (DVec3, Option<scene::Sun>) {
        let position = sky::sun::Position::at(&sky::sun::Place {
            latitude: place.latitude.into(),
            longitude: place.longitude.into(),
            utc_offset: place.utc_offset.into(),
            day: place.day.into(),
            time: place.time.into(),
        });
        let sun = sky::sun::sun(position, turbidity);
        if sun.is_none() {
            let below = position.zenith.to_degrees() - 90.0;
            self.warnings.push(format!(
                "the sun stands {below:.1} degrees below the horizon: there is no sun, and the sky has the light of sunset; \
                 change `sun.place.time` or `sun.place.utc_offset`"
            ));
        }
        (position.direction(), sun)
    }

    fn sky_map(&mut self, written: &keys::SkyMap) -> scene::Sky {
        let keys::SkyMap { file: Some(path), scale, rotation } = written else {
            // That it is missing was noted.
            return scene::Sky::None;
        };
        match formats::read_sky(&self.folder.join(path)) {
            Ok(Panorama { size: [width, height], mut pixels }) => {
                pixels.iter_mut().flatten().for_each(|channel| *channel = (*channel * scale).min(1e30));
                let map = SkyMap { width, height, texels: pixels, rotation: f64::from(*rotation) };
                scene::Sky::Map(Arc::new(map.reduced()))
            }
            Err(error) => {
                let place = KeyPath::from("sky.map.file");
                let cause =
                    if matches!(error, formats::Error::NoSky { .. }) { Cause::World } else { Cause::File };
                let complaint = Complaint::new(format!("names \"{}\"", shown(path)), error.to_string());
                self.refuse(std::slice::from_ref(&place), Complaint { cause, ..complaint });
                scene::Sky::None
            }
        }
    }

    fn warn_of_sky(&mut self, turbidity: f64, sun: DVec3) {
        if !(2.0..=8.0).contains(&turbidity) {
            self.warnings.push(format!(
                "`sky.preetham.turbidity` is {turbidity}; the model is good from 2 to 8, and wrong near the horizon elsewhere"
            ));
        }
        let elevation = 90.0 - sun.y.clamp(-1.0, 1.0).acos().to_degrees();
        if (0.0..3.0).contains(&elevation) {
            self.warnings.push(format!(
                "the sun stands {elevation:.1} degrees high; below 3 the sky of Preetham 1999 is too bright"
            ));
        }
    }

    fn viewpoint(&mut self, view: &keys::View, plan: &Plan) -> scene::Viewpoint {
        match view {
            keys::View::FrameIsland(frame) => {
                let &keys::FrameIsland { azimuth, elevation, distance } = frame;
                scene::Viewpoint::Fixed(scene::View::FrameIsland { azimuth, elevation, distance })
            }
            keys::View::LookAt(look) => scene::Viewpoint::Fixed(self.look_at(look, plan.final_sea_level())),
            keys::View::Stand(stand) => scene::Viewpoint::Stand(self.stand(stand, plan.grid)),
        }
    }

    /// The camera's way, with what each keyframe leaves out.
    fn camera_path(&mut self, camera: &keys::Camera, sea_level: f32) -> scene::CameraPath {
        let (mut at, mut to, mut fov, mut focus) = (None, None, camera.fov, camera.focus);
        let mut path = scene::CameraPath::default();
        for (index, key) in camera.keyframes.iter().enumerate() {
            let place = KeyPath::from("camera.keyframes").join(index);
            at = key.position.or(at);
            to = key.target.or(to);
            (fov, focus) = (key.fov.unwrap_or(fov), key.focus.unwrap_or(focus));
            if let Some(before) = path.keys.last().filter(|before| before.frame >= key.frame) {
                let label = format!("allowed: more than {}, the frame of the keyframe before", before.frame);
                self.refuse(&[place.join("frame"), place.clone()], Complaint::new("is out of order", label));
            }
            for (name, value) in [("position", at), ("target", to)] {
                if value.is_none() {
                    let complaint = Complaint::new("is missing", "the first keyframe must say it");
                    self.refuse(&[place.join(name), place.clone()], complaint.about_key());
                }
            }
            let (Some(position), Some(target)) = (at, to) else { return path };
            self.stands(&place, position, target, sea_level);
            let (position, target) = (position.into(), target.into());
            path.keys.push(scene::Keyframe { frame: key.frame, position, target, fov, focus });
        }
        path
    }

    fn look_at(&mut self, look: &keys::LookAt, sea_level: f32) -> scene::View {
        let &keys::LookAt { position, target } = look;
        self.stands(&KeyPath::from("camera.view.look_at"), position, target, sea_level);
        scene::View::LookAt { position: position.into(), target: target.into() }
    }

    /// Refuses a camera that looks nowhere, or is under the sea.
    fn stands(&mut self, place: &KeyPath, position: [f32; 3], target: [f32; 3], sea_level: f32) {
        if position == target {
            let complaint = Complaint::new("is where the camera stands", "another point than `position`");
            self.refuse(&[place.join("target"), place.join("position")], complaint);
        }
        if position[1] <= sea_level {
            let label = format!("allowed: above {sea_level} m, where the sea is in the end");
            let complaint = Complaint::new("lies under the sea", label)
                .help("raise its second number, or lower `sea.level`");
            self.refuse(&[place.join("position"), "sea.level".into()], complaint);
        }
    }

    fn stand(&mut self, stand: &keys::Stand, grid: Grid) -> scene::Stand {
        let &keys::Stand { at, height, azimuth, distance, expected_height, edge_offset } = stand;
        let key = KeyPath::from("camera.view.stand");
        let half = grid.extent / 2.0;
        let place = match at {
            Some(at) => {
                let others = [("expected_height", expected_height), ("edge_offset", edge_offset)];
                for (name, _) in others.iter().filter(|(_, value)| value.is_some()) {
                    let complaint = Complaint::new("has no use here", "`at` says where the camera stands");
                    self.refuse(&[key.join(name), key.join("at")], complaint.about_key());
                }
                if at.iter().any(|along| along.abs() > half) {
                    let label = format!("allowed: up to {half} m from the middle, half of the extent");
                    let complaint = Complaint::new("lies outside the terrain", label);
                    self.refuse(&[key.join("at"), "terrain.extent".into()], complaint);
                }
                scene::Place::At(at.into())
            }
            None => {
                let edge_offset = edge_offset.unwrap_or((EDGE_OFFSET as f32).min(half));
                if edge_offset > half {
                    let label = format!("allowed: up to {half} m, half of the extent");
                    let complaint = Complaint::new("leaves no place to stand", label);
                    self.refuse(&[key.join("edge_offset"), "terrain.extent".into()], complaint);
                }
                scene::Place::Height { expected: expected_height.unwrap_or(0.0), edge_offset }
            }
        };
        scene::Stand { place, height, azimuth, distance }
    }

    pub fn refuse(&mut self, paths: &[KeyPath], complaint: Complaint) {
        self.faults.push(Fault { paths: paths.to_vec(), complaint, text: None });
    }
}

const LARGER_CELLS: &str =
    "a smaller value, or larger cells: fewer `terrain.cells`, a larger `terrain.extent`";
const NO_FIRST: &str = "the first layer starts from level ground";
