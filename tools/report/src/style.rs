//! Sizes and colours that all figures share.

use plotters::style::RGBColor;

/// Width of every figure (pixels).
pub(crate) const WIDTH_PX: u32 = 920;
/// Margin on the right of a plot, wide enough for half of the last tick label (pixels).
pub(crate) const RIGHT_MARGIN_PX: u32 = 32;
/// Font size (pixels; the drawing library renders text a fifth smaller).
pub(crate) const FONT_PX: u32 = 16;
/// Upper bound of the average width of a letter (pixels).
const LETTER_PX: u32 = 8;
/// Colours that remain distinct in print and for the colour-blind (Okabe and Ito, 2008).
pub(crate) const COLOURS: [RGBColor; 6] = [
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x00, 0x9e, 0x73),
    RGBColor(0xcc, 0x79, 0xa7),
    RGBColor(0x56, 0xb4, 0xe9),
    RGBColor(0x33, 0x33, 0x33),
];

/// Upper bound of the width of a text (pixels).
pub(crate) fn text_width_px(text: &str) -> u32 {
    u32::try_from(text.chars().count()).map_or(WIDTH_PX, |letters| letters * LETTER_PX)
}
