//! Unit vectors in 32 bits, by an octahedron unfolded onto a square (Cigolle et al. 2014, "A Survey of Efficient
//! Representations for Independent Unit Vectors").

use glam::{Vec2, Vec3};

/// The twin of `pack_direction` in `glsl/lib/octahedron.glsl`.
pub fn packed_direction(direction: Vec3) -> u32 {
    let side = |value: f32| if value >= 0.0 { 1.0 } else { -1.0 };
    let Vec3 { x, y, z } = direction / direction.abs().element_sum().max(f32::MIN_POSITIVE);
    let at = if y >= 0.0 {
        Vec2::new(x, z)
    } else {
        Vec2::new((1.0 - z.abs()) * side(x), (1.0 - x.abs()) * side(z))
    };
    let [low, high] = at.to_array().map(|value| (value.clamp(-1.0, 1.0) * 32767.0).round() as i16 as u16);
    u32::from(high) << 16 | u32::from(low)
}
