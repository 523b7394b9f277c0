use super::colour::{Colour, encode};

/// A picture in the making: a colour and a depth per pixel, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Canvas {
    pub width: u32,
    pub height: u32,
    colours: Vec<Colour>,
    depths: Vec<f32>,
}

impl Canvas {
    /// A canvas of `width` columns with these pixels; whole rows only.
    pub fn new(width: u32, colours: Vec<Colour>, depths: Vec<f32>) -> Self {
        debug_assert!(colours.len() == depths.len() && colours.len().is_multiple_of(width as usize));
        let height = (colours.len() / width as usize) as u32;
        Self {
            width,
            height,
            colours,
            depths,
        }
    }

    /// A canvas of one colour, infinitely far away.
    #[cfg(test)]
    pub fn filled(width: u32, height: u32, colour: Colour) -> Self {
        let count = (width * height) as usize;
        Self::new(width, vec![colour; count], vec![f32::INFINITY; count])
    }

    /// The colour at a pixel.
    #[cfg(test)]
    pub fn colour(&self, x: u32, y: u32) -> Colour {
        self.colours[(y * self.width + x) as usize]
    }

    /// Depth of what a pixel shows, infinite where it shows nothing; `None` outside the picture.
    pub fn depth(&self, x: u32, y: u32) -> Option<f32> {
        self.index(x, y).and_then(|i| self.depths.get(i)).copied()
    }

    /// Lays `colour` over a pixel with a share of 0 to 1. Outside the picture nothing happens.
    pub fn blend(&mut self, x: u32, y: u32, colour: Colour, share: f32) {
        if let Some(pixel) = self.index(x, y).and_then(|i| self.colours.get_mut(i)) {
            *pixel = pixel.lerp(colour, share);
        }
    }

    /// Paints a rectangle, cut off at the picture's edges.
    pub fn fill(&mut self, left: u32, top: u32, width: u32, height: u32, colour: Colour) {
        for y in top..top.saturating_add(height).min(self.height) {
            for x in left..left.saturating_add(width).min(self.width) {
                self.blend(x, y, colour, 1.0);
            }
        }
    }

    /// Three bytes per pixel, sRGB, row by row from the top.
    pub fn to_rgb(&self) -> Vec<u8> {
        self.colours.iter().flat_map(|colour| encode(*colour)).collect()
    }

    fn index(&self, x: u32, y: u32) -> Option<usize> {
        (x < self.width && y < self.height).then(|| y as usize * self.width as usize + x as usize)
    }
}
