//! Closed solids from formulas: lofts, boxes, gears, spheres.

use crate::rotation::{cos_turn, sin_turn};
use crate::surface::Surface;
use glam::DVec3;
use std::collections::BTreeMap;

/// A closed solid through rings of equal length, with a fan over each end.
///
/// Each ring runs counter-clockwise seen from the end of the loft, looking back to its start.
pub fn loft(rings: &[Vec<DVec3>]) -> Surface {
    let mut surface = Surface::default();
    let (Some(first), Some(last)) = (rings.first(), rings.last()) else {
        return surface;
    };
    let sides = first.len() as u32;
    for ring in rings {
        surface.positions.extend_from_slice(ring);
    }
    for ring in 1..rings.len() as u32 {
        for side in 0..sides {
            let next = (side + 1) % sides;
            let (low, high) = ((ring - 1) * sides, ring * sides);
            surface.push_quad([low + side, low + next, high + next, high + side]);
        }
    }
    let mean = |ring: &[DVec3]| ring.iter().sum::<DVec3>() / ring.len() as f64;
    let start = surface.push(mean(first));
    let end = surface.push(mean(last));
    let top = (rings.len() as u32 - 1) * sides;
    for side in 0..sides {
        let next = (side + 1) % sides;
        surface.triangles.push([start, next, side]);
        surface.triangles.push([end, top + side, top + next]);
    }
    surface
}

/// Points of a circle about the y axis at height `y`, counter-clockwise seen from +y.
pub fn circle(radius: f64, y: f64, sides: u32) -> Vec<DVec3> {
    (0..sides)
        .map(|side| {
            let turn = f64::from(side) / f64::from(sides);
            DVec3::new(radius * sin_turn(turn), y, radius * cos_turn(turn))
        })
        .collect()
}

/// A solid of revolution about y through `(radius, y)` points that ascend along the outside.
pub fn lathe(profile: &[(f64, f64)], sides: u32) -> Surface {
    let rings: Vec<_> = profile.iter().map(|&(radius, y)| circle(radius, y, sides)).collect();
    loft(&rings)
}

/// The corners of a box by bits: bit 0 is x, bit 1 is y, bit 2 is z.
fn box_corners(low: DVec3, high: DVec3) -> [DVec3; 8] {
    core::array::from_fn(|bits| {
        let pick = |bit: usize, low: f64, high: f64| if bits & bit == 0 { low } else { high };
        DVec3::new(pick(1, low.x, high.x), pick(2, low.y, high.y), pick(4, low.z, high.z))
    })
}

/// An axis-aligned box of twelve triangles.
pub fn cuboid(low: DVec3, high: DVec3) -> Surface {
    let mut surface = Surface {
        positions: box_corners(low, high).to_vec(),
        triangles: Vec::new(),
    };
    for quad in [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ] {
        surface.push_quad(quad);
    }
    surface
}

/// Measures of a [`gear`].
#[derive(Clone, Copy, Debug)]
pub struct GearShape {
    /// Number of teeth.
    pub teeth: u32,
    /// Radius at which it rolls on another gear.
    pub pitch_radius: f64,
    /// Radius of the hole.
    pub bore_radius: f64,
    /// Half of the thickness along z.
    pub half_thickness: f64,
}

