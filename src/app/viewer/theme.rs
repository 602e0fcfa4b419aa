//! How the viewer looks: quiet greys and one accent, dense panels. All sizes are in points, so that screens of any density show
//! the same.

use egui::epaint::Shadow;
use egui::style::{ScrollStyle, Selection, TextCursorStyle, WidgetVisuals, Widgets};
use egui::{Color32, CornerRadius, FontDefinitions, FontFamily, FontId, Margin, Stroke, Style, TextStyle, Theme, Visuals, vec2};

/// Behind text that can be edited.
const WELL: Color32 = Color32::from_rgb(0x12, 0x14, 0x16);
const PANEL: Color32 = Color32::from_rgb(0x1b, 0x1d, 0x20);
const WINDOW: Color32 = Color32::from_rgb(0x20, 0x23, 0x27);
const BUTTON: Color32 = Color32::from_rgb(0x2c, 0x30, 0x35);
const BUTTON_HOVERED: Color32 = Color32::from_rgb(0x38, 0x3d, 0x44);
const LINE: Color32 = Color32::from_rgb(0x33, 0x37, 0x3d);
pub const TEXT: Color32 = Color32::from_rgb(0xd5, 0xd9, 0xdd);
pub const WEAK_TEXT: Color32 = Color32::from_rgb(0x9d, 0xa5, 0xad);
const STRONG_TEXT: Color32 = Color32::from_rgb(0xf4, 0xf6, 0xf8);
/// A lagoon.
pub const ACCENT: Color32 = Color32::from_rgb(0x4f, 0xc3, 0xb0);
/// The accent behind text.
pub const ACCENT_FILL: Color32 = Color32::from_rgb(0x1d, 0x55, 0x4e);
pub const WARNING: Color32 = Color32::from_rgb(0xe5, 0xb5, 0x5a);
pub const ERROR: Color32 = Color32::from_rgb(0xff, 0x90, 0x80);

/// Height of a row of widgets, points.
pub const ROW: f32 = 20.0;

/// Lets everything that egui shows look so.
pub fn apply(context: &egui::Context) {
    context.set_fonts(fonts());
    context.set_theme(Theme::Dark);
    context.set_style_of(Theme::Dark, style());
}

/// Those that egui brings. Arrows and `⁻¹` are in the one of equal widths only.
fn fonts() -> FontDefinitions {
    let mut fonts = FontDefinitions::default();
    let equal = fonts.families.get(&FontFamily::Monospace).cloned().unwrap_or_default();
    let proportional = fonts.families.entry(FontFamily::Proportional).or_default();
    proportional.extend(equal.into_iter().filter(|name| !proportional.contains(name)).collect::<Vec<_>>());
    fonts
}

fn style() -> Style {
    let mut style = Style { visuals: visuals(), animation_time: 0.0, ..Style::default() };
    style.text_styles = [
        (TextStyle::Small, 11.0, FontFamily::Proportional),
        (TextStyle::Body, 13.0, FontFamily::Proportional),
        (TextStyle::Button, 13.0, FontFamily::Proportional),
        (TextStyle::Monospace, 12.0, FontFamily::Monospace),
        (TextStyle::Heading, 16.0, FontFamily::Proportional),
    ]
    .map(|(style, size, family)| (style, FontId::new(size, family)))
    .into();
    style.drag_value_text_style = TextStyle::Body;
    style.explanation_tooltips = false;

    let spacing = &mut style.spacing;
    spacing.item_spacing = vec2(6.0, 3.0);
    spacing.button_padding = vec2(6.0, 1.0);
    spacing.interact_size = vec2(36.0, ROW);
    spacing.window_margin = Margin::same(10);
    spacing.menu_margin = Margin::same(6);
    spacing.indent = 12.0;
    spacing.icon_width = 14.0;
    spacing.icon_width_inner = 8.0;
    spacing.combo_height = 320.0;
    spacing.tooltip_width = 320.0;
    spacing.scroll = ScrollStyle { bar_width: 6.0, ..ScrollStyle::solid() };
    style
}

fn visuals() -> Visuals {
    let round = CornerRadius::same(3);
    let widget = |fill: Color32, line: Color32, text: Color32| WidgetVisuals {
        bg_fill: fill,
        weak_bg_fill: fill,
        bg_stroke: Stroke::new(1.0, line),
        corner_radius: round,
        fg_stroke: Stroke::new(1.0, text),
        expansion: 0.0,
    };
    Visuals {
        widgets: Widgets {
            noninteractive: widget(PANEL, LINE, TEXT),
            inactive: widget(BUTTON, BUTTON, TEXT),
            hovered: widget(BUTTON_HOVERED, LINE, STRONG_TEXT),
            active: widget(BUTTON_HOVERED, ACCENT, STRONG_TEXT),
            open: widget(BUTTON_HOVERED, LINE, STRONG_TEXT),
        },
        selection: Selection { bg_fill: ACCENT_FILL, stroke: Stroke::new(1.0, ACCENT) },
        weak_text_color: Some(WEAK_TEXT),
        hyperlink_color: ACCENT,
        faint_bg_color: WINDOW,
        extreme_bg_color: WELL,
        text_edit_bg_color: Some(WELL),
        code_bg_color: WELL,
        warn_fg_color: WARNING,
        error_fg_color: ERROR,
        window_corner_radius: CornerRadius::same(6),
        window_fill: WINDOW,
        window_stroke: Stroke::new(1.0, LINE),
        window_shadow: Shadow { offset: [0, 6], blur: 18, spread: 0, color: Color32::from_black_alpha(110) },
        popup_shadow: Shadow { offset: [0, 3], blur: 8, spread: 0, color: Color32::from_black_alpha(110) },
        menu_corner_radius: CornerRadius::same(4),
        panel_fill: PANEL,
        text_cursor: TextCursorStyle { stroke: Stroke::new(1.5, ACCENT), blink: false, ..TextCursorStyle::default() },
        slider_trailing_fill: true,
        ..Visuals::dark()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of Web Content Accessibility Guidelines 2.1: from 1 to 21.
    fn contrast(a: Color32, b: Color32) -> f64 {
        let channel = |value: u8| {
            let value = f64::from(value) / 255.0;
            if value <= 0.03928 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
        };
        let luminance =
            |c: Color32| 0.2126 * channel(c.r()) + 0.7152 * channel(c.g()) + 0.0722 * channel(c.b());
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn all_text_can_be_read() {
        let visuals = visuals();
        let widgets = &visuals.widgets;
        for widget in [&widgets.noninteractive, &widgets.inactive, &widgets.hovered, &widgets.active] {
            assert!(contrast(widget.fg_stroke.color, widget.weak_bg_fill) >= 4.5);
        }
        for ground in [WELL, PANEL, WINDOW, BUTTON] {
            for text in [TEXT, WEAK_TEXT, STRONG_TEXT, ACCENT, WARNING, ERROR] {
                assert!(contrast(text, ground) >= 4.5, "{text:?} on {ground:?}: {}", contrast(text, ground));
            }
        }
        for text in [TEXT, STRONG_TEXT] {
            assert!(contrast(text, ACCENT_FILL) >= 4.5, "{}", contrast(text, ACCENT_FILL));
        }
        // The measure of the guidelines' own example: #767676 on white just passes.
        let grey = Color32::from_gray(0x76);
        assert!((4.5..4.6).contains(&contrast(grey, Color32::WHITE)));
    }
}
