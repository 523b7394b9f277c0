//! One palette of 255 colours for a whole animation, so that colours do not flicker from frame to frame.
//!
//! Based on: Heckbert, "Color Image Quantization for Frame Buffer Display" (SIGGRAPH 1982), for the idea of cutting the
//! box of all colours in two until there are enough. Differs: the box with the largest squared error is cut, at its
//! mean; frequent colours count by the square root of their number, so that a large background does not take all.

use rayon::prelude::*;

/// Colours are told apart by this many bits per channel.
const CELL_BITS: u32 = 6;
const CELLS: usize = 1 << (3 * CELL_BITS);
/// Colours in the palette; place 255 stays free to mean "as before".
pub const MAX_COLOURS: usize = 255;

/// Width of the pattern that hides the steps between palette colours, in steps of a byte.
const DITHER_SPREAD: i32 = 10;

/// Counts the colours of pictures.
pub struct ColourCount {
    cells: Vec<Cell>,
}

#[derive(Clone, Copy, Default)]
struct Cell {
    count: u64,
    sum: [u64; 3],
}

impl ColourCount {
    /// Nothing counted yet.
    pub fn new() -> Self {
        Self {
            cells: vec![Cell::default(); CELLS],
        }
    }

    /// Counts a picture of three bytes per pixel.
    pub fn add(&mut self, rgb: &[u8]) {
        for pixel in rgb.as_chunks().0 {
            let cell = &mut self.cells[cell_index(*pixel)];
            cell.count += 1;
            (0..3).for_each(|k| cell.sum[k] += u64::from(pixel[k]));
        }
    }

    /// The palette that shows the counted colours best.
    pub fn palette(&self) -> Palette {
        let mut points: Vec<Point> = self
            .cells
            .iter()
            .filter(|cell| cell.count > 0)
            .map(Point::new)
            .collect();
        let whole = Group::new(0, &points);
        let mut groups = vec![whole];
        while groups.len() < MAX_COLOURS {
            // The first of equals: the outcome does not depend on anything but the colours.
            let widest = (0..groups.len())
                .rev()
                .max_by(|a, b| groups[*a].error.total_cmp(&groups[*b].error));
            let Some(chosen) = widest.filter(|chosen| groups[*chosen].error > 0.0) else {
                break;
            };
            let group = groups.swap_remove(chosen);
            let members = &mut points[group.first..group.first + group.len];
            members.sort_by(|a, b| a.colour[group.axis].total_cmp(&b.colour[group.axis]));
            let below = members.partition_point(|point| point.colour[group.axis] <= group.mean[group.axis]);
            // Rounding may put the mean outside; a group with an error has at least two members, so both sides get one.
            let below = below.clamp(1, members.len() - 1);
            let (left, right) = members.split_at(below);
            let (left, right) = (Group::new(group.first, left), Group::new(group.first + below, right));
            groups.extend([left, right]);
        }
        let mut colours: Vec<[u8; 3]> = groups.iter().map(|group| group.mean.map(|x| (x + 0.5) as u8)).collect();
        colours.sort_unstable();
        colours.dedup();
        Palette::new(colours)
    }
}

struct Point {
    colour: [f64; 3],
    weight: f64,
}

impl Point {
    fn new(cell: &Cell) -> Self {
        let count = cell.count as f64;
        Self {
            colour: cell.sum.map(|sum| sum as f64 / count),
            weight: count.sqrt(),
        }
    }
}

/// Neighbouring colours that get one place in the palette.
struct Group {
    first: usize,
    len: usize,
    mean: [f64; 3],
    /// Weighted squared distance from the mean.
    error: f64,
    /// Channel with the largest share of the error.
    axis: usize,
}

impl Group {
    fn new(first: usize, points: &[Point]) -> Self {
        let weight: f64 = points.iter().map(|point| point.weight).sum();
        let mean = std::array::from_fn(|k| {
            points.iter().map(|point| point.colour[k] * point.weight).sum::<f64>() / weight.max(1.0)
        });
        let errors: [f64; 3] = std::array::from_fn(|k| {
            points
                .iter()
                .map(|point| (point.colour[k] - mean[k]).powi(2) * point.weight)
                .sum()
        });
        let axis = (0..3)
            .rev()
            .max_by(|a, b| errors[*a].total_cmp(&errors[*b]))
            .unwrap_or(0);
        let error = if points.len() < 2 { 0.0 } else { errors.iter().sum() };
        Self {
            first,
            len: points.len(),
            mean,
            error,
            axis,
        }
    }
}

