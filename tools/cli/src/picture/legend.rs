use super::{canvas::Canvas, colour::Colour, heat_map::heat, lettering};

/// Draws the heat map's scale into the lower left corner: the ramp, its two ends, and what is counted.
pub fn draw(canvas: &mut Canvas, scale_end: u32) {
    const CAPTION: &str = "steps + tests per ray";
    let dot = (canvas.height / 256)
        .max(1)
        .min((canvas.width / (lettering::width(CAPTION) + 8)).max(1));
    let (margin, line) = (4 * dot, (lettering::LINE_HEIGHT + 3) * dot);
    let bar_width = lettering::width(CAPTION) * dot;
    let top = canvas.height.saturating_sub(margin + 2 * line + 6 * dot);
    lettering::draw(canvas, CAPTION, margin, top, dot, Colour::ONE);
    for x in 0..bar_width {
        let colour = heat(x as f32 / (bar_width.max(2) - 1) as f32);
        canvas.fill(margin + x, top + line, 1, 6 * dot, colour);
    }
    let (end, labels) = (scale_end.to_string(), top + line + 8 * dot);
    lettering::draw(canvas, "0", margin, labels, dot, Colour::ONE);
    let right = margin + bar_width.saturating_sub(lettering::width(&end) * dot);
    lettering::draw(canvas, &end, right, labels, dot, Colour::ONE);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_legend_shows_the_whole_ramp_and_stays_in_the_corner() {
        let mut canvas = Canvas::filled(256, 256, Colour::ZERO);
        draw(&mut canvas, 200);
        let painted: Vec<(u32, u32)> = (0..256)
            .flat_map(|y| (0..256).map(move |x| (x, y)))
            .filter(|(x, y)| canvas.colour(*x, *y) != Colour::ZERO)
            .collect();
        assert!(painted.iter().all(|(x, y)| *x < 160 && *y > 200));
        for share in [0.0, 1.0] {
            assert!(painted.iter().any(|(x, y)| canvas.colour(*x, *y) == heat(share)));
        }
    }

    #[test]
    fn the_smallest_picture_has_room_enough_not_to_fail() {
        let mut canvas = Canvas::filled(16, 16, Colour::ZERO);
        draw(&mut canvas, 1_000_000_000);
    }
}
