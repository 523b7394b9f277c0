use glam::Vec3;
use restpose_formats::{
    ModelView,
    rows::{MotionClass, TriangleRow},
};

/// Triangles that meet at an angle with a cosine above this look like one round surface: 40 degrees.
const SMOOTH_COSINE: f32 = 0.766;

/// Where more corners than this meet in a point each keeps its own normal: comparing all pairs would take too long.
const MAX_CORNERS: usize = 64;

/// For each corner of each triangle, the triangles whose normals are averaged there.
///
/// A baked file holds no normals. Corners at the same rest position of a part whose triangles meet there at a small
/// angle in the rest pose share one, so seams of the texture do not show and edges of a box stay sharp. In free motion
/// only corners of one vertex do: what touches at rest need not stay together.
pub struct CornerFans {
    /// First entry in `triangles` of each corner, and a closing one; corner `3 · triangle + k`.
    first: Vec<u32>,
    triangles: Vec<u32>,
}

impl CornerFans {
    /// Fans of all triangles, found in the rest pose.
    pub fn new(model: &ModelView<'_>) -> Self {
        let faces: Vec<Vec3> = model.triangles.iter().map(|row| rest_normal(model, row)).collect();
        let mut corners = sorted_corners(model);
        let mut fans = vec![Vec::new(); model.triangles.len() * 3];
        for group in corners.chunk_by_mut(|a, b| a.place == b.place) {
            // In order of the triangles, so that sums come out the same wherever they are taken.
            group.sort_unstable_by_key(|corner| corner.id);
            for corner in &*group {
                let own = corner.id / 3;
                let Some(fan) = fans.get_mut(corner.id as usize) else {
                    continue;
                };
                if group.len() > MAX_CORNERS {
                    fan.push(own);
                } else {
                    let normal = faces[own as usize];
                    let close = |other: &u32| *other == own || faces[*other as usize].dot(normal) > SMOOTH_COSINE;
                    fan.extend(group.iter().map(|other| other.id / 3).filter(close));
                }
            }
        }
        let mut first = vec![0];
        let mut triangles = Vec::new();
        for fan in fans {
            triangles.extend(fan);
            first.push(triangles.len() as u32);
        }
        Self { first, triangles }
    }

    /// Unit normals at the three corners of `triangle`, given every triangle's normal with its area as length.
    /// A corner without any area around it takes `fallback`.
    pub fn corner_normals(&self, triangle: u32, area_normals: &[Vec3], fallback: Vec3) -> [Vec3; 3] {
        std::array::from_fn(|k| {
            let corner = triangle as usize * 3 + k;
            let fan = match (self.first.get(corner), self.first.get(corner + 1)) {
                (Some(&from), Some(&to)) => self.triangles.get(from as usize..to as usize).unwrap_or_default(),
                _ => &[],
            };
            let sum: Vec3 = fan.iter().filter_map(|t| area_normals.get(*t as usize)).sum();
            sum.try_normalize().unwrap_or(fallback)
        })
    }
}

struct Corner {
    /// Part, then the bits of the rest position; in free motion the vertex.
    place: [u32; 4],
    id: u32,
}

fn sorted_corners(model: &ModelView<'_>) -> Vec<Corner> {
    let mut corners = Vec::with_capacity(model.triangles.len() * 3);
    for (part, row) in model.parts.iter().enumerate() {
        let triangles = row.triangle_first..row.triangle_first.saturating_add(row.triangle_count);
        let free = row.class == MotionClass::Free as u32;
        for triangle in triangles {
            let Some(TriangleRow { corners: vertices }) = model.triangles.get(triangle as usize) else {
                break;
            };
            for (k, vertex) in vertices.iter().enumerate() {
                // Adding zero turns -0 into 0: the same place.
                let at = rest_position(model, *vertex).map(|x| (x + 0.0).to_bits());
                let [x, y, z] = if free { [*vertex, 0, 0] } else { at };
                corners.push(Corner {
                    place: [part as u32, x, y, z],
                    id: triangle * 3 + k as u32,
                });
            }
        }
    }
    corners.sort_unstable_by_key(|corner| (corner.place, corner.id));
    corners
}

fn rest_position(model: &ModelView<'_>, vertex: u32) -> [f32; 3] {
    model
        .vertices
        .get(vertex as usize)
        .map_or([0.0; 3], |row| row.position_rest)
}

fn rest_normal(model: &ModelView<'_>, row: &TriangleRow) -> Vec3 {
    let [a, b, c] = row.corners.map(|vertex| Vec3::from(rest_position(model, vertex)));
    (b - a).cross(c - a).normalize_or_zero()
}

#[cfg(test)]
mod tests {
    use super::*;
    use restpose_formats::{
        Model,
        rows::{NONE, PartRow, VertexRow},
    };

    /// Two triangles that share an edge, folded there by `height`, each with vertices of its own.
    fn folded(height: f32) -> Model {
        let positions = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 0.0, -1.0],
            [1.0, 0.0, 0.0],
            [1.0, height, -1.0],
            [-0.0, 0.0, -1.0],
            [0.0; 3],
        ];
        let part = PartRow {
            triangle_count: 2,
            ..part_of_six_vertices()
        };
        Model {
            vertices: positions
                .map(|position_rest| VertexRow {
                    position_rest,
                    influence_first: 0,
                })
                .to_vec(),
            triangles: vec![TriangleRow { corners: [0, 1, 2] }, TriangleRow { corners: [3, 4, 5] }],
            parts: vec![part],
            ..Model::default()
        }
    }

    fn part_of_six_vertices() -> PartRow {
        PartRow {
            source_node: 0,
            source_mesh: 0,
            source_skin: 0,
            class: 0,
            vertex_first: 0,
            vertex_count: 6,
            triangle_first: 0,
            triangle_count: 0,
            primitive_first: 0,
            primitive_count: 0,
            morph_set: 0,
            cache: NONE,
        }
    }

    #[test]
    fn a_gentle_fold_is_rounded_and_a_sharp_one_is_not() {
        for (height, rounded) in [(0.3, true), (3.0, false)] {
            let model = folded(height);
            let view = model.view();
            let fans = CornerFans::new(&view);
            let faces: Vec<Vec3> = view.triangles.iter().map(|row| rest_normal(&view, row)).collect();
            let [free, shared, _] = fans.corner_normals(0, &faces, Vec3::X);
            assert_eq!(free, faces[0]);
            let [same, ..] = fans.corner_normals(1, &faces, Vec3::X);
            assert_eq!(shared == same, rounded, "{height}: {shared} {same}");
        }
    }

    #[test]
    fn what_touches_at_rest_is_not_rounded_in_free_motion() {
        let mut model = folded(0.3);
        model.parts[0].class = MotionClass::Free as u32;
        let view = model.view();
        let fans = CornerFans::new(&view);
        let faces: Vec<Vec3> = view.triangles.iter().map(|row| rest_normal(&view, row)).collect();
        for (triangle, face) in faces.iter().enumerate() {
            assert_eq!(
                fans.corner_normals(triangle as u32, &faces, Vec3::X),
                [face.normalize(); 3]
            );
        }
    }

    #[test]
    fn a_corner_without_area_takes_the_fallback() {
        let model = folded(0.3);
        let fans = CornerFans::new(&model.view());
        assert_eq!(fans.corner_normals(0, &[Vec3::ZERO; 2], Vec3::X), [Vec3::X; 3]);
        assert_eq!(fans.corner_normals(9, &[Vec3::ZERO; 2], Vec3::X), [Vec3::X; 3]);
    }
}
