//! Triangles as other programs take them.

use super::grid::Grid;
use super::triangulation::Triangulation;

/// Triangles that share corners. Positions, normals and texture coordinates have one entry a corner, at the same place.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// World coordinates, metres.
    pub positions: Vec<[f32; 3]>,
    /// Of length 1.
    pub normals: Vec<[f32; 3]>,
    /// Of a picture whose upper left corner is (0, 0) and whose lower right one is (1, 1).
    pub uvs: Vec<[f32; 2]>,
    /// Counter-clockwise, seen from the side that the normals point to.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Bytes of memory that a mesh of that size takes.
    pub fn bytes(vertices: u64, triangles: u64) -> u64 {
        32 * vertices + 12 * triangles
    }

    /// The land over `triangulation`, whose first sample is that in column and row `origin` of the whole land. `heights`
    /// are those of the whole land, row by row: normals come from all of them, so that light falls on a coarse mesh as on
    /// the land itself and neighbouring tiles agree at their common edge. Pictures lie over the triangulation alone.
    pub fn of_land(heights: &[f32], grid: Grid, origin: [u32; 2], triangulation: Triangulation) -> Self {
        let Triangulation { size, vertices, triangles } = triangulation;
        let place = |vertex: &[u16; 2]| [origin[0] + u32::from(vertex[0]), origin[1] + u32::from(vertex[1])];
        let position = |[column, row]: [u32; 2]| {
            let [x, z] = grid.position(column, row);
            [x, heights[row as usize * grid.cells as usize + column as usize], z]
        };
        let uv = |vertex: &[u16; 2]| {
            [0, 1].map(|axis| (f64::from(vertex[axis]) / f64::from(size[axis] - 1)) as f32)
        };
        Mesh {
            positions: vertices.iter().map(|vertex| position(place(vertex))).collect(),
            normals: vertices.iter().map(|vertex| normal(heights, grid, place(vertex))).collect(),
            uvs: vertices.iter().map(uv).collect(),
            triangles,
        }
    }

    /// Least and greatest coordinates.
    pub fn bounds(&self) -> [[f32; 3]; 2] {
        let Some(&first) = self.positions.first() else { return [[0.0; 3]; 2] };
        self.positions.iter().fold([first; 2], |[least, most], position| {
            let fold = |from: [f32; 3], pick: fn(f32, f32) -> f32| {
                std::array::from_fn(|axis| pick(from[axis], position[axis]))
            };
            [fold(least, f32::min), fold(most, f32::max)]
        })
    }
}

/// The unit normal of a height field by central differences, one-sided at the rim.
fn normal(heights: &[f32], grid: Grid, [column, row]: [u32; 2]) -> [f32; 3] {
    let last = grid.cells - 1;
    let height =
        |column: u32, row: u32| f64::from(heights[row as usize * grid.cells as usize + column as usize]);
    let slope = |from: [u32; 2], to: [u32; 2]| {
        let cells = f64::from(to[0] - from[0] + to[1] - from[1]);
        (height(to[0], to[1]) - height(from[0], from[1])) / (cells * f64::from(grid.extent) / f64::from(last))
    };
    let east = slope([column.saturating_sub(1), row], [last.min(column + 1), row]);
    let south = slope([column, row.saturating_sub(1)], [column, last.min(row + 1)]);
    let length = (east * east + 1.0 + south * south).sqrt();
    [-east, 1.0, -south].map(|component| (component / length) as f32)
}
