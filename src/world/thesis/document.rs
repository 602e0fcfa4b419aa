//! Settings as the text of a world file.

use super::files::{Generator, Material, Sky};
use super::folder::Folder;
use super::settings::{Named, Settings};
use super::species::{self, Species};
use crate::world::fault::Origins;
use crate::world::keys::NO_SEA;
use std::fmt::Write;
use std::path::Path;

/// Vertical field of view, degrees: the picture is as high as the eye is far from it.
const FOV: f64 = 53.13;

/// Power of a sun that is as strong as the model's.
const FULL_SUN: f64 = 1e5;

/// What a world file has no place for, one sentence each.
pub fn warnings(settings: &Settings) -> Vec<String> {
    let color = settings.sky.sun_color;
    let left_out = format!(
        "sky.conf: `SunColor` {} is left out: the sun has the colour that the model gives it, by its height and `Turbidity`; \
         `SunColor 1 1 1` says so, and `sun.direct.irradiance` in a world file gives it another",
        words(color)
    );
    if color == [1.0; 3] { Vec::new() } else { vec![left_out] }
}

/// The text, and where its keys come from.
pub fn write(folder: &Folder, settings: &Settings) -> (String, Origins) {
    let species = species::write(settings);
    let parts = [
        head(folder),
        terrain(settings),
        surface(settings),
        light(settings),
        camera(settings),
        render(settings),
    ];
    let text = parts.join("\n") + &species.text + &planting(settings, &species);
    (text, origins(folder, settings, species))
}

fn origins(folder: &Folder, settings: &Settings, species: Species) -> Origins {
    let mut origins = species.origins;
    let spawners = settings.spawners.iter().enumerate();
    origins.extend(spawners.map(|(index, spawner)| (format!("plants.{index}"), spawner.file.clone())));
    let places = [("terrain", "terrain"), ("camera", "camera"), ("sky", "sky"), ("sun", "sky")];
    origins.extend(places.map(|(key, file)| (key.into(), format!("{file}.conf"))));
    Origins(origins.into_iter().map(|(key, file)| (key, folder.shown(&file))).collect())
}

/// The grids of plants, one a spawner. Where there is nothing that one could place, it places nothing.
fn planting(settings: &Settings, species: &Species) -> String {
    let mut text = String::new();
    for Named { file, says: spawner } in &settings.spawners {
        let names = match spawner.generator_type {
            Generator::Tree => &species.trees,
            Generator::Plant => &species.plants,
        };
        let names: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
        let _ = write!(
            text,
            "\n# {file}\n\
             [[plants]]\n\
             [plants.grid]\n\
             species = [{}]\n\
             offset = {}\n\
             cells = {}\n\
             cell_size = {}\n\
             probability = {}\n\
             jitter = {}\n\
             scale = {}\n",
            names.join(", "),
            array(spawner.camera_offset),
            array([spawner.x_grid_n, spawner.z_grid_n]),
            spawner.cell_size,
            spawner.spawn_probability,
            spawner.random_position_percentage,
            array([spawner.min_element_scale, spawner.max_element_scale])
        );
    }
    text
}

fn head(folder: &Folder) -> String {
    let path = Path::new(&folder.name);
    let name =
        path.file_name().map(|name| name.to_string_lossy().escape_debug().to_string()).unwrap_or_default();
    format!(
        "# The folder of settings \"{name}\" (after Rudzki 2020, \"Realistic rendering of procedural generated forest\n\
         # landscapes\") as a world.\n\
         format = 1\n\
         erosion = \"none\"\n\
         reef = \"none\"\n"
    )
}

fn terrain(settings: &Settings) -> String {
    let terrain = &settings.terrain;
    let n = terrain.n as u32;
    // A grid has 64 samples at least; its samples then lie on those of the diamonds and squares, and between them.
    let cells = (1_u32 << n.max(6)) + 1;
    format!(
        "# terrain.conf\n\
         [terrain]\n\
         cells = {cells}\n\
         extent = {}\n\
         layers = [{{ diamond_square = {{ n = {n}, init_height = {}, spread = {}, reduction = {} }} }}]\n\
         \n\
         # There is no sea.\n\
         [sea]\n\
         level = {NO_SEA}\n",
        terrain.size, terrain.init_height, terrain.spread, terrain.spread_reduction_rate
    )
}

