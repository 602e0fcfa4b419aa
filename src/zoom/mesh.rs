//! What is in view, as triangles for other programs.

use super::{
    address::Place,
    height::{AMPLITUDE, Surface},
    motion::Distance,
    tiles::Heights,
    tree::{Borders, Eye, Leaf},
};
use crate::core::mesh::Mesh;
use glam::DVec3;

/// Vertices and triangles of so many tiles.
pub fn size(tiles: usize, bits: u32) -> [u64; 2] {
    let side = 1u64 << bits;
    [(side + 1).pow(2), 2 * side * side].map(|of_a_tile| of_a_tile * tiles as u64)
}

/// The surface of tiles, from the place, in cells of the distance's level. Heights are exact: nothing fades by distance. A tile that touches a coarser one has the
/// vertices of that at their border, and so there are no cracks. Texture coordinates are those of each tile.
pub fn mesh(surface: &Surface, place: &Place, from: Distance, bits: u32, seen: &[(Leaf, Heights)]) -> Mesh {
    let mut mesh = Mesh::default();
    for (leaf, heights) in seen {
        let level = leaf.cell.level + bits;
        let grid = Grid {
            surface,
            level,
            eye: Eye::new(surface, place, level),
            scale: libm::exp2(f64::from(from.level) - f64::from(level)),
            side: 1 << bits,
            borders: leaf.borders,
            heights,
        };
        grid.add_to(&mut mesh);
    }
    mesh
}

/// The vertices of a tile.
struct Grid<'a> {
    surface: &'a Surface,
    level: u32,
    eye: Eye,
    /// The spacing of its vertices.
    scale: f64,
    /// Quads along a side.
    side: usize,
    borders: Borders,
    heights: &'a Heights,
}

impl Grid<'_> {
    fn add_to(&self, mesh: &mut Mesh) {
        let first = mesh.positions.len() as u32;
        for row in 0..=self.side {
            for column in 0..=self.side {
                mesh.positions.push(self.position(self.kept([column, row])));
                mesh.normals.push(self.normal([column, row]));
                mesh.uvs.push([column, row].map(|at| at as f32 / self.side as f32));
            }
        }
        let index = |at: [usize; 2]| {
            let [column, row] = self.kept(at);
            first + (row * (self.side + 1) + column) as u32
        };
        for row in 0..self.side {
            for column in 0..self.side {
                let [a, b, c, d] =
                    [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[right, down]| index([column + right, row + down]));
                // Tiles begin at even coordinates: diagonals are those of `rises`.
                let triangles =
                    if (row ^ column) & 1 == 0 { [[a, c, d], [a, d, b]] } else { [[a, c, b], [b, c, d]] };
                let has_area = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
                mesh.triangles.extend(triangles.into_iter().filter(has_area));
            }
        }
    }

    /// Which edges a vertex is on: west, east, north, south.
    fn edges(&self, [column, row]: [usize; 2]) -> [bool; 4] {
        [column == 0, column == self.side, row == 0, row == self.side]
    }

    /// The vertex that stands for one: an edge that faces a coarser tile has the vertices of that alone.
    fn kept(&self, [column, row]: [usize; 2]) -> [usize; 2] {
        let faces = |edge: usize| self.edges([column, row])[edge] && self.borders.edge_is_coarser(edge);
        let even = |at: usize, faces: bool| if faces { at & !1 } else { at };
        [even(column, faces(2) || faces(3)), even(row, faces(0) || faces(1))]
    }

    /// Whether a vertex is one of a coarser tile, too.
    fn is_coarser(&self, at: [usize; 2]) -> bool {
        let [west, east, north, south] = self.edges(at);
        if (west || east) && (north || south) {
            return self.borders.corner_is_coarser(usize::from(east) + 2 * usize::from(south));
        }
        (0..4).any(|edge| self.edges(at)[edge] && self.borders.edge_is_coarser(edge))
    }

    fn position(&self, [column, row]: [usize; 2]) -> [f32; 3] {
        let cell = self.heights.cell;
        let first = |coordinate: u64| coordinate.wrapping_mul(self.side as u64);
        let [x, z] = [first(cell.x).wrapping_add(column as u64), first(cell.z).wrapping_add(row as u64)];
        let mut height = self.heights.base.wrapping_add(self.difference(column + 1, row + 1).into());
        if self.is_coarser([column, row]) {
            // Without the octave that the coarser tile has not.
            height = height.wrapping_sub(self.surface.octave(self.level).at(x, z).into());
        }
        self.eye.to(x, height, z).map(|distance| (distance * self.scale) as f32)
    }

    /// By central differences, of all octaves.
    fn normal(&self, [column, row]: [usize; 2]) -> [f32; 3] {
        let rise = |from: [usize; 2], to: [usize; 2]| {
            let [from, to] = [from, to].map(|[column, row]| f64::from(self.difference(column, row)));
            (from - to) * self.surface.roughness.cells() / AMPLITUDE as f64
        };
        let [column, row] = [column + 1, row + 1];
        let east = rise([column - 1, row], [column + 1, row]);
        let south = rise([column, row - 1], [column, row + 1]);
        DVec3::new(east, 2.0, south).normalize().as_vec3().to_array()
    }

    /// To the base; the first column and row are outside.
    fn difference(&self, column: usize, row: usize) -> i32 {
        self.heights.differences[row * (self.side + 3) + column]
    }
}
