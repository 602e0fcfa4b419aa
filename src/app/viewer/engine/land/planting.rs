//! Plants on the land, and ground cover that follows the eye.

use super::{Land, look::Drawn};
use crate::app::Error;
use crate::app::population::Sight;
use crate::app::viewer::engine::plants::{Gardener, Planted, Plants};
use crate::app::viewer::engine::trace::REST;
use crate::app::viewer::engine::{News, Speaker, Studio};
use std::sync::Arc;

impl Land {
    /// Lets plants grow on the finished land, and takes them once they are there. Ground cover follows an eye that rests.
    pub(super) fn plant(&mut self, studio: &mut Studio, speaker: &Speaker, moves: bool) -> Result<(), Error> {
        let has_none = self.world.plants.rules.is_empty() && self.world.plants.standing.is_empty();
        if self.gardener.is_none() && (self.plants.is_some() || has_none) {
            self.plants.get_or_insert_default();
            return Ok(());
        }
        if self.gardener.is_none() {
            let gardener = Gardener::begin(&studio.gpu, &self.world, &self.simulation);
            self.gardener = Some(self.or_bare(gardener)?);
        }
        // What moves is drawn to the end.
        if self.drawing.as_ref().is_none_or(|drawing| drawing.comes_to > Drawn::Swift) {
            self.take_plants(studio, speaker)?;
        }
        let rests = !moves && self.moved.elapsed() >= REST;
        let bare = self.bare(studio).filter(|_| rests || self.plants.is_none());
        if let (Some(gardener), Some(sight)) = (&mut self.gardener, bare)
            && !gardener.is_busy()
        {
            gardener.ask(sight);
        }
        Ok(())
    }

    /// What is seen without its ground cover.
    pub(super) fn bare(&self, studio: &Studio) -> Option<Sight> {
        if self.plants.is_some() && !self.world.plants.follows_camera() {
            return None;
        }
        if self.tracing && self.plants.is_some() {
            let picture = Sight::Picture(self.written_camera(&self.film(studio.size)));
            let is_planted = self.pictured.as_ref().is_some_and(|(sight, _)| *sight == picture);
            return Some(picture).filter(|_| !is_planted);
        }
        let eye = self.rig.written().eye();
        Some(Sight::Round(eye)).filter(|round| self.covered != Some(*round))
    }

    /// Takes what has been planted.
    fn take_plants(&mut self, studio: &mut Studio, speaker: &Speaker) -> Result<(), Error> {
        let Some((sight, begun, planted)) = self.gardener.as_mut().and_then(Gardener::ended) else {
            return Ok(());
        };
        let is_first = self.plants.is_none();
        studio.took(if is_first { "planting" } else { "ground cover" }, begun);
        let Planted { plants, warnings } = match planted {
            Ok(planted) => planted,
            Err(error) if is_first => return self.or_bare(Err(error)),
            Err(error) => {
                // It would fail again.
                (self.covered, self.tracing) = (Some(sight), false);
                return Err(error);
            }
        };
        warnings.into_iter().for_each(|warning| speaker.say(News::Warned(warning)));
        if matches!(sight, Sight::Picture(_)) {
            self.pictured = Some((sight, plants.population));
            return Ok(());
        }
        self.covered = Some(sight);
        if !self.world.plants.follows_camera() {
            self.gardener = None;
        }
        // Far from all ground there is none to be seen, before and after.
        if !is_first && plants.population.instances == self.live.scene().population.instances {
            return Ok(());
        }
        self.live.set_population(plants.population.clone());
        self.selected = self.selected.take().and_then(|selected| plants.find(&selected)).map(Arc::new);
        self.plants = Some(plants);
        self.drawing = None;
        if is_first {
            self.trace.forget();
        }
        self.look_again();
        Ok(())
    }

    /// Whatever fails is not tried again: the land stays bare.
    pub(super) fn or_bare<T>(&mut self, result: Result<T, Error>) -> Result<T, Error> {
        if result.is_err() {
            (self.plants, self.gardener) = (Some(Plants::default()), None);
        }
        result
    }
}
