//! A pinhole camera: where it stands, what it sees, and how far back it must stand to see something.

use glam::Vec3;

/// A pinhole camera. `right`, `up` and `forward` are orthonormal, world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pinhole {
    /// Metres.
    pub eye: Vec3,
    pub right: Vec3,
    pub up: Vec3,
    pub forward: Vec3,
    /// Tangents of half the field of view, across and up.
    pub tangent: [f32; 2],
}

impl Pinhole {
    /// Looks from `eye` at `target` with the horizon level. `fov` is the vertical field of view, `aspect` is width
    /// over height. Looking straight up or down, north is at the top of the picture.
    pub fn look_at(eye: Vec3, target: Vec3, fov: f32, aspect: f32) -> Self {
        Self::look_along(eye, (target - eye).try_normalize().unwrap_or(Vec3::NEG_Z), fov, aspect)
    }

    /// Looks from `eye` along the unit vector `forward`.
    pub fn look_along(eye: Vec3, forward: Vec3, fov: f32, aspect: f32) -> Self {
        let right = forward.cross(Vec3::Y).try_normalize().unwrap_or(Vec3::X);
        let up = right.cross(forward);
        let tangent = (fov / 2.0).tan();
        Pinhole { eye, right, up, forward, tangent: [tangent * aspect, tangent] }
    }

    /// Looks along the unit vector `forward` from where the axis-aligned `boxes` (least and greatest corner) fill
    /// the picture, then from `distance` times as far away. Without boxes the eye stays at the origin.
    ///
    /// The pyramid of view touches the boxes' hull on both sides of the tighter axis and leaves equal
    /// margins on the other.
    pub fn frame(boxes: &[[Vec3; 2]], forward: Vec3, distance: f32, fov: f32, aspect: f32) -> Self {
        let camera = Self::look_along(Vec3::ZERO, forward, fov, aspect);
        let corners = || {
            boxes.iter().flat_map(|[least, greatest]| {
                (0..8).map(|corner| {
                    let pick =
                        |axis: usize| if corner >> axis & 1 == 0 { least[axis] } else { greatest[axis] };
                    Vec3::new(pick(0), pick(1), pick(2))
                })
            })
        };
        if boxes.is_empty() {
            return camera;
        }
        // A point p lies between the left and right planes of an eye e when |x(p − e)| ≤ tangent · z(p − e). The
        // support of all points in the planes' normals bounds how deep the eye may stand.
        let support = |axis: Vec3, tangent: f32| {
            corners().map(|point| (axis - forward * tangent).dot(point)).fold(f32::NEG_INFINITY, f32::max)
        };
        let fit = |axis: Vec3, tangent: f32| {
            let (plus, minus) = (support(axis, tangent), support(-axis, tangent));
            ((plus - minus) / 2.0, -(plus + minus) / (2.0 * tangent))
        };
        let (x, depth_x) = fit(camera.right, camera.tangent[0]);
        let (y, depth_y) = fit(camera.up, camera.tangent[1]);
        let near = corners().map(|point| forward.dot(point)).fold(f32::INFINITY, f32::min);
        let far = corners().map(|point| forward.dot(point)).fold(f32::NEG_INFINITY, f32::max);
        let middle = (near + far) / 2.0;
        let depth = middle - (middle - depth_x.min(depth_y)) * distance;
        Pinhole { eye: camera.right * x + camera.up * y + forward * depth, ..camera }
    }

    /// Unit vector through the point `(x, y)` of the picture, in 0…1 from its upper left corner.
    pub fn ray(&self, x: f32, y: f32) -> Vec3 {
        let across = self.right * ((2.0 * x - 1.0) * self.tangent[0]);
        let upward = self.up * ((1.0 - 2.0 * y) * self.tangent[1]);
        (self.forward + across + upward).normalize()
    }

    /// Where a world point falls in the picture (0…1 from the upper left corner); `None` behind the eye.
    pub fn project(&self, point: Vec3) -> Option<[f32; 2]> {
        let from_eye = point - self.eye;
        let depth = self.forward.dot(from_eye);
        if depth <= 0.0 {
            return None;
        }
        let x = self.right.dot(from_eye) / (depth * self.tangent[0]);
        let y = self.up.dot(from_eye) / (depth * self.tangent[1]);
        Some([(x + 1.0) / 2.0, (1.0 - y) / 2.0])
    }
}
