//! Tiles of a zoom on the device: every height and gradient is the one that the CPU has, whatever was made before.

use crate::kit;
use crate::kit::zoom::{Words, random_place};
use terrane::{
    gpu::{Gpu, Recorder},
    zoom::{
        address::{Cell, Place},
        height::{Corners, REACH, Refinement, Roughness, Shaded, Spine, Surface, Tile},
        motion::{Autopilot, Depth},
        tiles::{Made, Tiles},
        tree::{Detail, Tree},
    },
};

const MODES: [Refinement; 2] = [Refinement::Triangles, Refinement::Bilinear];

fn surface(seed: u32, refinement: Refinement) -> Surface {
    Surface { seed, refinement, roughness: Roughness::Half }
}

/// The cell of a place, and its corners.
fn own(spine: &mut Spine, place: &Place, level: u32) -> (Cell, Corners) {
    let patch = spine.patch(place, level);
    (place.cell(level), patch.corners(REACH as usize, REACH as usize))
}

/// Heights, and gradients along x and z, of all slots.
fn download(gpu: &Gpu, tiles: &Tiles) -> [Vec<i32>; 3] {
    let [x, z] = tiles.gradients();
    let mut rec = Recorder::new(gpu);
    let all = [tiles.heights(), x, z].map(|buffer| rec.download(buffer));
    let done = rec.submit().unwrap().wait().unwrap();
    all.map(|part| part.take(&done))
}

/// Compares tiles that are there with those of the CPU.
fn check(all: &[Vec<i32>; 3], tiles: &Tiles, spine: &mut Spine, place: &Place, cells: &[Cell], bits: u32) {
    let surface = *spine.surface();
    for cell in cells {
        let slot = tiles.slot(*cell).expect("it is there");
        let vertices = ((1 << bits) + 3usize).pow(2);
        let [heights, x, z] = all.each_ref().map(|part| &part[slot.index as usize * vertices..][..vertices]);
        let [first_x, first_z] = [cell.x, cell.z].map(|first| first.wrapping_sub(1));
        let patch = match cell.level.checked_sub(1) {
            None => Shaded::start(&surface, first_x as i64, first_z as i64, 4),
            Some(coarser) => spine.shaded(place, coarser).refine(&surface, first_x, first_z, 4).unwrap(),
        };
        let exact = Tile::from_patch(&surface, &patch, *cell, bits).unwrap();
        assert_eq!(slot.base, exact.base, "{cell:?}");
        assert!(heights.iter().copied().eq(exact.heights()), "{cell:?}");
        let gradients = x.iter().zip(z).map(|(x, z)| [*x, *z]);
        assert!(gradients.eq(exact.gradients().iter().copied()), "gradients of {cell:?}");
    }
}

/// Tiles of successive levels, each from the one before, a pool full at a time. Returns how many vertices were compared.
fn chain(gpu: &Gpu, refinement: Refinement, bits: u32, slots: u32, levels: u32) -> usize {
    let surface = surface(3, refinement);
    let mut spine = Spine::new(surface);
    let place = random_place(&mut Words(5), levels + 63);
    let mut tiles = Tiles::new(gpu, surface, bits, slots).unwrap();
    let mut all_levels = (0..levels).collect::<Vec<u32>>();
    let mut compared = 0;
    while !all_levels.is_empty() {
        let batch: Vec<u32> = all_levels.drain(..(slots as usize / 2).min(all_levels.len())).collect();
        let mut rec = Recorder::new(gpu);
        for level in &batch {
            let wanted = own(&mut spine, &place, *level);
            // A tile that was made in this submission is a parent in it.
            assert_eq!(tiles.make(&mut rec, &mut spine, &place, [wanted], 1), Made { tiles: 1, waiting: 0 });
        }
        rec.submit().unwrap().wait().unwrap();
        let cells: Vec<Cell> = batch.iter().map(|level| place.cell(*level)).collect();
        check(&download(gpu, &tiles), &tiles, &mut spine, &place, &cells, bits);
        compared += cells.len() * ((1 << bits) + 3usize).pow(2);
    }
    compared
}

#[test]
fn the_device_has_the_surface_of_the_cpu() {
    let gpu = kit::gpu();
    for refinement in MODES {
        chain(&gpu, refinement, 4, 400, 800);
        chain(&gpu, refinement, 7, 40, 40);
    }
}

#[test]
#[ignore = "minutes: make test-long"]
fn the_device_has_the_surface_of_the_cpu_for_ten_thousand_levels() {
    let gpu = kit::gpu();
    for refinement in MODES {
        let compared = chain(&gpu, refinement, 7, 400, 10_000);
        println!("{refinement:?}: {compared} vertices alike");
    }
}

