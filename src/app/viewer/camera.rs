//! The eye over land: it flies, or turns round a point.

use crate::core::camera::{Pinhole, direction};
use crate::scene::View;
use glam::{Mat3, Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, TAU};

/// What is held down: each from −1 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Steering {
    /// Right, up and forward, seen from the eye; up is the world's.
    pub go: Vec3,
    /// Right, up, and clockwise.
    pub turn: Vec3,
    /// Times as fast as usual.
    pub speed: f32,
}

impl Steering {
    pub fn is_still(&self) -> bool {
        self.go == Vec3::ZERO && self.turn == Vec3::ZERO
    }
}

/// Where the eye is, and where it looks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rig {
    /// Metres.
    pub eye: Vec3,
    /// Where it looks: clockwise from north, and up, radians.
    pub azimuth: f32,
    pub elevation: f32,
    /// Clockwise, radians.
    pub roll: f32,
}

/// A [`Rig`] in the words of the world file's `camera.view.look_at`, to two places.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Written {
    /// Metres.
    pub position: [f64; 3],
    /// 100 m ahead, or more.
    pub target: [f64; 3],
    /// Degrees.
    pub roll: f64,
}

impl Written {
    pub fn eye(&self) -> Vec3 {
        self.position.map(|part| part as f32).into()
    }

    /// What a world has that says so.
    pub fn view(&self) -> View {
        View::LookAt { position: self.eye(), target: self.target(), roll: self.roll() }
    }

    /// The same with a vertical field of view (radians), in a picture of this width over height.
    pub fn pinhole(&self, fov: f32, aspect: f32) -> Pinhole {
        Pinhole::look_at(self.eye(), self.target(), fov, aspect).rolled(self.roll())
    }

    fn target(&self) -> Vec3 {
        self.target.map(|part| part as f32).into()
    }

    fn roll(&self) -> f32 {
        self.roll.to_radians() as f32
    }
}

/// Turns a second while a key is held, radians.
const TURN: f32 = 1.0;

/// As high as this above the ground speed and distance don't become less, metres.
const LOWEST: f32 = 2.0;

impl Rig {
    /// Looks as a camera does.
    pub fn of(camera: &Pinhole) -> Rig {
        let forward = camera.forward;
        let level = Pinhole::look_along(camera.eye, forward, 1.0, 1.0);
        let roll = (-camera.right.dot(level.up)).atan2(camera.right.dot(level.right));
        Rig {
            eye: camera.eye,
            azimuth: forward.x.atan2(-forward.z),
            elevation: forward.y.clamp(-1.0, 1.0).asin(),
            // A level camera is that to the last bit.
            roll: if roll.abs() < 1e-6 { 0.0 } else { roll },
        }
    }

    /// From a point towards another, turned clockwise (radians).
    pub fn looking(eye: Vec3, target: Vec3, roll: f32) -> Rig {
        Rig::of(&Pinhole::look_at(eye, target, 1.0, 1.0).rolled(roll))
    }

    pub fn forward(&self) -> Vec3 {
        direction(self.azimuth, self.elevation)
    }

    /// With a vertical field of view (radians), in a picture of this width over height.
    pub fn pinhole(&self, fov: f32, aspect: f32) -> Pinhole {
        Pinhole::look_along(self.eye, self.forward(), fov, aspect).rolled(self.roll)
    }

    /// What files and command lines have of it.
    pub fn written(&self) -> Written {
        let rounded = |number: f64| (number * 100.0).round() / 100.0;
        // A look that is steep is aimed farther, or rounding would turn it round.
        let range = 100.0 / self.elevation.cos().max(0.01);
        let [position, target] = [self.eye, self.eye + self.forward() * range]
            .map(|at| at.to_array().map(|part| rounded(part.into())));
        Written { position, target, roll: rounded(f64::from(self.roll).to_degrees()) }
    }

    /// Moves for some seconds. `ground` tells the height of what can't be flown through, metres.
    pub fn steer(&mut self, steering: &Steering, seconds: f32, ground: impl Fn(Vec2) -> f32) {
        let Steering { go, turn, speed } = *steering;
        self.turn(Vec2::new(turn.x, turn.y) * TURN * seconds);
        self.roll = (self.roll + turn.z * TURN * seconds) % TAU;
        let height = (self.eye.y - ground(self.at())).clamp(5.0, 1e5);
        let right = Vec3::new(self.azimuth.cos(), 0.0, self.azimuth.sin());
        let way = right * go.x + Vec3::Y * go.y + self.forward() * go.z;
        self.eye += way * speed * height * seconds;
        self.keep_above(ground);
    }

    /// Looks to the right and up, radians.
    pub fn turn(&mut self, by: Vec2) {
        self.azimuth = (self.azimuth + by.x) % TAU;
        self.elevation = (self.elevation + by.y).clamp(-FRAC_PI_2 * 0.999, FRAC_PI_2 * 0.999);
    }

