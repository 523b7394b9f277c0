use crate::import::Primitive;

/// Gives every vertex a home: the cluster in whose local space it is stored.
///
/// A vertex goes to the cluster with most of the triangles around it, the lowest of equals. Vertices that coincide in
/// every key (splits along seams) count as one, so that they stay together when their positions are rounded. A vertex of
/// no triangle goes to cluster 0.
///
/// Shapes: `weld` has per vertex the least vertex that coincides with it; `clusters` one entry per triangle.
pub(crate) fn homes(weld: &[u32], triangles: &[[u32; 3]], clusters: &[u32]) -> Vec<u32> {
    let mut claims: Vec<(u32, u32)> = triangles
        .iter()
        .zip(clusters)
        .flat_map(|(triangle, cluster)| triangle.map(|corner| (weld[corner as usize], *cluster)))
        .collect();
    claims.sort_unstable();
    let mut best = vec![(0usize, 0u32); weld.len()];
    for group in claims.chunk_by(|a, b| a == b) {
        let (vertex, cluster) = group[0];
        let held = &mut best[vertex as usize];
        if group.len() > held.0 {
            *held = (group.len(), cluster);
        }
    }
    weld.iter().map(|vertex| best[*vertex as usize].1).collect()
}

/// Per vertex, the least vertex that has the same position in every frame.
///
/// `frames` has one position per vertex.
pub(crate) fn weld<F: AsRef<[[f32; 3]]>>(frames: &[F]) -> Vec<u32> {
    let count = frames.first().map_or(0, |frame| frame.as_ref().len());
    let bits = |frame: &F, vertex: u32| frame.as_ref()[vertex as usize].map(|x| (x + 0.0).to_bits());
    let mut order: Vec<u32> = (0..count as u32).collect();
    let compare = |a: &u32, b: &u32| {
        let by_frame = frames.iter().map(|frame| bits(frame, *a).cmp(&bits(frame, *b)));
        by_frame.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
    };
    // Most vertices differ in the first frame already: the others are compared only where it ties.
    let lazy = |a: &u32, b: &u32| {
        frames
            .first()
            .map_or(std::cmp::Ordering::Equal, |frame| bits(frame, *a).cmp(&bits(frame, *b)))
    };
    order.sort_unstable_by(|a, b| lazy(a, b).then_with(|| compare(a, b)).then(a.cmp(b)));
    let mut out: Vec<u32> = vec![0; count];
    for group in order.chunk_by(|a, b| lazy(a, b).is_eq() && compare(a, b).is_eq()) {
        for vertex in group {
            out[*vertex as usize] = group[0];
        }
    }
    out
}

/// Vertices of a primitive that use the same point of the cache as one of another primitive: per point, how many do.
pub(crate) fn shared_points<'a>(point_count: usize, primitives: impl Iterator<Item = &'a Primitive>) -> Vec<bool> {
    let mut uses = vec![0u8; point_count];
    for point in primitives.flat_map(|primitive| &primitive.points) {
        let uses = &mut uses[*point as usize];
        *uses = uses.saturating_add(1);
    }
    uses.into_iter().map(|uses| uses > 1).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_that_always_coincide_are_welded() {
        let a = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [-0.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
        let b = [[5.0, 0.0, 0.0], [1.0, 0.0, 0.0], [5.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        assert_eq!(weld(&[a, b]), [0, 1, 0, 3]);
        assert_eq!(weld(&[a]), [0, 1, 0, 1]);
    }

    #[test]
    fn a_vertex_goes_where_most_of_its_triangles_are() {
        let triangles = [[0, 1, 2], [1, 2, 3], [4, 3, 2]];
        // 4 is a split copy of 1.
        let weld = [0, 1, 2, 3, 1, 5];
        assert_eq!(homes(&weld, &triangles, &[7, 8, 8]), [7, 8, 8, 8, 8, 0]);
    }
}
