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
    on_a_line && !morphs(model, a) && moves_alike(model, a, b) && moves_alike(model, b, c)
}

fn position(model: &Model, vertex: usize) -> [f32; 3] {
    model.vertices[vertex].position_rest
}

fn moves_alike(model: &Model, a: usize, b: usize) -> bool {
    let influences = |vertex: usize| {
        &model.influences[model.vertices[vertex].influence_first as usize..]
            [..(model.vertices[vertex + 1].influence_first - model.vertices[vertex].influence_first) as usize]
    };
    let deltas = |vertex: usize| match model.morph_first.get(vertex..vertex + 2) {
        Some(ends) => &model.morph_deltas[ends[0] as usize..ends[1] as usize],
        None => &[],
    };
    influences(a) == influences(b) && deltas(a) == deltas(b)
}

fn morphs(model: &Model, vertex: usize) -> bool {
    model
        .morph_first
        .get(vertex..vertex + 2)
        .is_some_and(|ends| ends[0] != ends[1])
}
