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

/// Enough to exhaust a float.
const BISECTIONS: usize = 30;

/// The unit vector to where the azimuth, clockwise from north, and the elevation say, radians. Every machine has the same
/// bits of it: plants stand as the camera stands.
pub fn direction(azimuth: f32, elevation: f32) -> Vec3 {
    let (east, south) = (libm::sinf(azimuth), -libm::cosf(azimuth));
    let level = libm::cosf(elevation);
    Vec3::new(east * level, libm::sinf(elevation), south * level)
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
        let tangent = libm::tanf(fov / 2.0);
        Pinhole { eye, right, up, forward, tangent: [tangent * aspect, tangent] }
    }

    /// Turned clockwise about where it looks, by so many radians: the horizon then leans to the left.
    pub fn rolled(self, roll: f32) -> Self {
        if roll == 0.0 {
            return self;
        }
        let (sin, cos) = (libm::sinf(roll), libm::cosf(roll));
        let (right, up) = (self.right * cos - self.up * sin, self.up * cos + self.right * sin);
        Pinhole { right, up, ..self }
    }

    /// Looks along the unit vector `forward` from where the axis-aligned `boxes` (least and greatest corner) just fit
    /// into the picture, then from `distance` times as far away; they stay in its middle. Without boxes the eye
    /// stays at the origin.
    pub fn frame(boxes: &[[Vec3; 2]], forward: Vec3, distance: f32, fov: f32, aspect: f32) -> Self {
        let camera = Self::look_along(Vec3::ZERO, forward, fov, aspect);
        if boxes.is_empty() {
            return camera;
        }
        // Across, up and forward.
        let seen: Vec<Vec3> = boxes
            .iter()
            .flat_map(corners)
            .map(|corner| Vec3::new(camera.right.dot(corner), camera.up.dot(corner), forward.dot(corner)))
            .collect();
        let extreme = |of: &dyn Fn(&Vec3) -> f32| seen.iter().map(of).fold(f32::NEG_INFINITY, f32::max);
        // A point p lies between the left and right planes of an eye e when |x(p − e)| ≤ tangent · z(p − e). Added
        // up, the two planes' supports bound how deep the eye may stand.
        let deepest = |axis: usize| {
            let tangent = camera.tangent[axis];
            let right = extreme(&|point| point[axis] - tangent * point.z);
            let left = extreme(&|point| -point[axis] - tangent * point.z);
            -(right + left) / (2.0 * tangent)
        };
        let middle = (extreme(&|point| point.z) - extreme(&|point| -point.z)) / 2.0;
        let depth = middle - (middle - deepest(0).min(deepest(1))) * distance;
        // From the middle the extremes on both sides look equally far off.
        let centre = |axis: usize| {
            let (mut low, mut high) = (-extreme(&|point| -point[axis]), extreme(&|point| point[axis]));
            for _ in 0..BISECTIONS {
                let eye = (low + high) / 2.0;
                let slope = |point: &Vec3| (point[axis] - eye) / (point.z - depth);
                if extreme(&slope) > extreme(&|point| -slope(point)) {
                    low = eye;
                } else {
                    high = eye;
                }
            }
            (low + high) / 2.0
        };
        Pinhole { eye: camera.right * centre(0) + camera.up * centre(1) + forward * depth, ..camera }
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

fn corners([least, greatest]: &[Vec3; 2]) -> [Vec3; 8] {
    std::array::from_fn(|corner| {
        let pick = |axis: usize| if corner >> axis & 1 == 0 { least[axis] } else { greatest[axis] };
        Vec3::new(pick(0), pick(1), pick(2))
    })
}
