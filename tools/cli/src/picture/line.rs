use super::{camera::Projected, canvas::Canvas, colour::Colour};

/// Share with which a line shows through what stands before it.
const HIDDEN_SHARE: f32 = 0.22;

/// Draws a smooth-edged line of `thickness` pixels, faint where the picture is nearer than the line.
pub fn draw(canvas: &mut Canvas, from: Projected, to: Projected, thickness: f64, colour: Colour) {
    let margin = thickness + 1.0;
    let Some((from, to)) = cut_to_picture(from, to, canvas.width.into(), canvas.height.into(), margin) else {
        return;
    };
    let (dx, dy) = (to.x - from.x, to.y - from.y);
    let length = (dx * dx + dy * dy).sqrt();
    if length == 0.0 {
        return;
    }
    // Walk along the longer side; at each place paint the few pixels across that the line covers.
    let steep = dy.abs() > dx.abs();
    let (start, end, slope) = if steep {
        (from.y, to.y, dx / dy)
    } else {
        (from.x, to.x, dy / dx)
    };
    let (low, high) = (start.min(end) - thickness / 2.0, start.max(end) + thickness / 2.0);
    let reach = (thickness / 2.0 + 1.0) * length / dx.abs().max(dy.abs());
    for along in low.floor() as i64..=high.ceil() as i64 {
        let middle = along as f64 + 0.5;
        let across = (if steep { from.x } else { from.y }) + (middle - start) * slope;
        for other in (across - reach).floor() as i64..=(across + reach).floor() as i64 {
            let (x, y) = if steep { (other, along) } else { (along, other) };
            let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) else {
                continue;
            };
            let (px, py) = (f64::from(x) + 0.5 - from.x, f64::from(y) + 0.5 - from.y);
            let share = ((px * dx + py * dy) / (length * length)).clamp(0.0, 1.0);
            let (ex, ey) = (px - dx * share, py - dy * share);
            let cover = (thickness / 2.0 + 0.5 - (ex * ex + ey * ey).sqrt()).clamp(0.0, 1.0) as f32;
            let Some(depth) = canvas.depth(x, y).filter(|_| cover > 0.0) else {
                continue;
            };
            // The reciprocal of depth is what runs evenly along a line on the screen.
            let line_depth = 1.0 / (1.0 / from.depth * (1.0 - share) + 1.0 / to.depth * share);
            let visible = line_depth <= f64::from(depth);
            canvas.blend(x, y, colour, if visible { cover } else { cover * HIDDEN_SHARE });
        }
    }
}

/// The part of a segment inside the picture, widened by `margin` (Liang and Barsky's way: the range of the parameter
/// is narrowed edge by edge).
fn cut_to_picture(
    from: Projected,
    to: Projected,
    width: f64,
    height: f64,
    margin: f64,
) -> Option<(Projected, Projected)> {
    let (dx, dy) = (to.x - from.x, to.y - from.y);
    let edges = [
        (-dx, from.x + margin),
        (dx, width + margin - from.x),
        (-dy, from.y + margin),
        (dy, height + margin - from.y),
    ];
    let (mut low, mut high) = (0.0f64, 1.0f64);
    for (direction, room) in edges {
        if direction == 0.0 {
            if room < 0.0 {
                return None;
            }
        } else if direction < 0.0 {
            low = low.max(room / direction);
        } else {
            high = high.min(room / direction);
        }
    }
    let at = |share: f64| Projected {
        x: from.x + dx * share,
        y: from.y + dy * share,
        depth: 1.0 / (1.0 / from.depth * (1.0 - share) + 1.0 / to.depth * share),
    };
    (low <= high).then(|| (at(low), at(high)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64) -> Projected {
        Projected { x, y, depth: 1.0 }
    }

    #[test]
    fn a_line_covers_its_length_times_its_thickness() {
        for (from, to) in [
            (at(10.0, 12.0), at(50.0, 12.0)),
            (at(10.0, 10.0), at(40.0, 55.0)),
            (at(30.0, 60.0), at(25.0, 5.0)),
        ] {
            let mut canvas = Canvas::filled(64, 64, Colour::ZERO);
            draw(&mut canvas, from, to, 2.0, Colour::ONE);
            let area: f32 = (0..64)
                .flat_map(|y| (0..64).map(move |x| (x, y)))
                .map(|(x, y)| canvas.colour(x, y).x)
                .sum();
            let expected = 2.0 * ((to.x - from.x).powi(2) + (to.y - from.y).powi(2)).sqrt() as f32;
            // The round ends add at most a disc of the line's thickness and a half pixel around it.
            assert!(
                area > expected * 0.95 && area < expected * 1.05 + 5.0,
                "{area} {expected}"
            );
        }
    }

    #[test]
    fn a_hidden_line_is_faint() {
        let mut canvas = Canvas::new(32, vec![Colour::ZERO; 32 * 32], vec![0.5; 32 * 32]);
        draw(&mut canvas, at(4.0, 16.0), at(28.0, 16.0), 2.0, Colour::ONE);
        assert_eq!(canvas.colour(16, 16).x, HIDDEN_SHARE);
    }

    #[test]
    fn a_line_far_outside_costs_and_paints_nothing() {
        let mut canvas = Canvas::filled(32, 32, Colour::ZERO);
        draw(&mut canvas, at(-1e15, -1e15), at(1e15, -1e14), 2.0, Colour::ONE);
        draw(&mut canvas, at(-1e15, 16.0), at(1e15, 16.0), 2.0, Colour::ONE);
        assert_eq!(canvas.colour(16, 4), Colour::ZERO);
        assert!(canvas.colour(16, 16).x > 0.9);
    }
}