/// Up to 255 colours, and the nearest of them for every colour.
pub struct Palette {
    colours: Vec<[u8; 3]>,
    nearest: Vec<u8>,
}

impl Palette {
    fn new(mut colours: Vec<[u8; 3]>) -> Self {
        colours.truncate(MAX_COLOURS);
        let nearest = (0..CELLS)
            .into_par_iter()
            .map(|cell| {
                let middle = cell_middle(cell);
                let distance =
                    |colour: &[u8; 3]| -> i32 { (0..3).map(|k| (i32::from(colour[k]) - middle[k]).pow(2)).sum() };
                (0..colours.len()).min_by_key(|i| distance(&colours[*i])).unwrap_or(0) as u8
            })
            .collect();
        Self { colours, nearest }
    }

    /// The colours; entry 255 is not among them.
    pub fn colours(&self) -> &[[u8; 3]] {
        &self.colours
    }

    /// Number of the palette colour for a pixel. A fixed pattern over the picture mixes neighbouring colours.
    pub fn index(&self, pixel: [u8; 3], x: usize, y: usize) -> u8 {
        let shift = (threshold(x, y) * 2 - 63) * DITHER_SPREAD / 128;
        let shifted = pixel.map(|byte| (i32::from(byte) + shift).clamp(0, 255) as u8);
        self.nearest[cell_index(shifted)]
    }
}

fn cell_index(pixel: [u8; 3]) -> usize {
    pixel.iter().fold(0, |index, byte| {
        index << CELL_BITS | usize::from(byte >> (8 - CELL_BITS))
    })
}

fn cell_middle(cell: usize) -> [i32; 3] {
    let side = 1 << (8 - CELL_BITS);
    [2, 1, 0].map(|k: u32| {
        let step = (cell >> (k * CELL_BITS)) & ((1 << CELL_BITS) - 1);
        step as i32 * side + side / 2
    })
}

/// 0 to 63, spread evenly over every 8 × 8 pixels: the bits of x ⊕ y and y, interleaved, the lowest bits first
/// (Bayer's matrix).
fn threshold(x: usize, y: usize) -> i32 {
    (0..3).fold(0, |value, bit| value << 2 | ((x ^ y) >> bit & 1) << 1 | (y >> bit & 1)) as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_dither_pattern_holds_every_value_once() {
        let mut values: Vec<i32> = (0..8).flat_map(|y| (0..8).map(move |x| threshold(x, y))).collect();
        values.sort_unstable();
        assert_eq!(values, (0..64).collect::<Vec<_>>());
    }

    #[test]
    fn few_colours_are_kept_apart() {
        let shown = [[0, 0, 0], [255, 0, 0], [0, 128, 255], [200, 200, 200]];
        let mut count = ColourCount::new();
        count.add(&shown.concat());
        let palette = count.palette();
        assert_eq!(palette.colours().len(), 4);
        for colour in shown {
            assert_eq!(palette.colours()[usize::from(palette.index(colour, 3, 5))], colour);
        }
    }

    #[test]
    fn a_ramp_is_shown_closely_on_average() {
        let ramp: Vec<[u8; 3]> = (0..64u32 * 256)
            .map(|i| [(i % 256) as u8, (i / 64 % 256) as u8, 90])
            .collect();
        let mut count = ColourCount::new();
        count.add(&ramp.concat());
        let palette = count.palette();
        assert!(palette.colours().len() > 200 && palette.colours().len() <= MAX_COLOURS);
        let worst = ramp.iter().enumerate().map(|(i, colour)| {
            let shown = palette.colours()[usize::from(palette.index(*colour, i % 256, i / 256))];
            (0..3)
                .map(|k| (i32::from(shown[k]) - i32::from(colour[k])).abs())
                .max()
                .unwrap_or(0)
        });
        // 255 colours for a 256 × 256 plane are 16 apart; half of that, the dither and the cell add up to this.
        assert!(worst.max().is_some_and(|worst| worst <= 24));
    }

    #[test]
    fn no_picture_gives_a_palette_that_can_be_asked() {
        assert_eq!(ColourCount::new().palette().index([1, 2, 3], 0, 0), 0);
    }
}
