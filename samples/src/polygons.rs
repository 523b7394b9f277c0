//! Polygon meshes: what the generators build before it becomes an OBJ file.

use crate::solids::sphere;
use crate::surface::Surface;
use glam::DVec3;
use std::collections::BTreeMap;

/// Points and the polygons among them. Front faces are counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Polygons {
    /// Points, scene units.
    pub positions: Vec<DVec3>,
    /// At least three points each.
    pub faces: Vec<Vec<u32>>,
}

impl Polygons {
    /// The fans of all faces about their first corners, as readers of OBJ files cut them.
    pub fn triangulated(&self) -> Surface {
        let fan = |face: &Vec<u32>| -> Vec<[u32; 3]> {
            let rest = face.get(1..).unwrap_or_default().windows(2);
            rest.map(|pair| [face[0], pair[0], pair[1]]).collect()
        };
        Surface {
            positions: self.positions.clone(),
            triangles: self.faces.iter().flat_map(fan).collect(),
        }
    }

    /// Adds a copy of a triangle surface.
    pub fn append(&mut self, surface: &Surface) {
        let first = self.positions.len() as u32;
        self.positions.extend_from_slice(&surface.positions);
        let shifted = |corners: &[u32; 3]| corners.map(|corner| corner + first).to_vec();
        self.faces.extend(surface.triangles.iter().map(shifted));
    }
}

/// A closed solid through rings of equal length: quadrilaterals between them and a polygon over each end.
///
/// Each ring runs counter-clockwise seen from the end of the loft, looking back to its start.
pub fn polygon_loft(rings: &[Vec<DVec3>]) -> Polygons {
    let sides = rings.first().map_or(0, Vec::len) as u32;
    let last = (rings.len() as u32).saturating_sub(1) * sides;
    let mut faces: Vec<Vec<u32>> = vec![(0..sides).rev().collect(), (last..last + sides).collect()];
    for low in (0..last).step_by(sides.max(1) as usize) {
        faces.extend((0..sides).map(|side| {
            let next = (side + 1) % sides;
            vec![low + side, low + next, low + sides + next, low + sides + side]
        }));
    }
    Polygons {
        positions: rings.concat(),
        faces,
    }
}

/// A unit ball of pentagons and hexagons: one about each vertex of an icosahedron whose triangles are quartered
/// `subdivisions` times.
pub fn honeycomb_ball(subdivisions: u32) -> Polygons {
    let sphere = sphere(subdivisions);
    // Around each vertex, the triangle that follows another one is that which shares the edge to its third corner.
    let mut after: Vec<BTreeMap<u32, (u32, u32)>> = vec![BTreeMap::new(); sphere.positions.len()];
    for (number, &[a, b, c]) in sphere.triangles.iter().enumerate() {
        for (centre, from, to) in [(a, b, c), (b, c, a), (c, a, b)] {
            after[centre as usize].insert(from, (to, number as u32));
        }
    }
    let around = |turns: &BTreeMap<u32, (u32, u32)>| {
        let mut face = Vec::new();
        let mut next = turns.keys().next().copied();
        while let Some(&(to, triangle)) = next.and_then(|from| turns.get(&from)) {
            if face.first() == Some(&triangle) {
                break;
            }
            face.push(triangle);
            next = Some(to);
        }
        face
    };
    let middle = |corners: &[u32; 3]| {
        let sum: DVec3 = corners.iter().map(|corner| sphere.positions[*corner as usize]).sum();
        sum.normalize()
    };
    Polygons {
        positions: sphere.triangles.iter().map(middle).collect(),
        faces: after.iter().map(around).collect(),
    }
}

/// The quadrilaterals of a surface net, turned so that their fans are its triangles; as triangles where `whole` says
/// no for a corner.
pub fn quadrilaterals(net: &Surface, whole: impl Fn(DVec3) -> bool) -> Polygons {
    let mut faces = Vec::new();
    for pair in net.triangles.chunks(2) {
        match *pair {
            [[a, b, c], [first, _, d]] if pair.as_flattened().iter().all(|at| whole(net.positions[*at as usize])) => {
                // Cut along a–c, or as a b d and b c d along b–d.
                let quad = if first == a {
                    [a, b, c, d]
                } else {
                    [b, pair[1][1], c, a]
                };
                faces.push(quad.to_vec());
            }
            _ => faces.extend(pair.iter().map(|corners| corners.to_vec())),
        }
    }
    Polygons {
        positions: net.positions.clone(),
        faces,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solids::circle;

    #[test]
    fn solids_are_closed_and_outward() {
        let rings = [(0.5, 0.0), (0.7, 0.5), (0.2, 1.0)].map(|(radius, y)| circle(radius, y, 9));
        for (name, solid, faces) in [
            ("loft", polygon_loft(&rings), 20),
            ("pentagons", honeycomb_ball(0), 12),
            ("ball", honeycomb_ball(1), 42),
        ] {
            assert_eq!(solid.faces.len(), faces, "{name}");
            let surface = solid.triangulated();
            assert!(surface.is_closed_manifold(), "{name} is not closed");
            assert!(surface.volume() > 0.0, "{name} is inside out");
        }
        let pentagons = honeycomb_ball(1).faces.iter().filter(|face| face.len() == 5).count();
        assert_eq!(pentagons, 12);
    }

    #[test]
    fn a_quadrilateral_keeps_its_cut() {
        for shift in [0.0, 0.6] {
            let mut net = Surface::default();
            let corners = [[0.0, 0.0], [1.0, 0.0], [1.0 + shift, 1.0 + shift], [0.0, 1.0]];
            let quad = corners.map(|[x, y]| net.push(DVec3::new(x, y, 0.0)));
            net.push_quad(quad);
            // Along both diagonals, in turn.
            assert_eq!(net.triangles[1][0] == quad[0], shift == 0.0);
            let whole = quadrilaterals(&net, |_| true);
            assert_eq!(whole.faces.len(), 1);
            let canonical = |surface: &Surface| {
                let turned = |corners: &[u32; 3]| (0..3).map(|i| [0, 1, 2].map(|j| corners[(i + j) % 3])).min();
                let mut triangles: Vec<_> = surface.triangles.iter().map(turned).collect();
                triangles.sort_unstable();
                triangles
            };
            assert_eq!(canonical(&whole.triangulated()), canonical(&net));
            assert_eq!(quadrilaterals(&net, |point| point.x < 1.0).faces.len(), 2);
        }
    }
}
