//! Scenes for Mitsuba 3 (Jakob et al., mitsuba-renderer.org): `scene.xml`, meshes as PLY, and the sky as an environment map. What
//! it shows there is what [`crate::trace`] shows with constant materials, value for value, with Mitsuba's own plugins.
//!
//! The files of meshes have our coordinates. The scene moves all of it so that the eye is at the origin: Mitsuba starts rays
//! off surfaces by a share of their distance from the origin, which beside a camera at 100 m would be a centimetre.

use super::Error;
use super::file::{self, Written};
use super::{exr, ply};
use crate::core::camera::Pinhole;
use crate::core::mesh::Mesh;
use crate::scene::{Film, Instance, Light, Material, Model, Part, Population, Sky, SkyMap, Sun, dome};
use crate::shaders::Corner;
use glam::{DVec3, Mat4, Vec3};
use std::f64::consts::PI;
use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::Path;

/// A scene that is written.
pub struct Contents<'a> {
    pub land: Land,
    pub population: &'a Population,
    pub light: &'a Light,
    pub camera: &'a Pinhole,
    pub film: &'a Film,
    /// Radius of the lens and distance of what is sharp, metres.
    pub lens: [f32; 2],
    /// Most scatterings between a light and the eye.
    pub bounces: u32,
    /// Samples a pixel.
    pub samples: u32,
}

/// The land's triangles, as the tracer has them.
pub struct Land {
    pub corners: Vec<Corner>,
    pub triangles: Vec<[u32; 3]>,
}

/// Width and height of the picture of a clear sky.
const SKY: [u32; 2] = [1024, 513];

/// Distance of the sun's disc, metres: so far that it stands still wherever one goes.
const SUN_DISTANCE: f32 = 1e8;

/// Writes the scene into `folder`, which exists; `scene.xml` comes first among what was written.
///
/// # Errors
/// Those of [`file::write()`].
pub fn write(folder: &Path, contents: &Contents) -> Result<Vec<Written>, Error> {
    let mut written = vec![write_land(&folder.join("terrain.ply"), &contents.land)?];
    for (name, model, _, part) in parts(contents.population) {
        written.push(ply::write(&folder.join(&name), &part.mesh)?);
        if glows(&contents.population.models[model], part) {
            written.push(ply::write(&folder.join(back_name(&name)), &turned(&part.mesh))?);
        }
    }
    if !matches!(contents.light.sky, Sky::None | Sky::Constant { .. }) {
        written.push(write_sky(&folder.join("sky.exr"), &contents.light.sky)?);
    }
    let xml = file::write(&folder.join("scene.xml"), |writer| write_scene(writer, contents))?;
    written.insert(0, xml);
    Ok(written)
}

/// What of the scene is not shown as terrane shows it without `render.constant_materials`, a sentence each.
pub fn losses(contents: &Contents, sea: bool) -> Vec<String> {
    let Contents { population, light, .. } = contents;
    let mut losses = vec![
        "materials have the mean of their colours, and neither noise nor relief nor gloss; compare with \
         `render.constant_materials = true`"
            .to_owned(),
    ];
    let mut lose = |lost: bool, sentence: &str| losses.extend(lost.then(|| sentence.to_owned()));
    lose(light.air.is_some(), "there is no aerial perspective; compare with `render.aerial = false`");
    lose(sea, "there is no water: what it covers lies dry");
    lose(light.clouds > 0.0, "there are no clouds");
    let dazzling = |material: &Material| lobes(material).is_some_and(|lobes| lobes.sum > 1.0);
    let too_much = population.models.iter().flat_map(|model| &model.materials).any(dazzling);
    lose(too_much, "a material sends on more light than it receives; its colours are cut off at 1");
    losses
}

/// Parts of models that stand somewhere: the file's name, the model's index, and that of the part.
fn parts(population: &Population) -> impl Iterator<Item = (String, usize, usize, &Part)> {
    let mut used = vec![false; population.models.len()];
    population.instances.iter().for_each(|instance| used[instance.model as usize] = true);
    let models = population.models.iter().enumerate().zip(used).filter(|(_, used)| *used);
    models.flat_map(|((model, of), _)| {
        let parts = of.levels.first().into_iter().flat_map(|level| &level.parts).enumerate();
        let filled = parts.filter(|(_, part)| !part.mesh.triangles.is_empty());
        filled.map(move |(index, part)| (mesh_name(model, index), model, index, part))
    })
}

