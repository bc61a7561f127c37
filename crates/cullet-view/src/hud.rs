//! Text over a picture, in the 8 x 8 letters of old home computers, twice as high as wide.

use font8x8::legacy::{BASIC_LEGACY, NOTHING_TO_DISPLAY};

use crate::overlay::Canvas;

/// Text in one colour (0RGB).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Span {
    /// 0RGB.
    pub color: u32,
    /// ASCII; other characters show as `?`.
    pub text: String,
}

/// One line of text.
pub type Line = Vec<Span>;

/// The ordinary colour of text.
pub const WHITE: u32 = 0xf0_f0f0;

/// The colour of text that matters less.
pub const GREY: u32 = 0xa0_a8b0;

/// How much a panel covers of what is under it.
const PANEL_OPACITY: f64 = 0.8;

/// A piece of a line.
pub fn span(color: u32, text: impl Into<String>) -> Span {
    Span { color, text: text.into() }
}

/// Width of one pixel of a letter on a picture this high, px; it is twice as high.
pub fn scale(height: usize) -> usize {
    1 + height / 1400
}

/// Width and height of a panel, px.
pub fn size(lines: &[Line], scale: usize) -> (usize, usize) {
    let letters = |line: &Line| line.iter().map(|span| span.text.chars().count()).sum::<usize>();
    let longest = lines.iter().map(letters).max().unwrap_or(0);
    ((longest * 8 + 16) * scale, (lines.len() * 18 + 14) * scale)
}

/// Writes `lines` on a darkened panel whose left upper corner is at `x`, `y`. What does not fit is
/// cut off.
pub fn panel(canvas: &mut Canvas<'_>, x: usize, y: usize, lines: &[Line]) {
    let scale = scale(canvas.height);
    let (width, height) = size(lines, scale);
    for y in y..(y + height).min(canvas.height) {
        for x in x..(x + width).min(canvas.width) {
            canvas.blend(x, y, 0x10_1418, PANEL_OPACITY);
        }
    }
    for (i, line) in lines.iter().enumerate() {
        let (mut x, y) = (x + 8 * scale, y + (8 + 18 * i) * scale);
        for span in line {
            for c in span.text.chars() {
                letter(canvas, x, y, scale, span.color, c);
                x += 8 * scale;
            }
        }
    }
}

fn letter(canvas: &mut Canvas<'_>, x: usize, y: usize, scale: usize, color: u32, c: char) {
    let c = if c.is_ascii() { c } else { '?' };
    let rows = BASIC_LEGACY.get(c as usize).unwrap_or(&NOTHING_TO_DISPLAY);
    for (row, bits) in rows.iter().enumerate() {
        for column in (0..8).filter(|column| bits >> column & 1 != 0) {
            for i in 0..2 * scale * scale {
                let (x, y) = (x + column * scale + i % scale, y + 2 * row * scale + i / scale);
                canvas.blend(x, y, color, 1.0);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(width: usize, height: usize, draw: impl Fn(&mut Canvas<'_>)) -> Vec<u32> {
        let mut pixels = vec![0; width * height];
        draw(&mut Canvas { pixels: &mut pixels, width, height });
        pixels
    }

    #[test]
    fn a_letter_looks_like_itself() {
        let pixels = drawn(8, 16, |canvas| letter(canvas, 0, 0, 1, WHITE, 'F'));
        let mark = |&pixel: &u32| if pixel == 0 { '.' } else { '#' };
        let rows: Vec<String> =
            pixels.chunks(16).map(|r| r[8..].iter().map(mark).collect()).collect();
        let expected = [
            "#######.", ".##...#.", ".##.#...", ".####...", ".##.#...", ".##.....", "####....",
            "........",
        ];
        assert_eq!(rows, expected);
    }

    #[test]
    fn panels_are_cut_off_at_the_border() {
        let lines = [vec![span(WHITE, "any text \u{e9}\n\0")], vec![]];
        for (width, height) in [(1, 1), (40, 12), (300, 40), (2000, 1500)] {
            let pixels = drawn(width, height, |canvas| panel(canvas, 3, 2, &lines));
            assert_eq!(pixels[0], 0);
        }
        drawn(4, 4, |canvas| panel(canvas, 90, 90, &lines));
    }

    #[test]
    fn a_panel_holds_its_longest_line() {
        let lines = [vec![span(WHITE, "ab"), span(GREY, "c")], vec![span(WHITE, "d")]];
        assert_eq!(size(&lines, 2), (80, 100));
        assert_eq!(size(&[], 1), (16, 14));
    }
}
