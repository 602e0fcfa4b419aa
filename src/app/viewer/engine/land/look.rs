//! Drawing what is seen: swiftly while something moves, then better and better.

use super::Land;
use crate::app::Error;
use crate::app::viewer::engine::{Frame, News, Speaker, Studio};
use crate::core::camera::Pinhole;
use crate::core::pace::SLICE;
use crate::gpu::{Image, format::Rgba8};
use crate::raster::{self, Detail};
use std::time::{Duration, Instant};

/// Between two pictures while land changes.
const CHANGING: Duration = Duration::from_millis(60);

/// What a picture of what moves should take: it has as many texels as that allows.
const SWIFT: Duration = Duration::from_millis(70);

/// Fewest texels of such a picture for one of the window's pixels, along a side.
const COARSEST: f32 = 0.25;

/// How well what is seen has been drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Drawn {
    /// It shows what was.
    Not,
    /// As well as what moves can be.
    Swift,
    Once,
    /// With all samples.
    Well,
}

impl Drawn {
    fn next(self) -> Drawn {
        match self {
            Drawn::Not => Drawn::Swift,
            Drawn::Swift => Drawn::Once,
            Drawn::Once | Drawn::Well => Drawn::Well,
        }
    }
}

/// A picture under way.
pub(super) struct Drawing {
    pub target: Image<Rgba8>,
    pub camera: Pinhole,
    pub scale: f32,
    pub comes_to: Drawn,
    pub begun: Instant,
}

impl Land {
    /// Does a slice of what there is to do until what is seen is drawn well; whether there was anything.
    pub(super) fn look(
        &mut self,
        studio: &mut Studio,
        speaker: &Speaker,
        moves: bool,
    ) -> Result<bool, Error> {
        let stale = self.changed || self.drawn == Drawn::Not;
        // What is seen will be traced at once, and needs no better picture before.
        let traces = self.tracing && (self.gardener.is_none() || self.plants.is_some()) && !moves;
        // What moves is not drawn well; but what is drawn for it is, to the end, or nothing would ever be seen.
        if (stale || traces) && self.drawing.as_ref().is_some_and(|drawing| drawing.comes_to > Drawn::Swift) {
            self.drawing = None;
        }
        if let Some(drawing) = self.drawing.take() {
            // Where that fails there is nothing to show.
            if self.live.step(SLICE)? {
                self.drawing = Some(drawing);
                return Ok(true);
            }
            let Drawing { target, camera, scale, comes_to, begun } = drawing;
            if comes_to == Drawn::Swift {
                let texels = f64::from(target.size()[0]) * f64::from(target.size()[1]);
                self.seconds_a_texel = begun.elapsed().as_secs_f64() / texels;
            }
            studio.took(if comes_to == Drawn::Swift { "swift picture" } else { "picture" }, begun);
            speaker.say(News::Frame(Frame { image: target, scale, camera: Some(camera) }));
            self.trace.hide();
            // What moved meanwhile is not drawn yet.
            if self.drawn != Drawn::Not || comes_to == Drawn::Swift {
                self.drawn = comes_to;
            }
            let passes = self.live.timings().iter();
            studio.passes = passes.map(|pass| (pass.name, 1e3 * pass.duration.as_secs_f32())).collect();
            return Ok(true);
        }
        if stale && (!moves || self.begun.elapsed() >= CHANGING || !self.changed) {
            if std::mem::take(&mut self.changed) {
                self.trace.forget();
                let mut ground = self.live.scene().ground.clone();
                self.simulation.update(&mut ground)?;
                self.live.set_ground(ground)?;
                self.shown = None;
                self.outdated = true;
            }
            self.begin(studio, Drawn::Swift)?;
            return Ok(true);
        }
        if !traces && !self.live.is_lit() {
            let begun = Instant::now();
            if !self.live.relight(SLICE)? {
                // All that was drawn stands in the old light.
                self.drawn = Drawn::Not;
            }
            studio.took("light", begun);
            return Ok(true);
        }
        if !moves && !traces && self.drawn != Drawn::Well {
            self.begin(studio, self.drawn.next())?;
            return Ok(true);
        }
        Ok(false)
    }

    fn begin(&mut self, studio: &mut Studio, comes_to: Drawn) -> Result<(), Error> {
        let pixels = studio.size.map(f64::from);
        let scale = match comes_to {
            Drawn::Not | Drawn::Swift => {
                let affordable = SWIFT.as_secs_f64() / self.seconds_a_texel;
                ((affordable / (pixels[0] * pixels[1])).sqrt() as f32).clamp(COARSEST, 1.0)
            }
            Drawn::Once | Drawn::Well => 1.0,
        };
        let size = studio.size.map(|side| ((side as f32 * scale) as u32).max(1));
        let film = self.film(size);
        let overlay = self.overlay(&studio.gpu)?;
        let camera = self.camera(&film);
        let view = raster::View {
            camera,
            film,
            samples: if comes_to == Drawn::Well { 2 } else { 1 },
            detail: if comes_to > Drawn::Swift { Detail::Full } else { Detail::Swift },
            overlay,
        };
        let target = studio.image(size)?;
        let begun = Instant::now();
        self.live.begin(&view, &target)?;
        // What happens while it is drawn makes it stale again.
        if comes_to == Drawn::Swift {
            self.drawn = Drawn::Swift;
        }
        self.begun = begun;
        self.drawing = Some(Drawing { target, camera, scale, comes_to, begun });
        Ok(())
    }
}