fn mesh_name(model: usize, part: usize) -> String {
    format!("model_{model}_{part}.ply")
}

fn back_name(front: &str) -> String {
    front.replace(".ply", "_back.ply")
}

/// The back of a mesh that sends out light: Mitsuba's emitters have one side. It lies behind the front by a little, so that from
/// either side the right one is met first.
fn turned(mesh: &Mesh) -> Mesh {
    const GAP: f32 = 5e-5;
    let [least, greatest] = mesh.bounds().map(Vec3::from);
    let gap = GAP * (greatest - least).length();
    let behind = |(position, normal): (&[f32; 3], &[f32; 3])| {
        (Vec3::from(*position) - gap * Vec3::from(*normal)).to_array()
    };
    Mesh {
        positions: mesh.positions.iter().zip(&mesh.normals).map(behind).collect(),
        normals: mesh.normals.iter().map(|normal| normal.map(|axis| -axis)).collect(),
        uvs: mesh.uvs.clone(),
        triangles: mesh.triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect(),
    }
}

/// With a colour for each corner, as `r`, `g` and `b`: linear Rec.709.
fn write_land(path: &Path, land: &Land) -> Result<Written, Error> {
    let Land { corners, triangles } = land;
    file::write(path, |writer| {
        write!(
            writer,
            "ply\nformat binary_little_endian 1.0\ncomment terrane: metres, +X east, +Y up, +Z south\n\
             element vertex {}\n",
            corners.len()
        )?;
        for name in ["x", "y", "z", "nx", "ny", "nz", "r", "g", "b"] {
            writeln!(writer, "property float {name}")?;
        }
        write!(
            writer,
            "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
            triangles.len()
        )?;
        for Corner { point, normal, albedo } in corners {
            for value in point.iter().chain(normal).chain(albedo) {
                writer.write_all(&value.to_le_bytes())?;
            }
        }
        for triangle in triangles {
            writer.write_all(&[3])?;
            for index in triangle {
                writer.write_all(&index.to_le_bytes())?;
            }
        }
        Ok(())
    })
}

/// All of the sky, below the horizon, too, in cd/m². The first row is straight up, the last straight down, as Mitsuba takes them, and
/// one in the middle is the horizon; columns go clockwise from north.
fn write_sky(path: &Path, sky: &Sky) -> Result<Written, Error> {
    let [width, height] = match sky {
        // What is bilinear between its middles is bilinear between these, all but.
        Sky::Map(map) => [(2 * map.width).min(SkyMap::MOST[0]), (2 * map.height).min(SkyMap::MOST[1]) + 1],
        _ => SKY,
    };
    let pixel = |index: u32| {
        let azimuth = 2.0 * PI * (f64::from(index % width) + 0.5) / f64::from(width);
        let zenith = PI * f64::from(index / width) / f64::from(height - 1);
        let view = DVec3::new(zenith.sin() * azimuth.sin(), zenith.cos(), -zenith.sin() * azimuth.cos());
        dome::radiance(sky, view).map(|channel| channel as f32)
    };
    let pixels: Vec<_> = (0..width * height).map(pixel).collect();
    exr::write_picture(path, [width, height], &pixels, 1.0)
}

