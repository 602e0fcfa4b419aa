//! Where nodes stand: kept as turn, scale and shift as long as they are that, so that what stands upright stays exactly so.

use super::document::Node;
use glam::{Affine3A, Mat3A, Mat4, Quat, Vec3};

/// From a node's coordinates to those of what is around it.
#[derive(Clone, Copy)]
pub enum Transform {
    /// Shapes keep their angles.
    Similar { position: Vec3, rotation: Quat, scale: f32 },
    /// Shapes are stretched, sheared or mirrored.
    Affine(Affine3A),
}

impl Transform {
    pub const IDENTITY: Self =
        Transform::Similar { position: Vec3::ZERO, rotation: Quat::IDENTITY, scale: 1.0 };

    /// That of a node; `None` if its numbers make no sense.
    pub fn of_node(node: &Node) -> Option<Self> {
        let Some(matrix) = &node.matrix else {
            let position = node.translation.unwrap_or_default().into();
            let rotation = node.rotation.map_or(Quat::IDENTITY, Quat::from_array);
            return Self::new(position, rotation, node.scale.map_or(Vec3::ONE, Vec3::from));
        };
        let matrix = Mat4::from_cols_array(matrix);
        let affine = matrix.row(3) == glam::Vec4::W && matrix.is_finite();
        affine.then(|| Transform::Affine(Affine3A::from_mat4(matrix)).simplified())
    }

    /// A shift after a turn after a stretch; `None` if the numbers make no sense.
    pub fn new(position: Vec3, rotation: Quat, scale: Vec3) -> Option<Self> {
        let rotation = if rotation.is_normalized() { rotation } else { rotation.normalize() };
        if !position.is_finite() || !rotation.is_finite() || !scale.is_finite() {
            return None;
        }
        if scale.x > 0.0 && scale == Vec3::splat(scale.x) {
            return Some(Transform::Similar { position, rotation, scale: scale.x });
        }
        Some(Transform::Affine(Affine3A::from_scale_rotation_translation(scale, rotation, position)))
    }

    /// This after `inner`.
    pub fn of(self, inner: Self) -> Self {
        if let (
            Transform::Similar { position, rotation, scale },
            Transform::Similar { position: from, rotation: first, scale: by },
        ) = (self, inner)
        {
            return Transform::Similar {
                position: position + rotation * (scale * from),
                rotation: rotation * first,
                scale: scale * by,
            };
        }
        Transform::Affine(self.affine() * inner.affine()).simplified()
    }

    pub fn affine(self) -> Affine3A {
        match self {
            Transform::Affine(affine) => affine,
            Transform::Similar { position, rotation, scale } => {
                Affine3A::from_scale_rotation_translation(Vec3::splat(scale), rotation, position)
            }
        }
    }

    /// Without stretching if there is none to speak of.
    fn simplified(self) -> Self {
        let Transform::Affine(affine) = self else { return self };
        let scale = libm::cbrtf(affine.matrix3.determinant());
        let turn = affine.matrix3 * scale.recip();
        let error = turn * turn.transpose() - Mat3A::IDENTITY;
        let largest = error.to_cols_array().into_iter().map(f32::abs).fold(0.0, f32::max);
        if scale > 0.0 && scale.is_finite() && largest < 1e-5 {
            let rotation = Quat::from_mat3a(&turn).normalize();
            return Transform::Similar { position: affine.translation.into(), rotation, scale };
        }
        self
    }
}
