//! What a zoom takes.

use super::{Arguments, Parts};
use crate::app::cli::output::print;
use crate::app::memory::{Limits, check_picture, check_zoom, of_zoom};
use crate::app::report::Details;
use crate::app::{Error, Session, land};
use crate::core::memory::total;
use crate::world::{Renderer, World, Zoom};
use crate::zoom::{address::Location, height::Spine, motion::Flight};
use serde_json::json;

/// Tells what it takes, and refuses what does not fit.
pub fn check(arguments: &Arguments, world: &World, zoom: &Zoom, session: &mut Session) -> Result<(), Error> {
    let (settings, film, sky) = (zoom.settings(&world.film, world.fov), &world.film, &world.light.sky);
    let mut limits = Limits::of_option(arguments.device.memory_limit);
    if arguments.device.device.is_some() {
        limits = Limits::of(&land::open(&arguments.device, session)?);
    }
    let possible = match world.renderer {
        Renderer::Trace => Err(Error::Missing("render.renderer = \"trace\": a zoom is rasterised".into())),
        Renderer::Raster => check_picture(film)
            .and_then(|()| check_zoom(&settings, film, sky, &limits))
            .and_then(|()| check_place(world, zoom)),
    };
    let parts = of_zoom(&settings, film, sky);
    let memory: Vec<_> = parts.iter().map(|part| json!({ "name": part.name, "bytes": part.bytes })).collect();
    let side = 1u32 << settings.bits;
    session.report.details = Some(Details::Plan(json!({
        "zoom": {
            "depth": zoom.depth,
            "from": zoom.from.as_ref().map(Location::code),
            "levels_per_frame": zoom.levels_per_frame,
            "tiles": settings.slots,
            "tile_side": side,
            "detail": settings.detail.sides(),
            "visibility": settings.octaves,
        },
        "picture": { "width": film.width, "height": film.height },
        "memory": memory,
        "memory_bytes": total(&parts),
    })));
    if !arguments.output.quiet && !arguments.output.json {
        let start = match &zoom.from {
            Some(location) => format!("a place at level {} upwards", location.level),
            None => format!("depth {} downwards", zoom.depth),
        };
        let text = format!(
            "{}, seed {}\n\
             zoom     from {start}, {} levels a frame\n\
             tiles    {} of {side} × {side} quads, {} octaves far, split if nearer than {} sides\n\
             picture  {} × {} pixels\n\
             memory   on the device, {}\n",
            world.name,
            world.seed,
            zoom.levels_per_frame,
            settings.slots,
            settings.octaves,
            settings.detail.sides(),
            film.width,
            film.height,
            Parts(&parts)
        );
        print(text.as_bytes())?;
    }
    possible
}

/// Refuses a place below the surface.
fn check_place(world: &World, zoom: &Zoom) -> Result<(), Error> {
    let Some(location) = &zoom.from else { return Ok(()) };
    let mut spine = Spine::new(zoom.surface(world.seed));
    let flight = Flight::new(&mut spine, location.place.clone(), location.level);
    flight.map(drop).map_err(|error| Error::Missing(format!("zoom.from: {error}")))
}
