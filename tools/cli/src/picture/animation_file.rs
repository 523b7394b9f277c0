use super::palette::Palette;
use gif::{DisposalMethod, Encoder, EncodingError, Frame, Repeat};
use std::io::Write;

/// Place in the palette that means: what the frame before showed here.
const UNCHANGED: u8 = 255;

/// Shortest time that viewers show a frame for, in hundredths of a second; shorter ones are slowed down to a tenth.
const SHORTEST_DELAY: u64 = 2;

/// Writes an animated GIF that repeats for ever, one frame at a time.
pub struct AnimationFile<'a, W: Write> {
    encoder: Encoder<W>,
    palette: &'a Palette,
    width: u16,
    height: u16,
    before: Vec<u8>,
}

impl<'a, W: Write> AnimationFile<'a, W> {
    /// Begins the file.
    pub fn new(out: W, width: u16, height: u16, palette: &'a Palette) -> Result<Self, EncodingError> {
        let mut bytes = palette.colours().concat();
        bytes.resize(256 * 3, 0);
        let mut encoder = Encoder::new(out, width, height, &bytes)?;
        encoder.set_repeat(Repeat::Infinite)?;
        Ok(Self {
            encoder,
            palette,
            width,
            height,
            before: Vec::new(),
        })
    }

    /// Adds a frame of three bytes per pixel, shown for `delay` hundredths of a second. Only the rectangle that
    /// differs from the frame before is stored.
    pub fn add(&mut self, rgb: &[u8], delay: u16) -> Result<(), EncodingError> {
        let width = usize::from(self.width);
        let pixels = rgb.as_chunks::<3>().0;
        let now: Vec<u8> = pixels
            .iter()
            .enumerate()
            .map(|(i, pixel)| self.palette.index(*pixel, i % width, i / width))
            .collect();
        let mut frame = Frame {
            delay,
            dispose: DisposalMethod::Keep,
            ..Frame::default()
        };
        if self.before.is_empty() {
            (frame.width, frame.height) = (self.width, self.height);
            frame.buffer = now.as_slice().into();
        } else {
            let changed = |i: &usize| now[*i] != self.before[*i];
            let places = || (0..now.len()).filter(changed);
            // A frame without any change still takes its time: one pixel of it is stored.
            let (top, bottom) = (
                places().next().unwrap_or(0) / width,
                places().next_back().unwrap_or(0) / width,
            );
            let left = places().map(|i| i % width).min().unwrap_or(0);
            let right = places().map(|i| i % width).max().unwrap_or(0);
            let shown = |i: usize| if changed(&i) { now[i] } else { UNCHANGED };
            let cut: Vec<u8> = (top..=bottom)
                .flat_map(|y| (y * width + left..=y * width + right).map(shown))
                .collect();
            (frame.left, frame.top) = (left as u16, top as u16);
            (frame.width, frame.height) = ((right - left + 1) as u16, (bottom - top + 1) as u16);
            frame.transparent = Some(UNCHANGED);
            frame.buffer = cut.into();
        }
        self.encoder.write_frame(&frame)?;
        self.before = now;
        Ok(())
    }

    /// Ends the file.
    pub fn finish(self) -> Result<(), EncodingError> {
        // The encoder writes the trailer when it gives its writer back.
        Ok(self.encoder.into_inner()?.flush()?)
    }
}

/// How long each of `count` frames is shown, hundredths of a second, so that rounding does not add up over
/// `seconds` in all.
pub fn delays(count: u32, seconds: f64) -> Vec<u16> {
    let end = |frame: u32| (seconds.max(0.0) * 100.0 * f64::from(frame) / f64::from(count.max(1))).round() as u64;
    (0..count)
        .map(|frame| (end(frame + 1) - end(frame)).clamp(SHORTEST_DELAY, u16::MAX.into()) as u16)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::palette::ColourCount;
    use image::AnimationDecoder;

    #[test]
    fn delays_add_up_to_the_whole() {
        assert_eq!(delays(3, 1.0), [33, 34, 33]);
        assert_eq!(delays(24, 0.708).iter().map(|d| u32::from(*d)).sum::<u32>(), 71);
        assert_eq!(delays(4, 0.0), [2; 4]);
        assert_eq!(delays(1, 1e9), [u16::MAX]);
        assert!(delays(0, 1.0).is_empty());
    }

    #[test]
    fn frames_come_back_as_they_were_written() {
        let (width, height) = (20usize, 12usize);
        let frames: Vec<Vec<u8>> = (0..4)
            .map(|f: usize| {
                let pixel = |i: usize| {
                    let inside = (i % width).abs_diff(4 + 3 * (f / 2)) < 3 && (i / width).abs_diff(5) < 2;
                    if inside { [250, 120, 10] } else { [20, 40, 200] }
                };
                (0..width * height).flat_map(pixel).collect()
            })
            .collect();
        let mut count = ColourCount::new();
        frames.iter().for_each(|frame| count.add(frame));
        let palette = count.palette();
        let mut bytes = Vec::new();
        let mut file = AnimationFile::new(&mut bytes, 20, 12, &palette).expect("a buffer takes all");
        frames
            .iter()
            .for_each(|frame| file.add(frame, 7).expect("a buffer takes all"));
        file.finish().expect("a buffer takes all");

        let decoder = image::codecs::gif::GifDecoder::new(std::io::Cursor::new(&bytes)).expect("a GIF");
        let read = decoder.into_frames().collect_frames().expect("whole frames");
        assert_eq!(read.len(), 4);
        for (read, written) in read.iter().zip(&frames) {
            assert_eq!(read.delay().numer_denom_ms(), (70, 1));
            let rgb: Vec<u8> = read.buffer().pixels().flat_map(|p| [p[0], p[1], p[2]]).collect();
            assert_eq!(&rgb, written);
        }
    }
}
