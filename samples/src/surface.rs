//! Triangle surfaces: what the generators build before it becomes a glTF mesh.

use glam::DVec3;
use std::collections::BTreeMap;

/// An indexed triangle surface. Front faces are counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Vertices, scene units.
    pub positions: Vec<DVec3>,
    /// Three vertices each.
    pub triangles: Vec<[u32; 3]>,
}

impl Surface {
    /// Adds a vertex and gives its index.
    pub fn push(&mut self, position: DVec3) -> u32 {
        self.positions.push(position);
        (self.positions.len() - 1) as u32
    }

    /// Adds the quadrilateral `a b c d`, counter-clockwise from outside, cut along its shorter diagonal.
    pub fn push_quad(&mut self, [a, b, c, d]: [u32; 4]) {
        let at = |vertex: u32| self.positions[vertex as usize];
        if at(a).distance_squared(at(c)) <= at(b).distance_squared(at(d)) {
            self.triangles.extend([[a, b, c], [a, c, d]]);
        } else {
            self.triangles.extend([[a, b, d], [b, c, d]]);
        }
    }

    /// Adds a copy of another surface.
    pub fn append(&mut self, other: &Surface) {
        let first = self.positions.len() as u32;
        self.positions.extend_from_slice(&other.positions);
        let shifted = other
            .triangles
            .iter()
            .map(|corners| corners.map(|corner| corner + first));
        self.triangles.extend(shifted);
    }

    /// The surface with every vertex moved; the map must keep orientation.
    pub fn map(mut self, map: impl Fn(DVec3) -> DVec3) -> Surface {
        for position in &mut self.positions {
            *position = map(*position);
        }
        self
    }

    /// The surface moved by `offset`.
    pub fn translated(self, offset: DVec3) -> Surface {
        self.map(|position| position + offset)
    }

    /// Unit normal per vertex: the mean of its triangles' normals, weighted by area.
    pub fn normals(&self) -> Vec<DVec3> {
        let mut sums = vec![DVec3::ZERO; self.positions.len()];
        for corners in &self.triangles {
            let [a, b, c] = corners.map(|corner| self.positions[corner as usize]);
            let doubled_area = (b - a).cross(c - a);
            for &corner in corners {
                sums[corner as usize] += doubled_area;
            }
        }
        sums.into_iter().map(|sum| sum.normalize_or(DVec3::Y)).collect()
    }

    /// Enclosed volume; positive when the winding is outward.
    pub fn volume(&self) -> f64 {
        let sixfold: f64 = self
            .triangles
            .iter()
            .map(|corners| {
                let [a, b, c] = corners.map(|corner| self.positions[corner as usize]);
                a.dot(b.cross(c))
            })
            .sum();
        sixfold / 6.0
    }

    /// Whether every edge is shared by exactly two triangles that run along it in opposite directions.
    pub fn is_closed_manifold(&self) -> bool {
        let mut uses: BTreeMap<(u32, u32), u32> = BTreeMap::new();
        for &[a, b, c] in &self.triangles {
            for edge in [(a, b), (b, c), (c, a)] {
                *uses.entry(edge).or_default() += 1;
            }
        }
        uses.iter()
            .all(|(&(a, b), &count)| count == 1 && uses.get(&(b, a)) == Some(&1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> Surface {
        Surface {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
            triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        }
    }

    #[test]
    fn tetrahedron_is_closed_and_outward() {
        let surface = tetrahedron();
        assert!(surface.is_closed_manifold());
        // One rounding of 1/6.
        assert!((surface.volume() - 1.0 / 6.0).abs() < 1e-15);
    }

    #[test]
    fn a_missing_or_flipped_triangle_is_found() {
        let mut open = tetrahedron();
        open.triangles.pop();
        assert!(!open.is_closed_manifold());
        let mut flipped = tetrahedron();
        flipped.triangles[0].swap(0, 1);
        assert!(!flipped.is_closed_manifold());
    }
}
