use super::motion::vector;
use fastrand::Rng;
use nalgebra::Vector3;

/// Points about the origin, inside a cube of side 0.6, and the triangles among them.
pub(super) struct Piece {
    pub points: Vec<Vector3<f64>>,
    pub triangles: Vec<[usize; 3]>,
}

/// A closed bipyramid, or as many random triangles as points: in space, in a plane, on a line, or all at one point.
pub(super) fn random_piece(points: usize, random: &mut Rng) -> Piece {
    let dimensions = match random.u32(..12) {
        0 => 0,
        1 => 1,
        2 | 3 => 2,
        4..8 => 3,
        _ if points >= 5 => return bipyramid(points),
        _ => 3,
    };
    let corner = |random: &mut Rng| random.usize(..points);
    let mut triangles: Vec<[usize; 3]> = (0..points).map(|_| std::array::from_fn(|_| corner(random))).collect();
    // Chance may draw a corner twice; one triangle is sure not to.
    triangles[0] = [0, 1, 2];
    let points = (0..points)
        .map(|_| {
            let point = vector(random, 0.3);
            Vector3::from_fn(|axis, _| if axis < dimensions { point[axis] } else { 0.0 })
        })
        .collect();
    Piece { points, triangles }
}

/// Two tips and a ring between them, wound outwards.
pub(super) fn bipyramid(points: usize) -> Piece {
    let ring = points - 2;
    let on_ring = |index: usize| {
        // The rational circle, from -90° to 90° and back along a chord: no sine is needed.
        let t = 2.0 * index as f64 / (ring - 1) as f64 - 1.0;
        Vector3::new(2.0 * t, 1.0 - t * t, 0.0) * (0.3 / (1.0 + t * t))
    };
    let tips = [Vector3::new(0.0, 0.1, -0.3), Vector3::new(0.0, 0.1, 0.3)];
    let sides = (0..ring).flat_map(|index| {
        let next = (index + 1) % ring;
        [[index, next, ring], [next, index, ring + 1]]
    });
    Piece {
        points: (0..ring).map(on_ring).chain(tips).collect(),
        triangles: sides.collect(),
    }
}
