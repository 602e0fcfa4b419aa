//! Sentences over the picture: what was done, what should be known, what failed.

use crate::app::viewer::theme;
use egui::{Color32, Context, Label, Rect, RichText, Sense, vec2};
use std::time::{Duration, Instant};

#[derive(Default)]
pub(super) struct Messages {
    shown: Vec<Message>,
}

struct Message {
    since: Instant,
    sentence: String,
    tone: Tone,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Tone {
    /// It goes after a while.
    Said,
    /// It stays until it is clicked away.
    Warned,
    /// Likewise.
    Failed,
}

/// How long a message can be read.
const TIME: Duration = Duration::from_secs(8);

/// The last ones are shown.
const MOST: usize = 5;

impl Messages {
    pub fn push(&mut self, sentence: String, tone: Tone) {
        // Said again it is no other message.
        self.shown.retain(|message| message.sentence != sentence);
        self.shown.push(Message { since: Instant::now(), sentence, tone });
    }

    pub fn clear(&mut self) {
        self.shown.clear();
    }

    /// Takes failures away that speak of what has been mended since.
    #[cfg_attr(not(feature = "reload"), expect(dead_code, reason = "only shaders are mended so"))]
    pub fn forget_failures(&mut self, is_mended: impl Fn(&str) -> bool) {
        self.shown.retain(|message| message.tone != Tone::Failed || !is_mended(&message.sentence));
    }

    /// Takes warnings away of what is no more.
    pub fn forget_warnings(&mut self, is_over: impl Fn(&str) -> bool) {
        self.shown.retain(|message| message.tone != Tone::Warned || !is_over(&message.sentence));
    }

    /// Whether one tells that something failed.
    pub fn tell_failure(&self) -> bool {
        self.shown.iter().any(|message| message.tone == Tone::Failed)
    }

    /// Shows them in the upper left corner of a place, above the picture, and below what asks or explains.
    pub fn show(&mut self, context: &Context, rect: Rect) {
        self.shown.retain(|message| message.tone != Tone::Said || message.since.elapsed() < TIME);
        while self.shown.len() > MOST {
            let first = [Tone::Said, Tone::Warned]
                .into_iter()
                .find_map(|tone| self.shown.iter().position(|message| message.tone == tone));
            self.shown.remove(first.unwrap_or(0));
        }
        if self.shown.is_empty() {
            return;
        }
        if self.shown.iter().any(|message| message.tone == Tone::Said) {
            context.request_repaint_after(Duration::from_millis(500));
        }
        let clicked = egui::Area::new("messages".into())
            .fixed_pos(rect.left_top() + vec2(12.0, 12.0))
            .order(egui::Order::Background)
            .show(context, |ui| {
                ui.set_max_width((rect.width() - 24.0).clamp(120.0, 560.0));
                let mut clicked = None;
                for (index, Message { sentence, tone, .. }) in self.shown.iter().enumerate() {
                    let colour = match tone {
                        Tone::Said => Color32::WHITE,
                        Tone::Warned => theme::WARNING,
                        Tone::Failed => theme::ERROR,
                    };
                    let label = Label::new(RichText::new(sentence).color(colour)).wrap();
                    egui::Frame::popup(ui.style()).show(ui, |ui| {
                        let label = ui.add(label.sense(Sense::click()));
                        if label.on_hover_text("Click, and it goes").clicked() {
                            clicked = Some(index);
                        }
                    });
                }
                clicked
            });
        if let Some(index) = clicked.inner {
            self.shown.remove(index);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_failed_stays_longest() {
        let mut messages = Messages::default();
        messages.push("failed".into(), Tone::Failed);
        messages.push("warned".into(), Tone::Warned);
        (0..4).for_each(|number| messages.push(format!("said {number}"), Tone::Said));
        messages.push("said 3".into(), Tone::Said);
        assert_eq!(messages.shown.len(), 6, "what is said again is there once");
        let context = Context::default();
        let mut show = || {
            let input = egui::RawInput::default();
            let _ = context.run_ui(input, |ui| messages.show(ui.ctx(), ui.max_rect()));
            messages.shown.iter().map(|message| message.sentence.clone()).collect::<Vec<_>>()
        };
        assert_eq!(show(), ["failed", "warned", "said 1", "said 2", "said 3"]);
        for message in &mut messages.shown {
            message.since -= TIME;
        }
        messages.show(&context, Rect::EVERYTHING);
        assert_eq!(messages.shown.len(), 2);
    }
}
