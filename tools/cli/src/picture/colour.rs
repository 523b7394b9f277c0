use glam::Vec3;

/// A colour, linear light, one for full.
pub type Colour = Vec3;

/// The picture's bytes for a colour: clamped, then encoded as sRGB (IEC 61966-2-1).
pub fn encode(colour: Colour) -> [u8; 3] {
    colour.to_array().map(|x| (encode_channel(x) * 255.0 + 0.5) as u8)
}

fn encode_channel(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    // libm: the platform's own `powf` may differ in the last place, and with it a pixel.
    if x <= 0.003_130_8 {
        12.92 * x
    } else {
        1.055 * libm::powf(x, 1.0 / 2.4) - 0.055
    }
}

/// Linear light of an sRGB colour given as bytes.
pub fn decode(srgb: [u8; 3]) -> Colour {
    Colour::from_array(srgb.map(|byte| {
        let x = f32::from(byte) / 255.0;
        if x <= 0.040_45 {
            x / 12.92
        } else {
            libm::powf((x + 0.055) / 1.055, 2.4)
        }
    }))
}

/// A colour for the `index`-th of many things: neighbours in number differ clearly, and a number always has the same.
pub fn distinct(index: u32) -> Colour {
    // Steps of the golden angle never come close to an earlier hue for long; saturation and brightness cycle at other
    // periods to part those that do.
    let turns = (f64::from(index) * 0.618_033_988_749_894_9 + 0.03).fract() as f32;
    let saturation = [0.62, 0.85, 0.45][index as usize % 3];
    let value = [0.92, 0.72, 0.98, 0.82][index as usize % 4];
    let channel = |shift: f32| {
        let ramp = (((turns + shift).fract() * 6.0 - 3.0).abs() - 1.0).clamp(0.0, 1.0);
        value * (1.0 - saturation * (1.0 - ramp))
    };
    decode([channel(0.0), channel(2.0 / 3.0), channel(1.0 / 3.0)].map(|x| (x * 255.0) as u8))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_survive_decoding_and_encoding() {
        for byte in 0..=255 {
            assert_eq!(encode(decode([byte; 3])), [byte; 3]);
        }
        assert_eq!(encode(Colour::new(-1.0, 2.0, f32::NAN)), [0, 255, 0]);
    }

    #[test]
    fn sixty_four_things_get_sixty_four_colours() {
        let mut colours: Vec<_> = (0..64).map(|i| encode(distinct(i))).collect();
        for (i, a) in colours.iter().enumerate() {
            for b in &colours[..i] {
                let apart: i32 = (0..3).map(|k| (i32::from(a[k]) - i32::from(b[k])).abs()).sum();
                assert!(apart >= 12, "{a:?} {b:?}");
            }
        }
        colours.sort_unstable();
        colours.dedup();
        assert_eq!(colours.len(), 64);
    }
}
