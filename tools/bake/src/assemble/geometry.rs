use super::{degenerate::is_degenerate, row_count, skeleton::Skeleton, weights::exact_weights};
use crate::{
    BakeError,
    assemble::skeleton::Columns,
    caches::cache_row,
    import::{Animation, Part, Primitive},
    motion::Classified,
};
use restpose_formats::{
    Model,
    rows::{
        InfluenceRow, MorphDeltaRow, MorphSetRow, MorphTargetRow, MotionClass, NONE, PartRow, PrimitiveRow,
        TriangleRow, VertexRow,
    },
};

/// What parts gave beside their rows.
pub(crate) struct Geometry {
    /// Per source node, its morph set row or `NONE`.
    pub morph_sets: Vec<u32>,
    /// Per vertex cache of the source, the cache rows of its parts.
    pub cache_rows: Vec<Vec<u32>>,
}

/// Adds parts, primitives, vertices, influences, triangles and morphs, and the beginnings of vertex caches.
pub(crate) fn add_geometry(
    model: &mut Model,
    animation: &Animation,
    classes: &[Classified],
    skeleton: &Skeleton,
) -> Result<Geometry, BakeError> {
    let mut cache_rows = vec![Vec::new(); animation.caches.len()];
    let mut sets = vec![NONE; animation.nodes.len()];
    let any_morphs = classes.iter().any(|class| class.morphs);
    for (index, (part, class)) in animation.parts.iter().zip(classes).enumerate() {
        let mesh = &animation.meshes[part.mesh];
        if class.morphs {
            sets[part.node] = add_morph_set(model, animation, part)?;
        }
        let mut row = PartRow {
            source_node: row_count("nodes", part.node)?,
            source_mesh: row_count("meshes", part.mesh)?,
            source_skin: part.skin.map_or(Ok(NONE), |skin| row_count("skins", skin))?,
            class: class.class as u32,
            vertex_first: row_count("vertices", model.vertices.len())?,
            vertex_count: 0,
            triangle_first: row_count("triangles", model.triangles.len())?,
            triangle_count: 0,
            primitive_first: row_count("primitives", model.primitives.len())?,
            primitive_count: row_count("primitives", mesh.primitives.len())?,
            morph_set: if class.morphs { sets[part.node] } else { NONE },
            cache: match part.cache.filter(|_| class.class != MotionClass::Static) {
                Some(cache) => {
                    let row = row_count("vertex caches", model.caches.len())?;
                    let keys = row_count("keys", animation.caches[cache].frame_count())?;
                    let (part, bone) = (row_count("parts", index)?, skeleton.first_bone[index]);
                    model.caches.push(cache_row(part, bone, keys));
                    cache_rows[cache].push(row);
                    row
                }
                None => NONE,
            },
        };
        let target_first = if class.morphs {
            model.morph_sets[row.morph_set as usize].target_first
        } else {
            0
        };
        let placer = Placer {
            animation,
            part,
            class,
            skeleton,
            first_bone: skeleton.first_bone[index],
            target_first,
        };
        for primitive in &mesh.primitives {
            let vertex_first = row_count("vertices", model.vertices.len())?;
            for vertex in 0..primitive.positions.len() {
                placer.add_vertex(model, primitive, vertex, any_morphs)?;
            }
            let triangle_first = row_count("triangles", model.triangles.len())?;
            let corners = |triangle: &[u32; 3]| TriangleRow {
                corners: triangle.map(|corner| vertex_first + corner),
            };
            model.triangles.extend(primitive.triangles.iter().map(corners));
            model.primitives.push(PrimitiveRow {
                source_primitive: row_count("primitives", primitive.source_primitive)?,
                triangle_first,
                triangle_count: row_count("triangles", primitive.triangles.len())?,
                reserved: 0,
            });
        }
        row.vertex_count = row_count("vertices", model.vertices.len())? - row.vertex_first;
        row.triangle_count = row_count("triangles", model.triangles.len())? - row.triangle_first;
        model.parts.push(row);
        model.meta.part_names.push(part.name.clone());
    }
    let influence_first = row_count("influences", model.influences.len())?;
    model.vertices.push(VertexRow {
        position_rest: [0.0; 3],
        influence_first,
    });
    if model.morph_deltas.is_empty() {
        model.morph_first.clear();
    } else {
        model
            .morph_first
            .push(row_count("morph deltas", model.morph_deltas.len())?);
    }
    mark_degenerate(model);
    Ok(Geometry {
        morph_sets: sets,
        cache_rows,
    })
}

