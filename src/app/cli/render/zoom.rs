//! Pictures of a zoom: one at a depth, or the frames of a flight.

use super::{Job, Shot};
use crate::app::{Error, Session, interrupt, land, report::Flown};
use crate::core::hash::derive_seed;
use crate::world::{Renderer, Zoom};
use crate::zoom::{
    background,
    height::Surface,
    motion::{Autopilot, Depth, Pose},
    tree::Detail,
    view::{self, Settings, View},
};
use std::path::PathBuf;

/// Side of the square of samples in a pixel.
const SAMPLES: u32 = 2;

/// Levels that a flight looks ahead.
const AHEAD: f64 = 7.0;

impl Job<'_> {
    /// Makes all pictures.
    pub(super) fn fly(&self, zoom: &Zoom, session: &mut Session) -> Result<(), Error> {
        if self.renderer == Renderer::Trace {
            return Err(Error::Usage("--renderer trace: a zoom is rasterised".into()));
        }
        if self.arguments.resume {
            return Err(Error::Usage("--resume: the frames of a zoom are made from the first one on".into()));
        }
        let gpu = land::open(&self.arguments.device, session)?;
        let surface = Surface {
            seed: derive_seed(self.world.seed, "zoom"),
            refinement: zoom.refinement,
            roughness: zoom.roughness,
        };
        let settings = Settings {
            bits: zoom.tile,
            detail: Detail::new(zoom.detail.into()),
            octaves: zoom.visibility,
            layers: Some(background::layers(zoom.visibility)),
            face: background::side(&self.film, SAMPLES, self.world.fov),
            slots: zoom.tiles,
            samples: SAMPLES,
        };
        let mut renderer = view::Renderer::new(&gpu, surface, settings, &self.world.light, &self.film)?;
        let mut autopilot = Autopilot::new(surface);
        for number in self.shots.clone() {
            let done = number - self.shots.start;
            session.progress.show("frames", done.into(), self.shots.len() as u64);
            interrupt::check(&session.report)?;
            let shot = self.shot(number);
            let depth = self.depth(zoom, &shot);
            let Pose { place, attitude } = autopilot.at(renderer.spine(), depth);
            let view = View { place, attitude, fov: self.world.fov, level: depth.whole() };
            self.look_ahead(&mut renderer, &mut autopilot, zoom, &shot)?;
            let view::Shot { picture, altitude, drawn, made, cpu, gpu, .. } = renderer.render(&view)?;
            let written = self.write(&shot, picture, session)?;
            match shot.frame {
                Some(frame) => {
                    let flown = Flown {
                        depth: altitude.depth(),
                        tiles_drawn: drawn,
                        tiles_made: made,
                        cpu_ms: 1e3 * cpu.as_secs_f64(),
                        gpu_ms: 1e3 * gpu.as_secs_f64(),
                    };
                    session.report.flown(frame, &written, flown);
                }
                None => session.report.wrote(&written),
            }
        }
        session.progress.show("frames", self.shots.len() as u64, self.shots.len() as u64);
        session.progress.end();
        Ok(())
    }

    /// Has the renderer work for a view some levels on.
    fn look_ahead(
        &self,
        renderer: &mut view::Renderer,
        autopilot: &mut Autopilot,
        zoom: &Zoom,
        shot: &Shot,
    ) -> Result<(), Error> {
        let Some(frame) = shot.frame else { return Ok(()) };
        let frames = (AHEAD / zoom.levels_per_frame.max(1e-3)) as u32;
        let frame = frame.saturating_add(frames).min(self.shots.end - 1);
        let depth = self.depth(zoom, &Shot { frame: Some(frame), path: PathBuf::new() });
        let Pose { place, attitude } = autopilot.at(renderer.spine(), depth);
        let view = View { place, attitude, fov: self.world.fov, level: depth.whole() };
        Ok(renderer.prepare(&view, frames as usize)?)
    }

    /// Of a picture by itself, or of a frame: on the way back, frame A + B − 1 − f is what f is on the way in.
    fn depth(&self, zoom: &Zoom, shot: &Shot) -> Depth {
        let frame = match (shot.frame, &self.arguments.frames) {
            (Some(frame), Some(frames)) if self.arguments.back => frames.start + frames.end - 1 - frame,
            (frame, _) => frame.unwrap_or(0),
        };
        // Both are finite and at most 10⁶ and 10⁹: this fits.
        Depth(((zoom.depth + f64::from(frame) * zoom.levels_per_frame) * 65_536.0) as u64)
    }
}

impl From<view::Error> for Error {
    fn from(error: view::Error) -> Error {
        match error {
            view::Error::Gpu(error) => Error::Gpu(error),
            view::Error::TooMany(_) | view::Error::Slots { .. } => Error::Missing(format!(
                "{error}; raise `zoom.tiles`, or lower `zoom.detail` or `zoom.visibility`"
            )),
            error => Error::Missing(error.to_string()),
        }
    }
}