    /// Moves round a point that keeps its place in the picture: to the right and up, radians.
    pub fn orbit(&mut self, point: Vec3, by: Vec2, ground: impl Fn(Vec2) -> f32) {
        let before = *self;
        self.turn(Vec2::new(-by.x, -by.y));
        // The eye turns as its looks do.
        let turned = self.basis() * (before.basis().transpose() * (before.eye - point));
        self.eye = point + turned;
        self.keep_above(ground);
    }

    /// Goes nearer to a point: by this share of the way, or away from it.
    pub fn approach(&mut self, point: Vec3, share: f32, ground: impl Fn(Vec2) -> f32) {
        self.eye += (point - self.eye) * share;
        self.keep_above(ground);
    }

    fn basis(&self) -> Mat3 {
        let forward = self.forward();
        let right = Vec3::new(self.azimuth.cos(), 0.0, self.azimuth.sin());
        Mat3::from_cols(right, right.cross(forward), -forward)
    }

    fn at(&self) -> Vec2 {
        Vec2::new(self.eye.x, self.eye.z)
    }

    fn keep_above(&mut self, ground: impl Fn(Vec2) -> f32) {
        self.eye.y = self.eye.y.max(ground(self.at()) + LOWEST);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RIG: Rig = Rig { eye: Vec3::new(10.0, 300.0, 500.0), azimuth: 0.4, elevation: -0.3, roll: 0.0 };

    fn flat(_: Vec2) -> f32 {
        0.0
    }

    #[test]
    fn a_camera_becomes_a_rig_and_back() {
        assert_eq!(Rig::of(&RIG.pinhole(1.0, 1.5)).roll, 0.0);
        for roll in [0.0, 0.3, -2.0] {
            let camera = Rig { roll, ..RIG }.pinhole(1.0, 1.5);
            let again = Rig::of(&camera).pinhole(1.0, 1.5);
            assert!(
                (camera.forward - again.forward).length() < 1e-6 && (camera.up - again.up).length() < 1e-6
            );
        }
        // Clockwise, as one sees who holds it: what was to the right is below.
        let quarter = Rig { roll: FRAC_PI_2, ..RIG }.pinhole(1.0, 1.5);
        assert!((quarter.right + RIG.pinhole(1.0, 1.5).up).length() < 1e-6);
    }

    #[test]
    fn what_is_written_is_seen_again() {
        let rig = Rig { eye: Vec3::new(12.344_9, 300.027, -1234.506), roll: -0.7, ..RIG };
        let written = rig.written();
        assert_eq!((written.position, written.roll), ([12.34, 300.03, -1234.51], -40.11));
        let camera = written.pinhole(1.0, 1.5);
        let again = Rig::looking(camera.eye, camera.eye + camera.forward, (-40.11_f32).to_radians());
        assert!((again.forward() - rig.forward()).length() < 2e-4 && (again.roll - rig.roll).abs() < 2e-4);
        assert!(rig.eye.distance(camera.eye) < 0.01);
        assert!((camera.up - rig.pinhole(1.0, 1.5).up).length() < 2e-4);
        // As steeply as can be.
        for elevation in [-FRAC_PI_2, -1.3, FRAC_PI_2] {
            let mut rig = Rig { elevation: 0.0, ..rig };
            rig.turn(Vec2::new(0.0, elevation));
            let (camera, exact) = (rig.written().pinhole(1.0, 1.5), rig.pinhole(1.0, 1.5));
            assert!((camera.right - exact.right).length() < 1e-3, "{elevation}: {camera:?}, {exact:?}");
        }
    }

    #[test]
    fn turning_round_a_point_keeps_it_in_its_place() {
        let seen = |rig: &Rig, point: Vec3| {
            let camera = rig.pinhole(1.0, 1.5);
            let way = point - camera.eye;
            Vec3::new(camera.right.dot(way), camera.up.dot(way), camera.forward.dot(way))
        };
        let point = Vec3::new(60.0, 20.0, -100.0);
        let mut rig = RIG;
        rig.orbit(point, Vec2::new(0.7, 0.2), flat);
        assert!((seen(&rig, point) - seen(&RIG, point)).length() < 1e-2);
        assert!((rig.eye - RIG.eye).length() > 100.0);
    }

    #[test]
    fn nothing_goes_through_the_ground() {
        let mut rig = Rig { elevation: -1.5, ..RIG };
        let down = Steering { go: Vec3::new(0.0, -1.0, 1.0), speed: 8.0, ..Steering::default() };
        for _ in 0..1000 {
            rig.steer(&down, 0.1, flat);
            assert!(rig.eye.y >= LOWEST);
        }
        rig.approach(Vec3::new(0.0, -1e4, 0.0), 0.9, flat);
        assert!(rig.eye.y >= LOWEST);
    }
}