fn add_morph_set(model: &mut Model, animation: &Animation, part: &Part) -> Result<u32, BakeError> {
    let mesh = &animation.meshes[part.mesh];
    let set = row_count("morph sets", model.morph_sets.len())?;
    model.morph_sets.push(MorphSetRow {
        source_node: row_count("nodes", part.node)?,
        target_first: row_count("morph targets", model.morph_targets.len())?,
        target_count: row_count("morph targets", mesh.morph_target_count)?,
        reserved: 0,
    });
    for target in 0..mesh.morph_target_count {
        let mut extent = [0.0f32; 3];
        for delta in mesh
            .primitives
            .iter()
            .flat_map(|primitive| &primitive.morph_targets[target])
        {
            extent = std::array::from_fn(|k| extent[k].max(delta[k].abs()));
        }
        let default_weight = animation.nodes[part.node].weights[target];
        model.morph_targets.push(MorphTargetRow { default_weight, extent });
    }
    Ok(set)
}

/// Lays out the vertices of one part.
struct Placer<'a> {
    animation: &'a Animation,
    part: &'a Part,
    class: &'a Classified,
    skeleton: &'a Skeleton,
    first_bone: u32,
    target_first: u32,
}

impl Placer<'_> {
    fn add_vertex(
        &self,
        model: &mut Model,
        primitive: &Primitive,
        vertex: usize,
        any_morphs: bool,
    ) -> Result<(), BakeError> {
        let influence_first = row_count("influences", model.influences.len())?;
        let influences = match self.part.skin {
            Some(_) => exact_weights(&primitive.influences[vertex]),
            None => vec![(0, 1.0)],
        };
        let mut position = primitive.positions[vertex].map(f64::from);
        if any_morphs {
            model
                .morph_first
                .push(row_count("morph deltas", model.morph_deltas.len())?);
        }
        for (target, deltas) in (0u32..).zip(&primitive.morph_targets) {
            let delta = deltas[vertex];
            if self.class.morphs {
                if delta != [0.0; 3] {
                    model.morph_deltas.push(MorphDeltaRow {
                        target: self.target_first + target,
                        delta,
                    });
                }
            } else {
                let weight = f64::from(self.animation.nodes[self.part.node].weights[target as usize]);
                position = std::array::from_fn(|k| position[k] + weight * f64::from(delta[k]));
            }
        }
        if self.class.class == MotionClass::Static {
            position = self.frozen(position, &influences);
            model.influences.push(InfluenceRow {
                bone: self.first_bone,
                weight: 1.0,
            });
        } else {
            let row = |(joint, weight): &(usize, f32)| InfluenceRow {
                bone: self.first_bone + *joint as u32,
                weight: *weight,
            };
            model.influences.extend(influences.iter().map(row));
        }
        model.vertices.push(VertexRow {
            position_rest: position.map(|x| x as f32),
            influence_first,
        });
        Ok(())
    }

    /// Where a vertex of a static part is, in asset space: by its node, or frozen under its skin.
    fn frozen(&self, position: [f64; 3], influences: &[(usize, f32)]) -> [f64; 3] {
        let moved = |map: &Columns| -> [f64; 3] {
            std::array::from_fn(|k| {
                map[0][k] * position[0] + map[1][k] * position[1] + map[2][k] * position[2] + map[3][k]
            })
        };
        let Some(skin) = self.part.skin else {
            return moved(&self.skeleton.worlds[self.part.node]);
        };
        let skin = &self.animation.skins[skin];
        influences.iter().fold([0.0; 3], |sum, (joint, weight)| {
            let inverse_bind = skin.inverse_bind[*joint].map(|column| column.map(f64::from));
            let map = super::skeleton::product(&self.skeleton.worlds[skin.joints[*joint]], &inverse_bind);
            let at = moved(&map);
            std::array::from_fn(|k| sum[k] + f64::from(*weight) * at[k])
        })
    }
}

/// Gives triangles that never have area three equal corners, which no tree holds and no ray hits, and counts them.
fn mark_degenerate(model: &mut Model) {
    let mut count = 0;
    for part in 0..model.parts.len() {
        let part = model.parts[part];
        // In a vertex cache the other keys have a say; its own stage marks them.
        if part.cache != NONE {
            continue;
        }
        for index in part.triangle_first as usize..(part.triangle_first + part.triangle_count) as usize {
            if is_degenerate(model, &model.triangles[index]) {
                model.triangles[index].corners = [model.triangles[index].corners[0]; 3];
                count += 1;
            }
        }
    }
    model.meta.degenerate_triangle_count = count;
}
