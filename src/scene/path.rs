//! Where a camera is in every frame of a film: keyframes, and smooth ways between them.

use super::{Camera, View};
use glam::Vec3;

/// The way of a camera.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CameraPath {
    /// In the order of their frames, which all differ.
    pub keys: Vec<Keyframe>,
}

/// A frame in which it is known where the camera is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Keyframe {
    pub frame: u32,
    /// Where the camera stands, metres.
    pub position: Vec3,
    /// What it looks at.
    pub target: Vec3,
    /// How far it is turned clockwise, radians; full turns count.
    pub roll: f32,
    /// Vertical field of view, radians.
    pub fov: f32,
    /// Distance of what is sharp, metres.
    pub focus: f32,
}

/// What the numbers of a keyframe are, in one row.
const NUMBERS: usize = 9;

impl CameraPath {
    /// The camera in a frame, and the distance of what is sharp: `None` without keyframes. Before the first of them it is where it is
    /// there, behind the last one too.
    pub fn at(&self, frame: u32) -> Option<(Camera, f32)> {
        let (first, last) = (self.keys.first()?, self.keys.last()?);
        let numbers = if frame <= first.frame {
            first.numbers()
        } else if frame >= last.frame {
            last.numbers()
        } else {
            self.between(frame)
        };
        let [x, y, z, to_x, to_y, to_z, roll, fov, focus] = numbers.map(|number| number as f32);
        let (position, target) = (Vec3::new(x, y, z), Vec3::new(to_x, to_y, to_z));
        let view = View::LookAt { position, target, roll };
        Some((Camera { view, fov }, focus))
    }

    /// Each number by itself: a cubic Hermite spline over the frames.
    fn between(&self, frame: u32) -> [f64; NUMBERS] {
        let next = self.keys.partition_point(|key| key.frame <= frame);
        let (from, to) = (&self.keys[next - 1], &self.keys[next]);
        let length = f64::from(to.frame - from.frame);
        let t = f64::from(frame - from.frame) / length;
        let (values, ends) = ([from.numbers(), to.numbers()], [self.slopes(next - 1), self.slopes(next)]);
        let (t2, t3) = (t * t, t * t * t);
        std::array::from_fn(|index| {
            let [[start, end], [out, into]] = [values, ends].map(|pair| pair.map(|numbers| numbers[index]));
            start * (2.0 * t3 - 3.0 * t2 + 1.0)
                + end * (3.0 * t2 - 2.0 * t3)
                + length * (out * (t3 - 2.0 * t2 + t) + into * (t3 - t2))
        })
    }

    /// How fast each number changes at a keyframe, a frame: the weighted harmonic mean of the slopes before and after it, or 0 where
    /// these have not the same sign (Fritsch & Butland 1984). So nothing overshoots: between two keyframes the camera is never lower
    /// than at both, and between two that are alike it stands still. At both ends the way begins and stops gently.
    fn slopes(&self, index: usize) -> [f64; NUMBERS] {
        let around = index.checked_sub(1).and_then(|before| self.keys.get(before..=index + 1));
        let Some([before, here, after]) = around else { return [0.0; NUMBERS] };
        let [h0, h1] = [here.frame - before.frame, after.frame - here.frame].map(f64::from);
        let [p, q, r] = [before, here, after].map(Keyframe::numbers);
        std::array::from_fn(|index| {
            let [d0, d1] = [(q[index] - p[index]) / h0, (r[index] - q[index]) / h1];
            if d0 * d1 <= 0.0 {
                return 0.0;
            }
            let [w0, w1] = [h0 + 2.0 * h1, 2.0 * h0 + h1];
            (w0 + w1) / (w0 / d1 + w1 / d0)
        })
    }
}

impl Keyframe {
    fn numbers(&self) -> [f64; NUMBERS] {
        let ([x, y, z], [to_x, to_y, to_z]) = (self.position.to_array(), self.target.to_array());
        [x, y, z, to_x, to_y, to_z, self.roll, self.fov, self.focus].map(f64::from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(frame: u32, x: f32) -> Keyframe {
        let position = Vec3::new(x, 2.0 * x, 0.0);
        Keyframe { frame, position, target: Vec3::ZERO, roll: x / 8.0, fov: 1.0, focus: 3.0 }
    }

    fn x(path: &CameraPath, frame: u32) -> f32 {
        match path.at(frame).unwrap().0.view {
            View::LookAt { position, .. } => position.x,
            View::FrameIsland { .. } => f32::NAN,
        }
    }

    #[test]
    fn it_passes_its_keyframes_and_holds_at_the_ends() {
        let path =
            CameraPath { keys: vec![key(10, 1.0), key(20, 5.0), key(60, 6.0), key(70, 6.0), key(80, 0.0)] };
        for key in &path.keys {
            let View::LookAt { position, target, roll } = path.at(key.frame).unwrap().0.view else {
                panic!("a camera that looks at something")
            };
            assert_eq!((position, target, roll), (key.position, key.target, key.roll));
            let (camera, focus) = path.at(key.frame).unwrap();
            assert_eq!((camera.fov, focus), (key.fov, key.focus));
        }
        assert_eq!((x(&path, 0), x(&path, 1000)), (1.0, 0.0));
        assert_eq!(x(&path, 65), 6.0);
        // Nothing overshoots, and no step is a leap.
        for frame in 10..80 {
            let (now, next) = (x(&path, frame), x(&path, frame + 1));
            assert!((-0.001..=6.001).contains(&now), "{frame}: {now}");
            assert!(if frame < 60 { next >= now } else { next <= now }, "{frame}: {now}, {next}");
            assert!((next - now).abs() < 1.0, "{frame}: {now}, {next}");
        }
        assert!(CameraPath::default().at(3).is_none());
    }

    #[test]
    fn what_moves_evenly_between_inner_keyframes_goes_on_so() {
        let path = CameraPath {
            keys: (0..6)
                .map(|index| key(index * 10 + index % 2 * 3, (index * 10 + index % 2 * 3) as f32))
                .collect(),
        };
        for frame in 13..40 {
            assert!((x(&path, frame) - frame as f32).abs() < 1e-4, "{frame}: {}", x(&path, frame));
        }
    }
}
