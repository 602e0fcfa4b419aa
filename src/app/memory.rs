//! Memory that a run takes, known and refused before it begins.

use super::Error;
use crate::core::memory::{Memory, mebibytes, total};
use crate::raster::{self, Quality};
use crate::scene::Film;
use crate::world::World;

/// Device memory of a run that ends in a picture, phase by phase: while the picture is drawn the land is there and the simulation gone.
pub struct Phases {
    pub land: Vec<Memory>,
    pub picture: Vec<Memory>,
}

impl Phases {
    pub fn of(world: &World, film: &Film) -> Self {
        let plan = &world.plan;
        let mut picture = vec![plan.land_memory()];
        picture.extend(raster::memory::picture(plan.grid, film, Quality::default()));
        Phases { land: plan.memory(), picture }
    }

    /// Refuses a phase that would pass the device's memory limit.
    pub fn check(&self, limit: u64) -> Result<(), Error> {
        check_device("the land", total(&self.land), "terrain.cells", limit)?;
        check_device("the picture", total(&self.picture), "terrain.cells or the picture's size", limit)
    }
}

/// Refuses `what` needs more device memory than there may be; `remedy` is what to lower.
pub fn check_device(what: &str, needed: u64, remedy: &str, limit: u64) -> Result<(), Error> {
    if needed <= limit {
        return Ok(());
    }
    Err(Error::Memory(format!(
        "{what} needs {} of device memory and {} may be used; lower {remedy}, or raise --memory-limit",
        mebibytes(needed),
        mebibytes(limit)
    )))
}

/// Refuses a picture that would take more than [`MOST_PICTURE`].
pub fn check_picture(film: &Film) -> Result<(), Error> {
    let needed = picture_bytes(film);
    if needed <= MOST_PICTURE {
        return Ok(());
    }
    Err(Error::Memory(format!(
        "a picture of {} × {} pixels takes {} of memory, and may take {}; make it smaller with --size or render.size",
        film.width,
        film.height,
        mebibytes(needed),
        mebibytes(MOST_PICTURE)
    )))
}

/// Most memory of the host, bytes, that a picture may take: some 178 million pixels.
const MOST_PICTURE: u64 = 3 << 30;

/// Floats, the screen's bytes, and these again while they are compressed.
fn picture_bytes(film: &Film) -> u64 {
    u64::from(film.width) * u64::from(film.height) * (12 + 3 + 3)
}
