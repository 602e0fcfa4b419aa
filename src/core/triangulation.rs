//! A height field as few triangles that stay as close to it as asked.
//!
//! Greedy insertion (Garland & Heckbert 1995, "Fast polygonal approximation of terrains and height fields", algorithm
//! III): begin with two triangles and insert the sample that lies farthest from them, until none lies too far. The
//! triangles are Delaunay's, so there are no slivers where the land asks for none. Right-triangulated networks and
//! restricted quadtrees (Lindstrom et al. 1996) are faster, but their corners lie where halving puts them rather than where
//! the land bends, which takes more of them, and the grid must have 2ⁿ + 1 samples a side. Here any grid will do, and the
//! bound is what insertion stops at rather than an estimate.
//!
//! Samples on the rim are chosen first and by the rim alone (Douglas & Peucker 1973), so that lands that share the samples
//! of an edge share the vertices on it.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Longest side of a height field, samples: its predicates are exact in 64 bits up to here.
pub const MAX_SIDE: u32 = (1 << 14) + 1;

/// Triangles over a grid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Triangulation {
    /// Width and height of the grid, samples.
    pub size: [u32; 2],
    /// Column and row of each vertex, row by row. The corners of the grid are among them.
    pub vertices: Vec<[u16; 2]>,
    /// Three vertices each, counter-clockwise seen from above (north up, east right), the first of them the least. They cover
    /// the grid without gaps or overlaps, and meet edge to edge.
    pub triangles: Vec<[u32; 3]>,
}

impl Triangulation {
    /// Every sample of a height field of `size` = [width, height], row by row, and two triangles a cell: cut along the
    /// diagonal whose ends differ less in height, which runs along ridges and valleys rather than across.
    pub fn full(heights: &[f32], size: [u32; 2]) -> Self {
        let [width, height] = size;
        let vertices = (0..height).flat_map(|row| (0..width).map(move |column| [column as u16, row as u16]));
        let cells = (0..height - 1).flat_map(|row| (0..width - 1).map(move |column| row * width + column));
        let triangles = cells.flat_map(|north_west| {
            let [north_east, south_west, south_east] =
                [north_west + 1, north_west + width, north_west + width + 1];
            let drop = |from: u32, to: u32| (heights[from as usize] - heights[to as usize]).abs();
            if drop(north_west, south_east) <= drop(north_east, south_west) {
                [[north_west, south_west, south_east], [north_west, south_east, north_east]]
            } else {
                [[north_west, south_west, north_east], [north_east, south_west, south_east]]
            }
        });
        Triangulation { size, vertices: vertices.collect(), triangles: triangles.collect() }
    }

    /// Triangles whose vertical distance from each sample is at most `error`: [`Refinement`] to its end.
    pub fn within(heights: &[f32], size: [u32; 2], error: f32) -> Self {
        if error <= 0.0 {
            return Self::full(heights, size);
        }
        let mut refinement = Refinement::new(heights, size, error);
        while !refinement.finished() {
            refinement.insert(u32::MAX);
        }
        refinement.into_triangulation()
    }
}

/// The triangulation of a height field while it grows. The largest error falls as it does.
pub struct Refinement<'a> {
    heights: &'a [f32],
    size: [u32; 2],
    /// That is allowed.
    error: f64,
    vertices: Vec<[u16; 2]>,
    /// Of each triangle three vertices, counter-clockwise. Edge `3t + k` runs from corner k of triangle t to the next.
    corners: Vec<u32>,
    /// The same edge in the triangle on its other side, or [`NONE`].
    twins: Vec<u32>,
    /// Of each triangle the sample that lies farthest from it, if that is too far; else [`NONE`].
    farthest: Vec<u32>,
    /// Those samples. Entries of triangles that are gone stay behind, and are passed over.
    queue: BinaryHeap<Candidate>,
    // Kept from one insertion to the next to save allocations.
    cavity: Vec<u32>,
    outline: Vec<Edge>,
    pending: Vec<u32>,
}

const NONE: u32 = u32::MAX;

/// The largest error comes first; of equal ones the first sample, so that every run makes the same mesh.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    /// Bits of a float that is not negative: they have its order.
    error: u32,
    sample: Reverse<u32>,
    triangle: u32,
}

/// An edge of the hole that an insertion makes.
#[derive(Clone, Copy)]
struct Edge {
    from: u32,
    to: u32,
    /// In the triangle outside, or [`NONE`].
    twin: u32,
}

