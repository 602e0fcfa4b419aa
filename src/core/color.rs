//! Colour: CIE XYZ, linear Rec.709 and sRGB, and the curve from scene to screen.

/// Linear Rec.709 (D65) of CIE XYZ (IEC 61966-2-1).
pub fn rec709_from_xyz([x, y, z]: [f64; 3]) -> [f64; 3] {
    [
        3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
        -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
        0.0556434 * x - 0.2040259 * y + 1.0572252 * z,
    ]
}

/// CIE XYZ of a luminance and a chromaticity. A chromaticity without `y` has no colour: black.
pub fn xyz_from_luminance(luminance: f64, [x, y]: [f64; 2]) -> [f64; 3] {
    if y == 0.0 {
        return [0.0; 3];
    }
    [x / y * luminance, luminance, (1.0 - x - y) / y * luminance]
}

/// Luminance of linear Rec.709.
pub fn luminance([r, g, b]: [f32; 3]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// The sRGB transfer curve: linear 0…1 to encoded 0…1; clamps (IEC 61966-2-1).
pub fn srgb_from_linear(linear: f32) -> f32 {
    let linear = linear.clamp(0.0, 1.0);
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The inverse of [`srgb_from_linear`].
pub fn linear_from_srgb(encoded: f32) -> f32 {
    let encoded = encoded.clamp(0.0, 1.0);
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// The nearest 8-bit sRGB value of a linear channel.
pub fn srgb8_from_linear(linear: f32) -> u8 {
    (srgb_from_linear(linear) * 255.0).round() as u8
}

/// Scene-linear Rec.709 (1 = the film's white) to screen-linear 0…1, with a filmic toe and shoulder.
///
/// Each channel runs through Lottes's curve ("Advanced Techniques and Optimization of HDR Color
/// Pipelines", GDC 2016), `x^a / (b·x^a + c)`, which keeps middle grey where it is and reaches 1 at
/// [`WHITE`]. As in Sobotka's AgX the channels are drawn together before the curve and apart again
/// after it, so that bright colours turn paler instead of changing hue where single channels clip.
pub fn filmic(rgb: [f32; 3]) -> [f32; 3] {
    let drawn_in = desaturate(rgb, INSET);
    let curved = drawn_in.map(filmic_curve);
    desaturate(curved, -INSET / (1.0 - INSET)).map(|channel| channel.clamp(0.0, 1.0))
}

/// The scene value that becomes white, in units of the film's white.
const WHITE: f32 = 6.0;
const MIDDLE_GREY: f32 = 0.18;
/// Slope of the curve at middle grey in log-log scale.
const CONTRAST: f32 = 1.25;
/// How far channels are drawn towards the luminance before the curve.
const INSET: f32 = 0.12;

fn filmic_curve(x: f32) -> f32 {
    // b and c from f(grey) = grey and f(white) = 1.
    let grey = MIDDLE_GREY.powf(CONTRAST);
    let white = WHITE.powf(CONTRAST);
    let b = (grey / MIDDLE_GREY - white) / (grey - white);
    let c = white - b * white;
    let x = x.max(0.0).powf(CONTRAST);
    x / (b * x + c)
}

/// Moves every channel by `amount` of its distance towards the luminance.
fn desaturate(rgb: [f32; 3], amount: f32) -> [f32; 3] {
    let grey = luminance(rgb);
    rgb.map(|channel| channel + (grey - channel) * amount)
}