/// A spur gear about z with trapezoid teeth and a bore; the middle of tooth 0 points to +x.
///
/// Two gears mesh when their pitch radii are in the ratio of their teeth.
pub fn gear(shape: GearShape) -> Surface {
    let GearShape {
        teeth,
        pitch_radius,
        bore_radius,
        half_thickness,
    } = shape;
    let module = 2.0 * pitch_radius / f64::from(teeth);
    let (tip, root) = (pitch_radius + 0.85 * module, pitch_radius - 1.05 * module);
    // Per tooth: foot, tip, tip, foot. The offsets are in tooth pitches from the middle of the tooth.
    let outline = [(-0.36, root), (-0.13, tip), (0.13, tip), (0.36, root)];
    let count = teeth * 4;
    let mut surface = Surface::default();
    for (z, inner) in [
        (-half_thickness, false),
        (half_thickness, false),
        (half_thickness, true),
        (-half_thickness, true),
    ] {
        for tooth in 0..teeth {
            for (offset, radius) in outline {
                let turn = (f64::from(tooth) + offset) / f64::from(teeth);
                let radius = if inner { bore_radius } else { radius };
                surface.push(DVec3::new(radius * cos_turn(turn), radius * sin_turn(turn), z));
            }
        }
    }
    // Around the cross-section: rim, front face, bore, back face.
    for band in 0..4 {
        let (from, to) = (band * count, (band + 1) % 4 * count);
        for step in 0..count {
            let next = (step + 1) % count;
            surface.push_quad([from + step, from + next, to + next, to + step]);
        }
    }
    surface
}

/// A unit sphere: an icosahedron whose triangles are quartered `subdivisions` times.
pub fn sphere(subdivisions: u32) -> Surface {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut surface = Surface::default();
    for (first, second) in [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)] {
        surface.push(DVec3::new(first, second, 0.0).normalize());
    }
    for (first, second) in [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)] {
        surface.push(DVec3::new(0.0, first, second).normalize());
    }
    for (first, second) in [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)] {
        surface.push(DVec3::new(second, 0.0, first).normalize());
    }
    surface.triangles = icosahedron_triangles(&surface.positions);
    for _ in 0..subdivisions {
        surface = quartered(&surface).map(DVec3::normalize);
    }
    surface
}

/// The outward triangles among twelve icosahedron vertices: the triples whose vertices are mutual neighbours.
fn icosahedron_triangles(positions: &[DVec3]) -> Vec<[u32; 3]> {
    // Neighbours lie 1.05 apart on the unit sphere, the next nearest 1.70.
    let near = |a: usize, b: usize| positions[a].distance(positions[b]) < 1.3;
    let mut triangles = Vec::new();
    for a in 0..positions.len() {
        for b in a + 1..positions.len() {
            for c in b + 1..positions.len() {
                if near(a, b) && near(b, c) && near(c, a) {
                    let outward = positions[a].dot(positions[b].cross(positions[c])) > 0.0;
                    let (b, c) = if outward { (b, c) } else { (c, b) };
                    triangles.push([a as u32, b as u32, c as u32]);
                }
            }
        }
    }
    triangles
}

/// Each triangle cut into four at the middles of its edges.
fn quartered(surface: &Surface) -> Surface {
    let mut fine = Surface {
        positions: surface.positions.clone(),
        triangles: Vec::new(),
    };
    let mut middles: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    for &[a, b, c] in &surface.triangles {
        let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(from, to)| {
            *middles.entry((from.min(to), from.max(to))).or_insert_with(|| {
                let sum = fine.positions[from as usize] + fine.positions[to as usize];
                fine.push(sum * 0.5)
            })
        });
        fine.triangles
            .extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    fine
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solids_are_closed_and_outward() {
        let gear = gear(GearShape {
            teeth: 12,
            pitch_radius: 0.5,
            bore_radius: 0.1,
            half_thickness: 0.1,
        });
        let solids = [
            ("loft", lathe(&[(0.5, 0.0), (0.7, 0.5), (0.2, 1.0)], 9)),
            ("cuboid", cuboid(DVec3::ZERO, DVec3::ONE)),
            ("gear", gear),
            ("sphere", sphere(2)),
        ];
        for (name, solid) in solids {
            assert!(solid.is_closed_manifold(), "{name} is not closed");
            assert!(solid.volume() > 0.0, "{name} is inside out");
        }
    }

    #[test]
    fn sphere_has_twenty_triangles_times_four_to_the_subdivisions() {
        assert_eq!(sphere(0).triangles.len(), 20);
        assert_eq!(sphere(2).triangles.len(), 320);
    }
}
