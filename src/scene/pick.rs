//! What a ray meets of all that stands on the ground, on the host: for a click. Pictures have trees of boxes for that.

use super::{Instance, Model, Population};
use glam::Vec3;
use rayon::prelude::*;

/// What a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Met {
    /// Index into [`Population::instances`].
    pub instance: usize,
    /// In lengths of the ray's direction.
    pub range: f32,
}

/// Half a line.
#[derive(Clone, Copy, Debug)]
struct Ray {
    origin: Vec3,
    direction: Vec3,
}

impl Population {
    /// Least and greatest coordinates of every model, as [`Population::met`] wants them.
    pub fn bounds(&self) -> Vec<[Vec3; 2]> {
        self.models.par_iter().map(|model| model.bounds()).collect()
    }

    /// The first instance whose triangles (of the finest level) the ray meets, nearer than `range`, in lengths of `direction`.
    pub fn met(&self, bounds: &[[Vec3; 2]], origin: Vec3, direction: Vec3, range: f32) -> Option<Met> {
        let ray = Ray { origin, direction };
        let entered = |(index, instance): (usize, &Instance)| {
            let bounds = bounds.get(instance.model as usize)?;
            Some((ray.seen_from(instance).enters(*bounds, range)?, index))
        };
        let mut entered: Vec<(f32, usize)> =
            self.instances.par_iter().enumerate().filter_map(entered).collect();
        entered.sort_unstable_by(|(one, _), (other, _)| one.total_cmp(other));
        let mut first: Option<Met> = None;
        for (entry, index) in entered {
            let most = first.map_or(range, |met| met.range);
            if entry >= most {
                break;
            }
            let Some(instance) = self.instances.get(index) else { continue };
            let Some(model) = self.models.get(instance.model as usize) else { continue };
            let met = ray.seen_from(instance).meets(model).filter(|range| *range < most);
            first = met.map(|range| Met { instance: index, range }).or(first);
        }
        first
    }
}

impl Ray {
    /// The same ray in the coordinates of an instance's model: lengths along it stay.
    fn seen_from(&self, instance: &Instance) -> Ray {
        let turned = |vector: Vec3| instance.rotation.inverse() * vector / instance.scale;
        Ray { origin: turned(self.origin - instance.position), direction: turned(self.direction) }
    }

    /// Where it comes into a box, if it does so before `range` (Kay & Kajiya 1986, slabs).
    fn enters(&self, [least, greatest]: [Vec3; 2], range: f32) -> Option<f32> {
        let (one, other) =
            ((least - self.origin) / self.direction, (greatest - self.origin) / self.direction);
        let entry = one.min(other).max_element().max(0.0);
        let exit = one.max(other).min_element();
        (entry <= exit && entry < range).then_some(entry)
    }

    /// How far the nearest triangle of a model's finest level is.
    fn meets(&self, model: &Model) -> Option<f32> {
        let parts = model.levels.first().into_iter().flat_map(|level| &level.parts);
        let triangles = parts.flat_map(|part| {
            let corner = |index: u32| part.mesh.positions.get(index as usize).copied().map(Vec3::from);
            part.mesh
                .triangles
                .iter()
                .filter_map(move |[a, b, c]| Some([corner(*a)?, corner(*b)?, corner(*c)?]))
        });
        triangles.filter_map(|triangle| self.crosses(triangle)).min_by(f32::total_cmp)
    }

    /// How far a triangle is, whichever side is seen (Möller & Trumbore 1997).
    fn crosses(&self, [a, b, c]: [Vec3; 3]) -> Option<f32> {
        let (ab, ac) = (b - a, c - a);
        let across = self.direction.cross(ac);
        let determinant = ab.dot(across);
        if determinant == 0.0 {
            return None;
        }
        let from_a = self.origin - a;
        let u = from_a.dot(across) / determinant;
        let up = from_a.cross(ab);
        let v = self.direction.dot(up) / determinant;
        let range = ac.dot(up) / determinant;
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && range > 0.0).then_some(range)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::mesh::Mesh;
    use crate::scene::{Level, Part};
    use glam::Quat;
    use std::sync::Arc;

    /// A square board one metre wide and two high, that looks north, with its lower left quarter missing.
    fn board() -> Model {
        let positions = vec![
            [0.0, 0.0, 0.0],
            [0.5, 0.0, 0.0],
            [0.5, 2.0, 0.0],
            [0.0, 2.0, 0.0],
            [-0.5, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [-0.5, 2.0, 0.0],
        ];
        let triangles = vec![[0, 1, 2], [0, 2, 3], [4, 5, 3], [4, 3, 6]];
        let mesh = Mesh { positions, triangles, ..Mesh::default() };
        let level = Level { detail: 0.0, parts: vec![Part { material: 0, mesh }] };
        Model { levels: vec![level], ..Model::default() }
    }

    fn at(position: [f32; 3], azimuth: f32, scale: f32) -> Instance {
        let rotation = Quat::from_rotation_y(azimuth);
        Instance { model: 0, random: 0, position: position.into(), rotation, scale }
    }

    fn met(instances: &[Instance], [x, y]: [f32; 2], range: f32) -> Option<Met> {
        let population = Population { models: vec![Arc::new(board())], instances: instances.into() };
        let direction = Vec3::NEG_Z * 2.0;
        population.met(&population.bounds(), Vec3::new(x, y, 10.0), direction, range)
    }

    #[test]
    fn the_nearest_is_met_where_it_has_triangles() {
        let boards = [at([0.0; 3], 0.0, 1.0), at([0.0, 0.0, 6.0], 0.0, 1.0), at([0.0, 0.0, -30.0], 0.0, 9.0)];
        let find = |at| met(&boards, at, 1e9).map(|met| (met.instance, (met.range * 1e3).round()));
        assert_eq!(find([0.2, 0.5]), Some((1, 2e3)));
        assert_eq!(find([-0.2, 1.5]), Some((1, 2e3)));
        // Through what is missing of both that are near; and above them.
        assert_eq!(find([-0.2, 0.5]), None);
        assert_eq!(find([0.2, 3.0]), Some((2, 2e4)));
        assert_eq!(find([0.2, 30.0]), None);
    }

    #[test]
    fn what_is_hidden_is_not_met() {
        assert!(met(&[at([0.0; 3], 0.0, 1.0)], [0.2, 0.5], 5.1).is_some());
        assert!(met(&[at([0.0; 3], 0.0, 1.0)], [0.2, 0.5], 4.9).is_none());
        // Nor is what is behind the eye.
        assert!(met(&[at([0.0, 0.0, 20.0], 0.0, 1.0)], [0.2, 0.5], 1e9).is_none());
    }

    #[test]
    fn instances_are_turned_and_scaled() {
        let half_turn = std::f32::consts::PI;
        let turned = [at([0.0; 3], half_turn, 3.0)];
        assert!(met(&turned, [-0.6, 1.5], 1e9).is_some_and(|met| (met.range - 5.0).abs() < 1e-4));
        assert!(met(&turned, [0.6, 1.5], 1e9).is_none());
        assert!(met(&turned, [0.6, 4.5], 1e9).is_some());
    }
}
