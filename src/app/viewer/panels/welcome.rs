//! The first page: worlds to begin with.

use super::super::shipped::{WORLDS, World};
use super::super::state::State;
use super::files::{self, Recent};
use egui::{
    Align, Color32, ColorImage, Context, Label, Layout, Rect, RichText, ScrollArea, Sense, TextureHandle, Ui,
    WidgetInfo, WidgetType, vec2,
};

/// What was clicked.
pub enum Choice {
    Shipped(&'static World),
    Recent(Recent),
    /// To look for a file.
    Open,
}

/// Small pictures of the worlds, on the device once they have been seen.
#[derive(Default)]
pub struct Welcome {
    pictures: Vec<Option<TextureHandle>>,
}

/// Size of a picture, points.
const PICTURE: [f32; 2] = [208.0, 117.0];

impl Welcome {
    pub fn show(&mut self, ui: &mut Ui, state: &State) -> Option<Choice> {
        let mut choice = None;
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            ui.add_space(18.0);
            ui.vertical_centered(|ui| {
                ui.label(RichText::new("terrane").size(34.0).strong());
                ui.label(RichText::new("Whole landscapes from one text file").weak());
            });
            ui.add_space(14.0);
            let columns = ((ui.available_width() - 24.0) / (PICTURE[0] + 14.0)).floor().max(1.0);
            let margin = ((ui.available_width() - columns * (PICTURE[0] + 14.0)) / 2.0).max(0.0);
            ui.horizontal(|ui| {
                ui.add_space(margin);
                ui.vertical(|ui| {
                    for (row, worlds) in WORLDS.chunks(columns as usize).enumerate() {
                        ui.horizontal(|ui| {
                            for (index, world) in worlds.iter().enumerate() {
                                let number = row * columns as usize + index;
                                if self.card(ui, number, world) {
                                    choice = Some(Choice::Shipped(world));
                                }
                            }
                        });
                        ui.add_space(8.0);
                    }
                    ui.horizontal(|ui| {
                        if ui.button("Open a file …").clicked() {
                            choice = Some(Choice::Open);
                        }
                    });
                    if state.recent().next().is_some() {
                        ui.add_space(10.0);
                        ui.strong("Open before");
                        if let Some(recent) = files::recent(ui, state) {
                            choice = Some(Choice::Recent(recent));
                        }
                    }
                });
            });
        });
        choice
    }

    /// A world's picture with its name; whether it was clicked.
    fn card(&mut self, ui: &mut Ui, number: usize, world: &World) -> bool {
        if self.pictures.len() <= number {
            self.pictures.resize(number + 1, None);
        }
        let picture = self.pictures[number].get_or_insert_with(|| load(ui.ctx(), world));
        let size = vec2(PICTURE[0] + 8.0, PICTURE[1] + 58.0);
        let (rect, response) = ui.allocate_exact_size(size, Sense::click());
        let name = format!("{} {}", world.kind, world.name.replace('_', " "));
        response.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, &name));
        let visuals = ui.style().interact(&response);
        ui.painter().rect(rect, 4.0, visuals.bg_fill, visuals.bg_stroke, egui::StrokeKind::Inside);
        let shown = Rect::from_min_size(rect.min + vec2(4.0, 4.0), vec2(PICTURE[0], PICTURE[1]));
        let whole = Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
        ui.painter().image(picture.id(), shown, whole, Color32::WHITE);
        let below = Rect::from_min_max(shown.left_bottom() + vec2(4.0, 4.0), rect.max - vec2(6.0, 2.0));
        let mut inner =
            ui.new_child(egui::UiBuilder::new().max_rect(below).layout(Layout::top_down(Align::Min)));
        inner.horizontal(|ui| {
            ui.add(label(RichText::new(world.name.replace('_', " ")).strong()));
            ui.add(label(RichText::new(world.kind).weak()));
        });
        inner.add(label(RichText::new(world.about).small()).wrap());
        response.on_hover_cursor(egui::CursorIcon::PointingHand).clicked()
    }
}

/// Text that leaves clicks to what it lies on.
fn label(text: RichText) -> Label {
    Label::new(text).selectable(false)
}

fn load(context: &Context, world: &World) -> TextureHandle {
    let image = crate::formats::png::read_small(world.picture).map_or_else(
        || ColorImage::filled([1, 1], Color32::DARK_GRAY),
        |(size, rgb)| ColorImage::from_rgb(size, &rgb),
    );
    context.load_texture(format!("{} {}", world.kind, world.name), image, egui::TextureOptions::LINEAR)
}