impl<'a> Refinement<'a> {
    /// Begins with the rim of a height field of `size` = [width, height], 2 to [`MAX_SIDE`] samples each, row by row. At the
    /// end no sample will be farther than `error` > 0 above or below the triangles.
    pub fn new(heights: &'a [f32], size: [u32; 2], error: f32) -> Self {
        let [east, south] = size.map(|side| (side - 1) as u16);
        let mut refinement = Refinement {
            heights,
            size,
            error: error.into(),
            vertices: vec![[0, 0], [east, 0], [0, south], [east, south]],
            corners: vec![0, 2, 3, 0, 3, 1],
            twins: vec![NONE, NONE, 3, 2, NONE, NONE],
            farthest: vec![NONE; 2],
            queue: BinaryHeap::new(),
            cavity: Vec::new(),
            outline: Vec::new(),
            pending: Vec::new(),
        };
        refinement.insert_rim();
        for triangle in 0..refinement.farthest.len() {
            refinement.find_farthest(triangle as u32);
        }
        refinement
    }

    /// Inserts that many samples, or as many as are needed.
    pub fn insert(&mut self, most: u32) {
        for _ in 0..most {
            let Some(Candidate { sample: Reverse(sample), triangle, .. }) = self.next() else { return };
            self.queue.pop();
            self.split(triangle, self.place(sample));
            for index in 0..self.cavity.len() {
                self.find_farthest(self.cavity[index]);
            }
        }
    }

    pub fn finished(&mut self) -> bool {
        self.next().is_none()
    }

    /// How many vertices there are.
    pub fn vertices(&self) -> u64 {
        self.vertices.len() as u64
    }

    /// How many there will be, about: the error falls as their number grows.
    pub fn expected(&mut self) -> u64 {
        let ratio = self.next().map_or(1.0, |next| f64::from(f32::from_bits(next.error)) / self.error);
        ((self.vertices() as f64 * ratio) as u64).min(u64::from(self.size[0]) * u64::from(self.size[1]))
    }

    /// Bytes of memory in use.
    pub fn bytes(&self) -> u64 {
        let words = self.vertices.len() + self.corners.len() + self.twins.len() + self.farthest.len();
        (4 * words + size_of::<Candidate>() * self.queue.len()) as u64
    }

    /// What there is.
    pub fn into_triangulation(self) -> Triangulation {
        let Refinement { size, vertices, corners, .. } = self;
        let mut order: Vec<u32> = (0..vertices.len() as u32).collect();
        order.sort_unstable_by_key(|&vertex| {
            let [column, row] = vertices[vertex as usize];
            [row, column]
        });
        let mut rank = vec![0; order.len()];
        for (index, &vertex) in order.iter().enumerate() {
            rank[vertex as usize] = index as u32;
        }
        let (chunks, _) = corners.as_chunks::<3>();
        let mut triangles: Vec<[u32; 3]> = chunks
            .iter()
            .map(|corners| {
                let [a, b, c] = corners.map(|corner| rank[corner as usize]);
                [[a, b, c], [b, c, a], [c, a, b]].into_iter().fold([NONE; 3], Ord::min)
            })
            .collect();
        triangles.sort_unstable();
        let vertices = order.iter().map(|&vertex| vertices[vertex as usize]).collect();
        Triangulation { size, vertices, triangles }
    }

    /// What is to be inserted next.
    fn next(&mut self) -> Option<Candidate> {
        loop {
            let &next = self.queue.peek()?;
            if self.farthest[next.triangle as usize] == next.sample.0 {
                return Some(next);
            }
            self.queue.pop();
        }
    }

    /// Inserts what the rim needs, by Douglas & Peucker's rule: where an edge is too far from a sample between its ends, it
    /// is broken at the farthest one. Each side is looked at from west to east or from north to south.
    fn insert_rim(&mut self) {
        let [east, south] = self.size.map(|side| (side - 1) as u16);
        let sides = [
            ([0, 0], [1, 0], east),
            ([0, south], [1, 0], east),
            ([0, 0], [0, 1], south),
            ([east, 0], [0, 1], south),
        ];
        let mut triangle = 0;
        for (start, step, length) in sides {
            let place = |along: u16| [start[0] + step[0] * along, start[1] + step[1] * along];
            let height = |along: u16| self.height(place(along));
            for along in broken_line(length, height, self.error) {
                triangle = self.locate(place(along), triangle);
                self.split(triangle, place(along));
                triangle = self.cavity[0];
            }
        }
    }