fn surface(settings: &Settings) -> String {
    let (terrain, materials) = (&settings.terrain, &settings.materials);
    format!(
        "# Snow lies by its height above the sea, and there is none.\n\
         [surface]\n\
         snow = \"none\"\n\
         \n\
         [surface.by_height]\n\
         rock_start = {}\n\
         ground_end = {}\n\
         \n\
         # materials/ground.mat\n\
         [surface.by_height.ground]\n\
         {}\n\
         # materials/rock.mat\n\
         [surface.by_height.rock]\n\
         {}",
        terrain.rock_start,
        terrain.ground_end,
        material(&materials.ground),
        material(&materials.rock)
    )
}

/// The keys of a material, one a line.
pub fn material(material: &Material) -> String {
    format!(
        "reflectance = {}\nsecond_reflectance = {}\nposition_factor = {}\nvalue_factor = {}\n",
        array(material.color1),
        array(material.color2),
        material.noise_position_factor,
        material.noise_value_factor
    )
}

fn light(settings: &Settings) -> String {
    let sky = &settings.sky;
    format!(
        "# sky.conf: SunColor {} is left out, the sun has the model's; SunPower {} is in the exposure.\n\
         [sky.preetham]\n\
         turbidity = {}\n\
         clouds = 0\n\
         \n\
         [sun.place]\n\
         latitude = {}\n\
         longitude = {}\n\
         utc_offset = {}\n\
         day = {}\n\
         time = {}\n",
        words(sky.sun_color),
        sky.sun_power,
        sky.turbidity,
        sky.latitude,
        sky.longitude,
        utc_offset(sky),
        sky.julian_day,
        sky.time_of_day
    )
}

/// Hours east. The zones from 15 on lie west of Greenwich.
fn utc_offset(sky: &Sky) -> f64 {
    let zone = sky.standard_meridian;
    if zone > 14.0 { zone - 24.0 } else { zone }
}

fn camera(settings: &Settings) -> String {
    let camera = &settings.camera;
    let [east, _, south] = camera.look_direction;
    let edge_offset = camera.edge_min_offset.min(settings.terrain.size / 2.0);
    let azimuth = libm::atan2(east, -south).to_degrees();
    format!(
        "# camera.conf\n\
         [camera]\n\
         fov = {FOV}\n\
         \n\
         [camera.view.stand]\n\
         height = {}\n\
         azimuth = {azimuth}\n\
         distance = {}\n\
         edge_offset = {edge_offset}\n\
         expected_height = {}\n",
        camera.look_height, camera.look_distance, camera.expected_position_y
    )
}

fn render(settings: &Settings) -> String {
    let (tracer, window, sky) = (&settings.path_tracer, &settings.view_mode, &settings.sky);
    let exposure = sky.sky_luminance_factor * (sky.sun_power / FULL_SUN);
    format!(
        "# pathTracer.conf: PhotoName {}, DebugMode {}.\n\
         # viewMode.conf: Enabled {}, Resolution {}, CameraVelocity {}.\n\
         # sky.conf: the exposure is SkyLuminanceFactor · SunPower / 100000.\n\
         [render]\n\
         size = {}\n\
         exposure = {exposure}\n\
         renderer = \"trace\"\n\
         spp = {}\n\
         bounces = {}\n",
        tracer.photo_name,
        u8::from(tracer.debug_mode),
        u8::from(window.enabled),
        words(window.resolution),
        window.camera_velocity,
        array(tracer.resolution),
        tracer.samples,
        tracer.max_ray_bounces
    )
}

fn array<const N: usize>(numbers: [f64; N]) -> String {
    format!("[{}]", numbers.map(|number| number.to_string()).join(", "))
}

fn words<const N: usize>(numbers: [f64; N]) -> String {
    numbers.map(|number| number.to_string()).join(" ")
}
