//! What surfaces do to light: one description for every renderer.

use crate::shaders;

/// A surface that scatters light diffusely from both sides, and lets some through if it is thin.
///
/// Its colour at the world position `p` is `mix(reflectance[0], reflectance[1], clamp(noise(p · position_factor) ·
/// value_factor, 0, 1))`, the noise that of Perlin 2002 mapped to 0…1 (Rudzki 2020, eq. 2.1).
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    pub name: String,
    /// Diffuse reflectance, linear Rec.709: the two colours that noise mixes.
    pub reflectance: [[f32; 3]; 2],
    /// How fine the mixture is, 1/m.
    pub position_factor: f32,
    pub value_factor: f32,
    /// Diffuse transmittance, linear Rec.709; 0 for what light does not get through. It varies with the reflectance.
    pub transmittance: [f32; 3],
    /// Of the thin layer of gloss.
    pub refractive_index: f32,
    /// Of the gloss: 0 is a mirror, 1 has no highlight to speak of.
    pub roughness: f32,
    /// Depth of furrows, as in bark, metres; they are some eight times as far apart, and run upwards.
    pub relief: f32,
    /// Radiance of its own, linear Rec.709, cd/m².
    pub emission: [f32; 3],
}

impl Default for Material {
    fn default() -> Self {
        Material {
            name: String::new(),
            reflectance: [[0.2; 3]; 2],
            position_factor: 1.0,
            value_factor: 1.0,
            transmittance: [0.0; 3],
            refractive_index: 1.0,
            roughness: 1.0,
            relief: 0.0,
            emission: [0.0; 3],
        }
    }
}

impl Material {
    /// The reflectance where the noise has its mean, ½: what a renderer without noise shows.
    pub fn mean_reflectance(&self) -> [f32; 3] {
        let share = (0.5 * self.value_factor).clamp(0.0, 1.0);
        let [from, to] = self.reflectance;
        std::array::from_fn(|channel| from[channel] + (to[channel] - from[channel]) * share)
    }
}

impl From<&Material> for shaders::Material {
    fn from(material: &Material) -> Self {
        shaders::Material {
            reflectance: shaders::Tint {
                from: material.reflectance[0],
                to: material.reflectance[1],
                position_factor: material.position_factor,
                value_factor: material.value_factor,
            },
            transmittance: material.transmittance,
            refractive_index: material.refractive_index,
            roughness: material.roughness,
            relief: material.relief,
            emission: material.emission,
        }
    }
}
