//! How sheltered places on the land are: what its shape lets through of the sky's light and of the open sea's waves.

use super::Ground;
use crate::core::grid::Grid;
use crate::gpu::{self, Buffer, Compute, Gpu, Image, Recorder, format::R32f};
use crate::shaders::{
    Frame,
    scene::{openness, surf},
};
use std::ops::Range;

/// Images over the ground, as fine as its grid or coarser.
pub struct Shelter {
    /// Share of the sky's light that arrives, 0…1.
    pub openness: Image<R32f>,
    /// How much of the open sea's waves arrives, 0…1.
    pub surf: Image<R32f>,
}

/// Most samples a side. What the images hold varies smoothly, so that more would cost much and show nothing.
const FINEST: u32 = 1024;

/// Samples a side over this grid.
pub fn side(grid: Grid) -> u32 {
    grid.cells.min(FINEST)
}

impl Shelter {
    /// On the device, bytes.
    pub fn bytes(grid: Grid) -> u64 {
        2 * 4 * u64::from(side(grid)).pow(2)
    }

    /// Nothing is measured yet: all is 0.
    ///
    /// # Errors
    /// No memory.
    pub fn new(gpu: &Gpu, grid: Grid) -> gpu::Result<Self> {
        let size = [side(grid); 2];
        Ok(Shelter { openness: Image::new(gpu, "openness", size)?, surf: Image::new(gpu, "surf", size)? })
    }
}

/// What measures it.
pub struct Passes {
    openness: Compute<openness::Shader>,
    surf: Compute<surf::Shader>,
}

impl Passes {
    /// # Errors
    /// What the device lacks or has no memory for.
    pub fn new(gpu: &Gpu) -> gpu::Result<Self> {
        Ok(Passes { openness: Compute::new(gpu, ())?, surf: Compute::new(gpu, ())? })
    }

    /// Measures it, now. `frame` is of this ground, through any camera.
    ///
    /// # Errors
    /// A lost device, or no memory.
    pub fn measure(&self, gpu: &Gpu, ground: &Ground, frame: &Buffer<Frame>) -> gpu::Result<Shelter> {
        let shelter = Shelter::new(gpu, ground.grid)?;
        let mut rec = Recorder::new(gpu);
        self.record(&mut rec, ground, frame, &shelter, 0..side(ground.grid));
        rec.submit()?.wait()?;
        Ok(shelter)
    }

    /// Records the measuring of some rows.
    pub fn record(
        &self,
        rec: &mut Recorder,
        ground: &Ground,
        frame: &Buffer<Frame>,
        shelter: &Shelter,
        rows: Range<u32>,
    ) {
        let cells = side(ground.grid);
        let (size, height) = ([cells, rows.len() as u32], &ground.height);
        let (cells, first) = (cells as i32, rows.start as i32);
        rec.concurrent(|rec| {
            let bindings = openness::Bindings { frame, height, openness: &shelter.openness };
            rec.dispatch(&self.openness, size, openness::Push { cells, first }, bindings);
            let bindings = surf::Bindings { frame, height, surf: &shelter.surf };
            rec.dispatch(&self.surf, size, surf::Push { cells, first }, bindings);
        });
    }
}
