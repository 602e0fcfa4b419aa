//! Where the camera stands, and the way that it goes.

use super::Check;
use crate::core::grid::Grid;
use crate::scene;
use crate::terrain::Plan;
use crate::world::fault::Complaint;
use crate::world::keys::{self, EDGE_OFFSET};
use crate::world::place::KeyPath;

impl Check<'_> {
    pub(super) fn viewpoint(&mut self, view: &keys::View, plan: &Plan) -> scene::Viewpoint {
        match view {
            keys::View::FrameIsland(frame) => {
                let &keys::FrameIsland { azimuth, elevation, distance } = frame;
                scene::Viewpoint::Fixed(scene::View::FrameIsland { azimuth, elevation, distance })
            }
            keys::View::LookAt(look) => scene::Viewpoint::Fixed(self.look_at(look, plan.final_sea_level())),
            keys::View::Stand(stand) => scene::Viewpoint::Stand(self.stand(stand, plan.grid)),
        }
    }

    fn look_at(&mut self, look: &keys::LookAt, sea_level: f32) -> scene::View {
        let &keys::LookAt { position, target, roll } = look;
        self.stands(&KeyPath::from("camera.view.look_at"), position, target, sea_level);
        scene::View::LookAt { position: position.into(), target: target.into(), roll }
    }

    fn stand(&mut self, stand: &keys::Stand, grid: Grid) -> scene::Stand {
        let &keys::Stand { at, height, azimuth, distance, expected_height, edge_offset } = stand;
        let key = KeyPath::from("camera.view.stand");
        let half = grid.extent / 2.0;
        let place = match at {
            Some(at) => {
                let others = [("expected_height", expected_height), ("edge_offset", edge_offset)];
                for (name, _) in others.iter().filter(|(_, value)| value.is_some()) {
                    let complaint = Complaint::new("has no use here", "`at` says where the camera stands");
                    self.refuse(&[key.join(name), key.join("at")], complaint.about_key());
                }
                if at.iter().any(|along| along.abs() > half) {
                    let label = format!("allowed: up to {half} m from the middle, half of the extent");
                    let complaint = Complaint::new("lies outside the terrain", label);
                    self.refuse(&[key.join("at"), "terrain.extent".into()], complaint);
                }
                scene::Place::At(at.into())
            }
            None => {
                let edge_offset = edge_offset.unwrap_or((EDGE_OFFSET as f32).min(half));
                if edge_offset > half {
                    let label = format!("allowed: up to {half} m, half of the extent");
                    let complaint = Complaint::new("leaves no place to stand", label);
                    self.refuse(&[key.join("edge_offset"), "terrain.extent".into()], complaint);
                }
                scene::Place::Height { expected: expected_height.unwrap_or(0.0), edge_offset }
            }
        };
        scene::Stand { place, height, azimuth, distance }
    }

    /// Refuses a camera that looks nowhere, or is under the sea.
    fn stands(&mut self, place: &KeyPath, position: [f32; 3], target: [f32; 3], sea_level: f32) {
        if position == target {
            let complaint = Complaint::new("is where the camera stands", "another point than `position`");
            self.refuse(&[place.join("target"), place.join("position")], complaint);
        }
        if position[1] <= sea_level {
            let label = format!("allowed: above {sea_level} m, where the sea is in the end");
            let complaint = Complaint::new("lies under the sea", label)
                .help("raise its second number, or lower `sea.level`");
            self.refuse(&[place.join("position"), "sea.level".into()], complaint);
        }
    }

    /// The camera's way, with what each keyframe leaves out.
    pub(super) fn camera_path(&mut self, camera: &keys::Camera, sea_level: f32) -> scene::CameraPath {
        let (mut at, mut to, mut roll) = (None, None, 0.0);
        let (mut fov, mut focus) = (camera.fov, camera.focus);
        let mut path = scene::CameraPath::default();
        for (index, key) in camera.keyframes.iter().enumerate() {
            let place = KeyPath::from("camera.keyframes").join(index);
            at = key.position.or(at);
            to = key.target.or(to);
            roll = key.roll.unwrap_or(roll);
            (fov, focus) = (key.fov.unwrap_or(fov), key.focus.unwrap_or(focus));
            if let Some(before) = path.keys.last().filter(|before| before.frame >= key.frame) {
                let label = format!("allowed: more than {}, the frame of the keyframe before", before.frame);
                self.refuse(&[place.join("frame"), place.clone()], Complaint::new("is out of order", label));
            }
            for (name, value) in [("position", at), ("target", to)] {
                if value.is_none() {
                    let complaint = Complaint::new("is missing", "the first keyframe must say it");
                    self.refuse(&[place.join(name), place.clone()], complaint.about_key());
                }
            }
            let (Some(position), Some(target)) = (at, to) else { return path };
            self.stands(&place, position, target, sea_level);
            let (position, target) = (position.into(), target.into());
            path.keys.push(scene::Keyframe { frame: key.frame, position, target, roll, fov, focus });
        }
        path
    }
}