fn write_scene(writer: &mut impl Write, contents: &Contents) -> io::Result<()> {
    let Contents { population, light, camera, film, lens, bounces, samples, .. } = contents;
    writeln!(
        writer,
        "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n\
         <!-- terrane: metres, +X east, +Y up, +Z south; values are radiance (cd/m²) times the exposure -->\n\
         <scene version=\"3.0.0\">\n\
         <default name=\"spp\" value=\"{samples}\"/>\n\
         <integrator type=\"path\"><integer name=\"max_depth\" value=\"{}\"/></integrator>",
        bounces + 1
    )?;
    writer.write_all(sensor(camera, film, *lens).as_bytes())?;
    writer.write_all(lights(light, film.exposure).as_bytes())?;
    let from_eye = Mat4::from_translation(-camera.eye);
    writeln!(
        writer,
        "<shape type=\"ply\"><string name=\"filename\" value=\"terrain.ply\"/>{}\n\
         <bsdf type=\"twosided\"><bsdf type=\"diffuse\"><texture name=\"reflectance\" type=\"mesh_attribute\">\
         <string name=\"name\" value=\"vertex_color\"/></texture></bsdf></bsdf></shape>",
        transform(from_eye)
    )?;
    let used: Vec<_> = parts(population).collect();
    for (model, of) in population.models.iter().enumerate() {
        let mine = || used.iter().filter(|(_, index, ..)| *index == model);
        if mine().next().is_none() {
            continue;
        }
        for (index, material) in of.materials.iter().enumerate() {
            writeln!(writer, "{}", bsdf(&material_name(model, index), material))?;
        }
        if mine().any(|(.., part)| !glows(of, part)) {
            writeln!(writer, "<shape type=\"shapegroup\" id=\"model_{model}\">")?;
            for (name, _, _, part) in mine().filter(|(.., part)| !glows(of, part)) {
                writeln!(writer, "{}</shape>", shape(name, &material_name(model, part.material)))?;
            }
            writeln!(writer, "</shape>")?;
        }
    }
    for instance in population.instances.iter() {
        let model = instance.model as usize;
        let Some(of) = population.models.get(model) else { continue };
        let at = from_eye * placed(instance);
        let parts = || of.levels.first().into_iter().flat_map(|level| &level.parts).enumerate();
        let filled = || parts().filter(|(_, part)| !part.mesh.triangles.is_empty());
        if filled().any(|(_, part)| !glows(of, part)) {
            writeln!(
                writer,
                "<shape type=\"instance\"><ref id=\"model_{model}\"/>{}</shape>",
                transform(at)
            )?;
        }
        for (index, part) in filled().filter(|(_, part)| glows(of, part)) {
            let front = mesh_name(model, index);
            let emission = of.materials[part.material].emission.map(|channel| channel * film.exposure);
            for name in [back_name(&front), front] {
                writeln!(
                    writer,
                    "{}{}<emitter type=\"area\">{}</emitter></shape>",
                    shape(&name, &material_name(model, part.material)),
                    transform(at),
                    rgb("radiance", emission)
                )?;
            }
        }
    }
    writeln!(writer, "</scene>")
}

/// A camera at the origin.
fn sensor(camera: &Pinhole, film: &Film, [radius, focus]: [f32; 2]) -> String {
    let Film { width, height, .. } = film;
    let (kind, lens) = match radius {
        0.0 => ("perspective", String::new()),
        _ => ("thinlens", float("aperture_radius", radius) + &float("focus_distance", focus)),
    };
    let point = |Vec3 { x, y, z }: Vec3| format!("{x},{y},{z}");
    format!(
        "<sensor type=\"{kind}\">{lens}<string name=\"fov_axis\" value=\"y\"/>{}{}{}\
         <transform name=\"to_world\"><lookat origin=\"0,0,0\" target=\"{}\" up=\"{}\"/></transform>\n\
         <film type=\"hdrfilm\"><integer name=\"width\" value=\"{width}\"/><integer name=\"height\" value=\"{height}\"/>\
         <string name=\"component_format\" value=\"float32\"/><string name=\"pixel_format\" value=\"rgb\"/>\
         <boolean name=\"sample_border\" value=\"true\"/><rfilter type=\"tent\"/></film>\n\
         <sampler type=\"independent\"><integer name=\"sample_count\" value=\"$spp\"/></sampler></sensor>\n",
        float("fov", 2.0 * camera.tangent[1].atan().to_degrees()),
        float("near_clip", 1e-2),
        float("far_clip", 10.0 * SUN_DISTANCE),
        point(camera.forward),
        point(camera.up)
    )
}

fn lights(light: &Light, exposure: f32) -> String {
    let sky = match &light.sky {
        Sky::None => String::new(),
        Sky::Constant { radiance } => {
            let radiance = radiance.map(|channel| channel * exposure);
            format!("<emitter type=\"constant\">{}</emitter>\n", rgb("radiance", radiance))
        }
        Sky::Preetham(_) | Sky::HosekWilkie(_) | Sky::Map(_) => format!(
            "<emitter type=\"envmap\"><string name=\"filename\" value=\"sky.exr\"/>{}</emitter>\n",
            float("scale", exposure)
        ),
    };
    let sun = light.sun.filter(|sun| sun.irradiance != [0.0; 3]);
    sky + &sun.map(|sun| disc(&sun, exposure)).unwrap_or_default()
}

