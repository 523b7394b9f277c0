use restpose_formats::{Model, rows::TriangleRow};

/// True when a triangle has no area in any pose: two corners that always coincide, or three that lie on a line in the
/// rest pose and move by the same affine map.
pub(super) fn is_degenerate(model: &Model, triangle: &TriangleRow) -> bool {
    let [a, b, c] = triangle.corners.map(|corner| corner as usize);
    let together =
        |a: usize, b: usize| a == b || (position(model, a) == position(model, b) && moves_alike(model, a, b));
    if together(a, b) || together(b, c) || together(c, a) {
        return true;
    }
    let edge = |from: usize, to: usize| -> [f64; 3] {
        let (from, to) = (position(model, from), position(model, to));
        std::array::from_fn(|k| f64::from(to[k]) - f64::from(from[k]))
    };
    let (e, f) = (edge(a, b), edge(a, c));
    let on_a_line = (0..3).all(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        e[i] * f[j] == e[j] * f[i]
    });
    on_a_line && model.morph_deltas_of(a).is_empty() && moves_alike(model, a, b) && moves_alike(model, b, c)
}

fn position(model: &Model, vertex: usize) -> [f32; 3] {
    model.vertices[vertex].position_rest
}

fn moves_alike(model: &Model, a: usize, b: usize) -> bool {
    model.influences_of(a) == model.influences_of(b) && model.morph_deltas_of(a) == model.morph_deltas_of(b)
}
