use super::{canvas::Canvas, colour::Colour};

/// Columns and rows of a letter.
const LETTER: (u32, u32) = (5, 7);

/// Height of a line of letters at scale one, pixels.
pub const LINE_HEIGHT: u32 = LETTER.1;

/// Width of `text` at scale one, pixels: a column is left free between letters.
pub fn width(text: &str) -> u32 {
    (text.chars().count() as u32 * (LETTER.0 + 1)).saturating_sub(1)
}

/// Draws `text` with its upper left corner at (`left`, `top`), each dot `scale` pixels wide. Letters that have no
/// picture are left blank.
pub fn draw(canvas: &mut Canvas, text: &str, left: u32, top: u32, scale: u32, colour: Colour) {
    for (place, letter) in (0u32..).zip(text.chars()) {
        for (row, bits) in (0u32..).zip(dots(letter)) {
            for column in (0..LETTER.0).filter(|column| bits >> (LETTER.0 - 1 - column) & 1 == 1) {
                let x = left + (place * (LETTER.0 + 1) + column) * scale;
                canvas.fill(x, top + row * scale, scale, scale, colour);
            }
        }
    }
}

/// Seven rows of five dots; the highest of the five bits is on the left.
fn dots(letter: char) -> [u8; 7] {
    match letter {
        '0' => [0b01110, 0b10001, 0b10011, 0b10101, 0b11001, 0b10001, 0b01110],
        '1' => [0b00100, 0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110],
        '2' => [0b01110, 0b10001, 0b00001, 0b00110, 0b01000, 0b10000, 0b11111],
        '3' => [0b01110, 0b10001, 0b00001, 0b00110, 0b00001, 0b10001, 0b01110],
        '4' => [0b00010, 0b00110, 0b01010, 0b10010, 0b11111, 0b00010, 0b00010],
        '5' => [0b11111, 0b10000, 0b11110, 0b00001, 0b00001, 0b10001, 0b01110],
        '6' => [0b00110, 0b01000, 0b10000, 0b11110, 0b10001, 0b10001, 0b01110],
        '7' => [0b11111, 0b00001, 0b00010, 0b00100, 0b01000, 0b01000, 0b01000],
        '8' => [0b01110, 0b10001, 0b10001, 0b01110, 0b10001, 0b10001, 0b01110],
        '9' => [0b01110, 0b10001, 0b10001, 0b01111, 0b00001, 0b00010, 0b01100],
        'a' => [0b00000, 0b00000, 0b01110, 0b00001, 0b01111, 0b10001, 0b01111],
        'e' => [0b00000, 0b00000, 0b01110, 0b10001, 0b11111, 0b10000, 0b01110],
        'p' => [0b00000, 0b00000, 0b11110, 0b10001, 0b11110, 0b10000, 0b10000],
        'r' => [0b00000, 0b00000, 0b10110, 0b11001, 0b10000, 0b10000, 0b10000],
        's' => [0b00000, 0b00000, 0b01111, 0b10000, 0b01110, 0b00001, 0b11110],
        't' => [0b01000, 0b01000, 0b11110, 0b01000, 0b01000, 0b01001, 0b00110],
        'y' => [0b00000, 0b00000, 0b10001, 0b10001, 0b01111, 0b00001, 0b01110],
        '+' => [0b00000, 0b00100, 0b00100, 0b11111, 0b00100, 0b00100, 0b00000],
        _ => [0; 7],
    }
}