/// The sun as a disc far away, of the same radiance all over: it takes up the same angle and has the same irradiance, π sin² r times
/// as much.
fn disc(sun: &Sun, exposure: f32) -> String {
    let (sine, cosine) = sun.radius().sin_cos();
    let radiance = sun.irradiance.map(|channel| channel * exposure / (std::f32::consts::PI * sine * sine));
    let Vec3 { x, y, z } = sun.direction * SUN_DISTANCE;
    let up = sun.direction.any_orthonormal_vector();
    format!(
        "<shape type=\"disk\"><transform name=\"to_world\"><scale value=\"{}\"/>\
         <lookat origin=\"{x},{y},{z}\" target=\"0,0,0\" up=\"{},{},{}\"/></transform>\
         <bsdf type=\"diffuse\">{}</bsdf><emitter type=\"area\">{}</emitter></shape>\n",
        SUN_DISTANCE * sine / cosine,
        up.x,
        up.y,
        up.z,
        rgb("reflectance", [0.0; 3]),
        rgb("radiance", radiance)
    )
}

/// A material as two of Mitsuba's.
struct Lobes {
    /// How much light it sends on at most.
    sum: f32,
    /// How much of it goes through.
    through: f32,
    reflectance: [f32; 3],
    transmittance: [f32; 3],
}

/// For what light gets through: colours that, weighted with `through`, are the material's.
fn lobes(material: &Material) -> Option<Lobes> {
    let largest = |color: [f32; 3]| color.into_iter().fold(0.0, f32::max);
    let reflectance = material.mean_reflectance();
    let [reflected, transmitted] = [reflectance, material.transmittance].map(largest);
    let sum = reflected + transmitted;
    if transmitted <= 0.0 {
        return (reflected > 1.0).then_some(Lobes {
            sum,
            through: 0.0,
            reflectance,
            transmittance: [0.0; 3],
        });
    }
    let through = transmitted / sum;
    let share = |color: [f32; 3], weight: f32| color.map(|channel| channel / weight.max(1e-6));
    Some(Lobes {
        sum,
        through,
        reflectance: share(reflectance, 1.0 - through),
        transmittance: share(material.transmittance, through),
    })
}

/// Light goes through a leaf as through Disney's thin surface with all of its light scattered to the other side, which is Lambert's law
/// (Burley 2015, "Extending the Disney BRDF to a BSDF with Integrated Subsurface Scattering", section 5.3).
fn bsdf(name: &str, material: &Material) -> String {
    let least = |color: [f32; 3]| color.map(|channel| channel.clamp(0.0, 1.0));
    let diffuse = |color: [f32; 3]| {
        format!(
            "<bsdf type=\"twosided\"><bsdf type=\"diffuse\">{}</bsdf></bsdf>",
            rgb("reflectance", least(color))
        )
    };
    let body = match lobes(material) {
        Some(lobes) if lobes.through > 0.0 => format!(
            "<bsdf type=\"blendbsdf\" id=\"{name}\">{}{}<bsdf type=\"principledthin\">{}{}{}{}</bsdf></bsdf>",
            float("weight", lobes.through),
            diffuse(lobes.reflectance),
            rgb("base_color", least(lobes.transmittance)),
            float("diff_trans", 2.0),
            float("spec_trans", 0.0),
            float("roughness", 1.0)
        ),
        _ => diffuse(material.mean_reflectance()).replacen('>', &format!(" id=\"{name}\">"), 1),
    };
    format!("<!-- {} -->\n{body}", material.name.replace("--", "—").replace(|c: char| c.is_control(), " "))
}

fn material_name(model: usize, material: usize) -> String {
    format!("material_{model}_{material}")
}

fn glows(model: &Model, part: &Part) -> bool {
    model.materials[part.material].emission.iter().any(|channel| *channel > 0.0)
}

/// The beginning of a shape with the mesh of this file.
fn shape(file: &str, material: &str) -> String {
    format!("<shape type=\"ply\"><string name=\"filename\" value=\"{file}\"/><ref id=\"{material}\"/>")
}

fn placed(instance: &Instance) -> Mat4 {
    Mat4::from_scale_rotation_translation(Vec3::splat(instance.scale), instance.rotation, instance.position)
}

fn transform(matrix: Mat4) -> String {
    let mut values = String::new();
    for value in matrix.transpose().to_cols_array() {
        // Writing to a string cannot fail.
        let _ = write!(values, "{}{value}", if values.is_empty() { "" } else { " " });
    }
    format!("<transform name=\"to_world\"><matrix value=\"{values}\"/></transform>")
}

fn float(name: &str, value: f32) -> String {
    format!("<float name=\"{name}\" value=\"{value}\"/>")
}

fn rgb(name: &str, [red, green, blue]: [f32; 3]) -> String {
    format!("<rgb name=\"{name}\" value=\"{red} {green} {blue}\"/>")
}