    /// A triangle that holds a place, by walking from another: across any edge that has the place on its far side. That
    /// ends, among Delaunay's triangles.
    fn locate(&self, place: [u16; 2], from: u32) -> u32 {
        let mut triangle = from;
        'walk: loop {
            for edge in 3 * triangle..3 * triangle + 3 {
                let [start, end] = [edge, next_edge(edge)].map(|edge| self.corner(edge));
                let twin = self.twins[edge as usize];
                if twin != NONE && turn(start, end, place) < 0 {
                    triangle = twin / 3;
                    continue 'walk;
                }
            }
            return triangle;
        }
    }

    /// Makes a place a vertex (Bowyer 1981, Watson 1981): the triangles whose circumcircles hold it go, and the hole is
    /// filled with triangles around it, which are left in `cavity`. `triangle` holds the place.
    fn split(&mut self, triangle: u32, place: [u16; 2]) {
        let vertex = self.vertices.len() as u32;
        self.vertices.push(place);
        self.cavity.clear();
        self.outline.clear();
        self.pending.clear();

        // No vertex lies within the hole, so its triangles hang together as a tree: entered by one edge and left by the two
        // others in order, they yield the outline in order.
        self.cavity.push(triangle);
        self.pending.extend([3 * triangle + 2, 3 * triangle + 1, 3 * triangle]);
        while let Some(edge) = self.pending.pop() {
            let twin = self.twins[edge as usize];
            if twin != NONE && self.circle_holds(twin / 3, place) {
                self.cavity.push(twin / 3);
                let next = next_edge(twin);
                self.pending.extend([next_edge(next), next]);
                continue;
            }
            let [from, to] = [self.corners[edge as usize], self.corners[next_edge(edge) as usize]];
            self.outline.push(Edge { from, to, twin });
        }

        // On the rim the place lies on an edge of the outline, which makes no triangle: the fan is open there.
        let on_rim = self.outline.iter().position(|edge| {
            let [from, to] = [edge.from, edge.to].map(|vertex| self.vertices[vertex as usize]);
            edge.twin == NONE && turn(from, to, place) == 0
        });
        if let Some(index) = on_rim {
            self.outline.rotate_left(index + 1);
            self.outline.pop();
        }
        while self.cavity.len() < self.outline.len() {
            self.cavity.push(self.farthest.len() as u32);
            self.farthest.push(NONE);
            self.corners.extend([NONE; 3]);
            self.twins.extend([NONE; 3]);
        }

        let count = self.outline.len();
        for index in 0..count {
            let triangle = self.cavity[index];
            let Edge { from, to, twin } = self.outline[index];
            let before = self.cavity[(index + count - 1) % count];
            let after = self.cavity[(index + 1) % count];
            let first = 3 * triangle as usize;
            self.corners[first..first + 3].copy_from_slice(&[from, to, vertex]);
            self.twins[first..first + 3].copy_from_slice(&[twin, 3 * after + 2, 3 * before + 1]);
            if twin != NONE {
                self.twins[twin as usize] = 3 * triangle;
            }
        }
        if on_rim.is_some() {
            let [first, last] = [self.cavity[0], self.cavity[count - 1]];
            self.twins[3 * first as usize + 2] = NONE;
            self.twins[3 * last as usize + 1] = NONE;
        }
    }

    /// Whether a place lies within the circle through the corners of a triangle, and not on it.
    fn circle_holds(&self, triangle: u32, place: [u16; 2]) -> bool {
        let [[ax, ay], [bx, by], [cx, cy]] = [0, 1, 2].map(|corner| {
            let [east, south] = difference(place, self.corner(3 * triangle + corner));
            [east, -south]
        });
        let [a, b, c] = [ax * ax + ay * ay, bx * bx + by * by, cx * cx + cy * cy];
        a * (bx * cy - by * cx) + b * (cx * ay - cy * ax) + c * (ax * by - ay * bx) > 0
    }

    /// Looks for the sample that is farthest above or below a triangle, and queues it if it is too far. Those on the rim
    /// have been seen to.
    fn find_farthest(&mut self, triangle: u32) {
        let corners = [0, 1, 2].map(|corner| self.corner(3 * triangle + corner));
        let mut farthest = Farthest { error: self.error, sample: NONE };
        self.scan(corners, &mut farthest);
        self.farthest[triangle as usize] = farthest.sample;
        if farthest.sample != NONE {
            let error = (farthest.error as f32).to_bits();
            self.queue.push(Candidate { error, sample: Reverse(farthest.sample), triangle });
        }
    }

    /// Compares the samples within a triangle and on its edges with its plane.
    fn scan(&self, [a, b, c]: [[u16; 2]; 3], farthest: &mut Farthest) {
        let [width, height] = self.size.map(|side| side as i32);
        let first_row = a[1].min(b[1]).min(c[1]).max(1) as i32;
        let last_row = (a[1].max(b[1]).max(c[1]) as i32).min(height - 2);

        // The plane: height = height of a + east·columns + south·rows from a.
        let ([bx, by], [cx, cy]) = (difference(a, b), difference(a, c));
        let [b_rise, c_rise] = [b, c].map(|corner| self.height(corner) - self.height(a));
        let area = (cx * by - bx * cy) as f64;
        let east = (c_rise * by as f64 - b_rise * cy as f64) / area;
        let south = (b_rise * cx as f64 - c_rise * bx as f64) / area;

        for row in first_row..=last_row {
            let [mut first, mut last] = [1, width - 2];
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let [columns, rows] =
                    [i32::from(to[0]) - i32::from(from[0]), i32::from(to[1]) - i32::from(from[1])];
                let down = row - i32::from(from[1]);
                // The triangle lies to the east of edges that run south, to the west of edges that run north.
                if rows > 0 {
                    first = first.max(i32::from(from[0]) - (-columns * down).div_euclid(rows));
                } else if rows < 0 {
                    last = last.min(i32::from(from[0]) + (-columns * down).div_euclid(-rows));
                }
            }
            if first > last {
                continue;
            }
            let start = (row * width) as usize;
            let samples = &self.heights[start + first as usize..=start + last as usize];
            let plane = self.height(a)
                + south * f64::from(row - i32::from(a[1]))
                + east * f64::from(first - i32::from(a[0]));
            for (index, &height) in samples.iter().enumerate() {
                let error = (f64::from(height) - (plane + east * index as f64)).abs();
                if error > farthest.error {
                    *farthest = Farthest { error, sample: (start + first as usize + index) as u32 };
                }
            }
        }
    }

    fn corner(&self, edge: u32) -> [u16; 2] {
        self.vertices[self.corners[edge as usize] as usize]
    }

    fn height(&self, [column, row]: [u16; 2]) -> f64 {
        self.heights[usize::from(row) * self.size[0] as usize + usize::from(column)].into()
    }

    fn place(&self, sample: u32) -> [u16; 2] {
        [(sample % self.size[0]) as u16, (sample / self.size[0]) as u16]
    }
}

