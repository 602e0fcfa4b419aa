//! The uniform block that every pass of a picture reads.

use super::dome::sky_irradiance;
use super::{Air, ByHeight, Film, Light, Mixture, Perez, Scene, Sky, Snow, Sun, Surface};
use crate::core::camera::Pinhole;
use crate::core::memory::Memory;
use crate::gpu::{self, Buffer, Gpu, Recorder};
use crate::shaders::{self, Frame};

/// Nearest distance that is drawn, metres.
const NEAR: f32 = 0.5;

/// What a picture of `scene` through `camera` begins with, `side` × `side` samples a pixel. `patches` and `top`, of which not every
/// renderer makes use, are left 0.
pub fn frame(scene: &Scene, film: &Film, side: u32, camera: &Pinhole) -> Frame {
    let Scene { ground, light, sea, surface, .. } = scene;
    let frame = Frame {
        near: NEAR,
        extent: ground.grid.extent,
        cell_size: ground.grid.cell_size(),
        cells: ground.grid.cells as i32,
        sea_level: ground.sea_level,
        attenuation: sea.attenuation,
        deep_colour: sea.deep_colour,
        roughness: sea.roughness,
        grass: surface.grass,
        dry_grass: surface.dry_grass,
        rock: surface.rock,
        sand: surface.sand,
        sea_floor: surface.sea_floor,
        reef: surface.reef,
        rock_slope: surface.rock_slope,
        dry_height: surface.dry_height,
        beach_height: surface.beach_height,
        beach_slope: surface.beach_slope,
        patch_size: surface.patch_size,
        crowns: surface.crowns,
        ..light_frame(light, film, side, camera)
    };
    with_surface(frame, surface)
}

/// What a picture begins with that shows sky and light, but no ground of a [`Scene`].
pub fn light_frame(light: &Light, film: &Film, side: u32, camera: &Pinhole) -> Frame {
    with_light(through(Frame::default(), [film.width * side, film.height * side], camera), light)
}

/// The same frame through another camera, in a picture of `size` samples.
pub fn through(frame: Frame, size: [u32; 2], camera: &Pinhole) -> Frame {
    let samples = size.map(|side| side as f32);
    Frame {
        eye: camera.eye.to_array(),
        right: camera.right.to_array(),
        up: camera.up.to_array(),
        forward: camera.forward.to_array(),
        tangent: camera.tangent,
        samples,
        sample_angle: 2.0 * camera.tangent[1] / samples[1],
        ..frame
    }
}

fn with_light(frame: Frame, light: &Light) -> Frame {
    let Light { sky, sun, air, clouds } = light;
    let frame = Frame { sky_irradiance: sky_irradiance(sky), clouds: *clouds, ..frame };
    with_air(with_sky(with_sun(frame, *sun), sky), *air)
}

fn with_surface(mut frame: Frame, surface: &Surface) -> Frame {
    // Above all ground.
    let none = Snow { colour: [0.0; 3], height: [1e9, 2e9], slope: [1.0, 2.0] };
    let snow = surface.snow.unwrap_or(none);
    (frame.snow, frame.snow_height, frame.snow_slope) = (snow.colour, snow.height, snow.slope);
    if let Some(ByHeight { ground, rock, rock_start, ground_end }) = surface.by_height {
        let by_height = [rock_start, ground_end];
        frame = Frame { by_height, low: tint(ground), high: tint(rock), ..frame };
    }
    frame
}

fn tint(mixture: Mixture) -> shaders::Tint {
    let Mixture { reflectance, second_reflectance, position_factor, value_factor } = mixture;
    shaders::Tint { from: reflectance, to: second_reflectance, position_factor, value_factor }
}

fn with_sun(frame: Frame, sun: Option<Sun>) -> Frame {
    let Some(sun) = sun else {
        return Frame { sun_direction: [0.0, 1.0, 0.0], sun_radius: 1e-4, ..frame };
    };
    Frame {
        sun_direction: sun.direction.to_array(),
        sun_irradiance: sun.irradiance,
        sun_radius: sun.radius(),
        ..frame
    }
}

fn with_sky(frame: Frame, sky: &Sky) -> Frame {
    match sky {
        Sky::None => Frame { sky: SKY_NONE, ..frame },
        Sky::Constant { radiance } => Frame { sky: SKY_CONSTANT, sky_constant: *radiance, ..frame },
        Sky::Preetham(perez) => with_perez(Frame { sky: SKY_PREETHAM, ..frame }, perez),
        Sky::HosekWilkie(model) => Frame {
            sky: SKY_HOSEK_WILKIE,
            perez_sun: model.sun.as_vec3().to_array(),
            hosek_wilkie: std::array::from_fn(|index| {
                model.distribution.map(|channel| channel[index] as f32)
            }),
            hosek_wilkie_radiance: model.radiance.map(|channel| channel as f32),
            ..frame
        },
        Sky::Map(map) => Frame {
            sky: SKY_MAP,
            sky_map_size: [map.width as i32, map.height as i32],
            sky_map_turn: (map.rotation / std::f64::consts::TAU) as f32,
            ..frame
        },
    }
}

/// The texels that [`frame`] speaks of: one, black, of a sky that is none of a picture.
pub fn panorama(gpu: &Gpu, sky: &Sky) -> gpu::Result<Buffer<[f32; 3]>> {
    let texels = match sky {
        Sky::Map(map) => map.texels.as_slice(),
        _ => &[[0.0; 3]],
    };
    let buffer = Buffer::new(gpu, "sky", texels.len())?;
    let mut rec = Recorder::new(gpu);
    rec.upload(&buffer, texels);
    rec.submit()?.wait()?;
    Ok(buffer)
}

/// What [`panorama`] needs on the device: the texels, and their copy on its way.
pub fn panorama_memory(sky: &Sky) -> Memory {
    Memory { name: "sky", bytes: 2 * sky.bytes() }
}

// The values that glsl/lib/frame.glsl gives them.
const SKY_NONE: u32 = 0;
const SKY_CONSTANT: u32 = 1;
const SKY_PREETHAM: u32 = 2;
const SKY_HOSEK_WILKIE: u32 = 3;
const SKY_MAP: u32 = 4;

fn with_perez(frame: Frame, perez: &Perez) -> Frame {
    let normalisation = perez.normalisation();
    let row = |index: usize| perez.coefficients.map(|channel| channel[index] as f32);
    Frame {
        perez_zenith: std::array::from_fn(|channel| (perez.zenith[channel] / normalisation[channel]) as f32),
        perez_a: row(0),
        perez_b: row(1),
        perez_c: row(2),
        perez_d: row(3),
        perez_e: row(4),
        perez_sun: perez.sun.as_vec3().to_array(),
        ..frame
    }
}

fn with_air(frame: Frame, air: Option<Air>) -> Frame {
    let Some(air) = air else {
        // No density, whatever the height.
        return Frame { molecule_height: 1e9, haze_height: 1e9, ..frame };
    };
    Frame {
        molecule_extinction: air.molecules.extinction,
        molecule_height: air.molecules.scale_height,
        haze_extinction: air.haze.extinction,
        haze_height: air.haze.scale_height,
        ..frame
    }
}
