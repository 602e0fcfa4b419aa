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

/// The 8-bit sRGB value of a linear channel: the next one below after adding `dither`, 0…1; ½ rounds.
pub fn srgb8_from_linear(linear: f32, dither: f32) -> u8 {
    (srgb_from_linear(linear) * 255.0 + dither) as u8
}

/// Scene-linear Rec.709 (1 = the film's white) to screen-linear 0…1, with a filmic toe and shoulder.
///
/// Each channel runs through Lottes's curve ("Advanced Techniques and Optimization of HDR Color
/// Pipelines", GDC 2016), `x^a / (b·x^a + c)`, which keeps middle grey where it is and reaches 1 at
/// white. As in Sobotka's AgX the channels are mixed before the curve and unmixed after it, so that
/// bright colours turn paler instead of changing hue where single channels clip.
pub fn filmic(rgb: [f32; 3]) -> [f32; 3] {
    let curved = transform(&MIX, rgb).map(filmic_curve);
    transform(&UNMIX, curved).map(|channel| channel.clamp(0.0, 1.0))
}

/// The scene value that becomes white, in units of the film's white.
const WHITE: f32 = 6.0;
const MIDDLE_GREY: f32 = 0.18;
/// Slope of the curve at middle grey in log-log scale.
const CONTRAST: f32 = 1.3;

/// Draws the channels together, blue towards cyan as it pales: paling along a straight line makes blue look
/// violet (the Abney effect). Rows sum to 1, which keeps greys grey.
const MIX: [[f32; 3]; 3] = [[0.88, 0.09, 0.03], [0.06, 0.80, 0.14], [0.04, 0.08, 0.88]];

/// Draws them apart again, by a little more than they were drawn together and without a turn of blue: the
/// inverse of `[[0.82, 0.12, 0.06], [0.09, 0.80, 0.11], [0.06, 0.12, 0.82]]`.
const UNMIX: [[f32; 3]; 3] =
    [[1.243808, -0.176471, -0.067337], [-0.130031, 1.294118, -0.164087], [-0.071981, -0.176471, 1.248452]];

fn filmic_curve(x: f32) -> f32 {
    // b and c from f(grey) = grey and f(white) = 1.
    let grey = MIDDLE_GREY.powf(CONTRAST);
    let white = WHITE.powf(CONTRAST);
    let b = (grey / MIDDLE_GREY - white) / (grey - white);
    let c = white - b * white;
    let x = x.max(0.0).powf(CONTRAST);
    x / (b * x + c)
}

fn transform(matrix: &[[f32; 3]; 3], [r, g, b]: [f32; 3]) -> [f32; 3] {
    matrix.map(|[from_r, from_g, from_b]| from_r * r + from_g * g + from_b * b)
}
