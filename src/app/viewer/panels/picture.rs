//! How light becomes colours: exposure in stops, and the tone map. What is changed is the world's.

use super::super::document::Document;
use super::parameters::{self, Wishes};
use crate::world::schema::digits;
use crate::world::{Edit, KeyPath, World};
use egui::{RichText, Slider, SliderClamping, Ui};

/// The exposure that a world had when it was opened, which stops are counted from.
#[derive(Clone, Copy, Debug, Default)]
pub struct Exposure(f32);

/// Stops to each side of it that the slider has; more can be typed.
const STOPS: f64 = 6.0;

impl Exposure {
    pub fn of(world: &World) -> Exposure {
        Exposure(world.film.exposure)
    }

    /// How often a world's exposure is twice that.
    fn stops(self, world: &World) -> f64 {
        f64::from(world.film.exposure / self.0).log2()
    }

    /// As a world has it after so many stops: with four digits, but exactly as it was after none.
    fn after(self, stops: f64) -> f64 {
        let exposure = f64::from(self.0) * stops.exp2();
        format!("{exposure:.3e}").parse().unwrap_or(exposure)
    }
}

/// The panel; returns what is to be changed.
pub fn show(ui: &mut Ui, document: &Document, exposure: Exposure) -> Wishes {
    let path = KeyPath::from("render.exposure");
    let world = document.world();
    let mut stops = exposure.stops(world);
    let mut edit = None;
    ui.horizontal(|ui| {
        let hover = format!("Exposure: {} per cd/m² now", digits(exposure.after(stops)));
        let slider = Slider::new(&mut stops, -STOPS..=STOPS)
            .clamping(SliderClamping::Never)
            .custom_formatter(|stops, _| format!("{stops:+.2}"))
            .custom_parser(|text| text.trim().parse().ok())
            .suffix(" stops");
        let slider = ui.add(slider).on_hover_text(hover);
        parameters::call(ui, &slider, "exposure in stops");
        if slider.changed() && stops.is_finite() {
            edit = Some(exposure.after(stops));
        }
        let as_it_was = ui.add_enabled(stops.abs() > 1e-3, egui::Button::new("0").small());
        if as_it_was.on_hover_text("As it was when the world was opened").clicked() {
            edit = Some(exposure.after(0.0));
        }
    });
    let mut wishes = parameters::rows(ui, document, "render", &["tone_map"]);
    let value = edit.and_then(|exposure| digits(exposure).parse().ok());
    wishes.edits.extend(value.map(|value| Edit::Set(path, value)));
    ui.label(RichText::new("These are keys of the world, below `render`.").weak().small());
    wishes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::{self, Overrides};
    use std::path::Path;

    fn world(exposure: &str) -> World {
        let text = format!("format = 1\n[render]\nexposure = {exposure}\n");
        world::parse("w.toml", text.as_bytes(), Path::new(""), &Overrides::default()).expect("a world")
    }

    #[test]
    fn stops_are_counted_from_what_was_opened() {
        let opened = Exposure::of(&world("3e-5"));
        assert_eq!(opened.stops(&world("3e-5")), 0.0);
        assert!((opened.stops(&world("2.4e-4")) - 3.0).abs() < 1e-6);
        assert_eq!(opened.after(0.0), 3e-5);
        assert_eq!(opened.after(-2.0), 7.5e-6);
        for stops in [-5.3, -0.01, 0.25, 4.9] {
            let exposure = digits(opened.after(stops));
            assert!((opened.stops(&world(&exposure)) - stops).abs() < 1e-3, "{stops}: {exposure}");
        }
    }
}
