//! What makers hand to renderers: plain values in metres, radians and cd/m².

mod develop;
pub mod difference;
pub mod dome;
mod frame;
mod hosek_wilkie;
mod material;
mod model;
mod path;
mod perez;
mod pick;
mod picture;
pub mod shelter;
mod sky_map;
mod stand;

use glam::Vec3;
use std::sync::Arc;

use crate::core::grid::Grid;
use crate::gpu::{Image, format::R32f};

pub use develop::{Developer, Development};
pub use frame::{frame, light_frame, panorama, panorama_memory, through};
pub use hosek_wilkie::HosekWilkie;
pub use material::Material;
pub use model::{Instance, Level, Model, Part, Population};
pub use path::{CameraPath, Keyframe};
pub use perez::Perez;
pub use pick::Met;
pub use picture::Picture;
pub use shelter::Shelter;
pub use sky_map::SkyMap;
pub use stand::{Place, Stand, Viewpoint};

/// All that a renderer needs to know of a world.
#[derive(Clone, Debug)]
pub struct Scene {
    pub ground: Ground,
    pub light: Light,
    pub sea: Sea,
    pub surface: Surface,
    pub population: Population,
    pub camera: Camera,
}

/// The land, one texel a sample of the grid.
#[derive(Clone, Debug)]
pub struct Ground {
    pub grid: Grid,
    /// Metres above the datum.
    pub height: Image<R32f>,
    /// Depth of rivers and lakes, metres; 0 in the sea.
    pub water: Image<R32f>,
    /// How lately water ran here, 0…1.
    pub wetness: Image<R32f>,
    /// Thickness of the coral that has grown, metres.
    pub reef: Image<R32f>,
    /// Height of the sea above the datum, metres, now that all is done.
    pub sea_level: f32,
}

/// Distant light: the sky's dome and the sun's disc, and the air that veils what is far.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    pub sky: Sky,
    /// `None` is a world without a sun.
    pub sun: Option<Sun>,
    /// `None` switches aerial perspective off.
    pub air: Option<Air>,
    /// How much of the horizon fair-weather cumulus covers, 0…1.
    pub clouds: f32,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Sky {
    /// No light from the sky: black.
    None,
    /// The same radiance from everywhere, linear Rec.709, cd/m².
    Constant { radiance: [f32; 3] },
    /// Preetham, Shirley & Smits 1999.
    Preetham(Perez),
    /// Hosek & Wilkie 2012.
    HosekWilkie(HosekWilkie),
    /// A picture of the whole sky.
    Map(Arc<SkyMap>),
}

impl Sky {
    /// Memory of the texels of a picture, bytes; 0 of other skies.
    pub fn bytes(&self) -> u64 {
        match self {
            Sky::Map(map) => size_of_val(map.texels.as_slice()) as u64,
            _ => 0,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Unit vector from the ground towards the sun, world axes.
    pub direction: Vec3,
    /// Illuminance on a plane that faces the sun, linear Rec.709, lux.
    pub irradiance: [f32; 3],
    /// Angular diameter of the disc, radians.
    pub diameter: f32,
}

impl Sun {
    /// Of the disc, radians. One without a radius would be infinitely bright.
    pub fn radius(&self) -> f32 {
        (self.diameter / 2.0).max(1e-4)
    }
}

/// What scatters light between the eye and the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Air {
    pub molecules: AirLayer,
    pub haze: AirLayer,
}

/// A layer that thins exponentially with height above the datum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AirLayer {
    /// At the datum, linear Rec.709, 1/m.
    pub extinction: [f32; 3],
    /// Metres over which the density falls to 1/e.
    pub scale_height: f32,
}

/// The sea: a level and the water's optics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sea {
    /// Height of the surface above the datum when the simulation starts, metres. A reef's sea-level stages
    /// move it.
    pub level: f32,
    /// Attenuation along the view path, linear Rec.709, 1/m (K_A of Korošec & Lebar Bajec (32), per channel).
    pub attenuation: [f32; 3],
    /// Colour of deep water: reflectance of an infinitely deep sea, linear Rec.709.
    pub deep_colour: [f32; 3],
    /// Height of the ripples that the sun glitters on: standard deviation of the surface's slope.
    pub roughness: f32,
}

/// How bare ground is coloured: four materials and the rules that blend them. Colours are linear Rec.709 albedos.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    pub grass: [f32; 3],
    /// Grass on high or steep ground: paler and yellower.
    pub dry_grass: [f32; 3],
    pub rock: [f32; 3],
    pub sand: [f32; 3],
    pub sea_floor: [f32; 3],
    /// Living coral just below the surface.
    pub reef: [f32; 3],
    /// Slope at which grass begins to give way to rock, and at which only rock is left, radians.
    pub rock_slope: [f32; 2],
    /// Height above the sea at which grass begins to dry and at which it is dry, metres.
    pub dry_height: [f32; 2],
    /// The beach: sand reaches this high above the sea, metres …
    pub beach_height: f32,
    /// … where the ground is flatter than this, radians.
    pub beach_slope: f32,
    /// Size of the largest patches in the procedural mottling, metres.
    pub patch_size: f32,
    /// How far grass is painted as a forest seen from afar, 0…1: 0 where plants stand themselves.
    pub crowns: f32,
    pub snow: Option<Snow>,
    /// In place of all that is above, but for snow.
    pub by_height: Option<ByHeight>,
}

/// Snow on high ground that is not too steep for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Snow {
    /// Linear Rec.709 albedo.
    pub colour: [f32; 3],
    /// Height above the sea at which the first patches lie, and above which all is covered, metres.
    pub height: [f32; 2],
    /// Slope at which snow begins to slide off, and at which none stays, radians.
    pub slope: [f32; 2],
}

/// Ground below and rock above, mixed in between in proportion to the height (Rudzki 2020, §3.3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ByHeight {
    pub ground: Mixture,
    pub rock: Mixture,
    /// Heights above the datum at which rock begins and at which only rock is left, metres.
    pub rock_start: f32,
    pub ground_end: f32,
}

/// Two colours that noise mixes, as in a [`Material`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mixture {
    pub reflectance: [f32; 3],
    pub second_reflectance: [f32; 3],
    pub position_factor: f32,
    pub value_factor: f32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum View {
    /// Eye and target in world coordinates, metres; turned clockwise by `roll`, radians.
    LookAt { position: Vec3, target: Vec3, roll: f32 },
    /// Stand so that the land above the sea fills the picture: seen from `azimuth` (clockwise from north, radians:
    /// the side the camera stands on), looking down by `elevation` (radians), `distance` times as far
    /// away as would just fit.
    FrameIsland { azimuth: f32, elevation: f32, distance: f32 },
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    pub view: View,
    /// Vertical field of view, radians.
    pub fov: f32,
}

/// From radiance to pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Film {
    pub width: u32,
    pub height: u32,
    /// Radiance (cd/m²) is multiplied by this; EXR holds the product.
    pub exposure: f32,
    pub tone_map: ToneMap,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToneMap {
    /// Clamp to 0…1.
    None,
    /// A filmic curve that keeps hues as they brighten.
    Filmic,
}