/// A sample that is farther from its triangle than all before.
struct Farthest {
    error: f64,
    sample: u32,
}

/// Which samples between the ends of a line of `length` intervals it takes to stay within `error` of all, in order
/// (Douglas & Peucker 1973, with vertical distances).
fn broken_line(length: u16, height: impl Fn(u16) -> f64, error: f64) -> Vec<u16> {
    let mut kept = Vec::new();
    // The last is the nearest to the start.
    let mut ends = vec![length];
    let mut from = 0;
    while let Some(&to) = ends.last() {
        let (start, rise) = (height(from), height(to) - height(from));
        let mut farthest = (error, None);
        for at in from + 1..to {
            let share = f64::from(at - from) / f64::from(to - from);
            let error = (height(at) - (start + rise * share)).abs();
            if error > farthest.0 {
                farthest = (error, Some(at));
            }
        }
        if let (_, Some(at)) = farthest {
            ends.push(at);
            continue;
        }
        from = to;
        ends.pop();
        if !ends.is_empty() {
            kept.push(to);
        }
    }
    kept
}

/// The edge that follows in the same triangle.
fn next_edge(edge: u32) -> u32 {
    if edge % 3 == 2 { edge - 2 } else { edge + 1 }
}

/// Twice the area of a triangle: above zero where it is counter-clockwise seen from above, with rows running south.
fn turn(a: [u16; 2], b: [u16; 2], c: [u16; 2]) -> i64 {
    let ([bx, by], [cx, cy]) = (difference(a, b), difference(a, c));
    cx * by - bx * cy
}

fn difference(from: [u16; 2], to: [u16; 2]) -> [i64; 2] {
    [0, 1].map(|axis| i64::from(to[axis]) - i64::from(from[axis]))
}