/// Trees of a flight in a pool that has to forget: what is there is right, and all that is drawn is there.
#[test]
fn a_pool_forgets_and_makes_again() {
    const BITS: u32 = 2;
    let gpu = kit::gpu();
    for (slots, budget) in [(6000, usize::MAX), (2600, usize::MAX), (2600, 150)] {
        let surface = surface(7, Refinement::Triangles);
        let mut spine = Spine::new(surface);
        let mut autopilot = Autopilot::new(surface);
        let mut tiles = Tiles::new(&gpu, surface, BITS, slots).unwrap();
        let bytes = gpu.memory().used;
        let mut made = 0;
        // In, a jump, and back.
        let depths = (0..10).chain([300, 301, 1000]).chain((5..12).rev());
        for depth in depths {
            let place = autopilot.at(&mut spine, Depth::level(depth)).place;
            let root = spine.patch(&place, depth.saturating_sub(10)).clone();
            let mut tree = Tree::new(&surface, &place, &root, Detail::default(), 2000).unwrap();
            let mut rec = Recorder::new(&gpu);
            let done = tiles.make(&mut rec, &mut spine, &place, tree.nodes(), budget);
            rec.submit().unwrap().wait().unwrap();
            assert!(done.tiles <= budget);
            assert!(budget < usize::MAX || done.waiting == 0, "{done:?} of {}", tree.nodes().count());
            made += done.tiles;
            tree.wait_for(|cell| tiles.slot(cell).is_some());
            let there: Vec<Cell> =
                tree.nodes().map(|(cell, _)| cell).filter(|cell| tiles.slot(*cell).is_some()).collect();
            if budget == usize::MAX {
                assert_eq!(there.len(), tree.nodes().count());
                // A second time there is nothing to do.
                let mut rec = Recorder::new(&gpu);
                let again = tiles.make(&mut rec, &mut spine, &place, tree.nodes(), budget);
                assert_eq!(again, Made::default());
            }
            check(&download(&gpu, &tiles), &tiles, &mut spine, &place, &there, BITS);
        }
        println!("{slots} slots: {made} tiles made");
        assert_eq!(gpu.memory().used, bytes, "nothing grows");
    }
}

/// Places with the same last digits, of which coordinates modulo 2⁶⁴ consist, have tiles of their own.
#[test]
fn places_with_the_same_last_digits_are_told_apart() {
    let gpu = kit::gpu();
    let surface = surface(2, Refinement::Triangles);
    let mut spine = Spine::new(surface);
    let place = random_place(&mut Words(1), 363);
    let mut moved = place.clone();
    moved.z.add(3, 50);
    let mut tiles = Tiles::new(&gpu, surface, 4, 50).unwrap();
    for place in [&place, &moved] {
        let wanted = own(&mut spine, place, 280);
        let mut rec = Recorder::new(&gpu);
        let made = tiles.make(&mut rec, &mut spine, place, [wanted], usize::MAX);
        assert_eq!(made, Made { tiles: 5, waiting: 0 });
        rec.submit().unwrap().wait().unwrap();
    }
    let [own, other] = [&place, &moved].map(|place| place.cell(280));
    assert_eq!((own.x, own.z), (other.x, other.z));
    for (place, cell) in [(&place, own), (&moved, other)] {
        check(&download(&gpu, &tiles), &tiles, &mut spine, place, &[cell], 4);
    }
}

/// No room for what is wanted: it waits.
#[test]
fn a_small_pool_makes_what_it_can() {
    let gpu = kit::gpu();
    let surface = surface(2, Refinement::Bilinear);
    let mut spine = Spine::new(surface);
    let place = random_place(&mut Words(1), 103);
    let mut tiles = Tiles::new(&gpu, surface, 4, 5).unwrap();
    let wanted: Vec<_> = (0..9).map(|level| own(&mut spine, &place, level)).collect();
    let mut rec = Recorder::new(&gpu);
    let made = tiles.make(&mut rec, &mut spine, &place, wanted, usize::MAX);
    assert_eq!(made, Made { tiles: 5, waiting: 4 });
    rec.submit().unwrap().wait().unwrap();
    let cells: Vec<Cell> = (0..5).map(|level| place.cell(level)).collect();
    check(&download(&gpu, &tiles), &tiles, &mut spine, &place, &cells, 4);
    tiles.clear();
    assert!(tiles.slot(cells[0]).is_none());
}
