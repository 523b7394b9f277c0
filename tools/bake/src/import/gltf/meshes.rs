use super::{
    accessor::{Accessors, Component, Numbers},
    document::Document,
    influences,
    schema::{self, escape},
    topology::Topology,
};
use crate::import::{Fault, Mesh, Primitive, fault_list::FaultList};

const DRACO: &str = "KHR_draco_mesh_compression";

/// Reads all meshes. `joint_counts` has, per mesh, the number of joints that every skin over it has, or nothing where
/// no skin is over it: then its joints are not read.
pub(super) fn read(
    document: &Document,
    accessors: &Accessors,
    joint_counts: &[Option<usize>],
    faults: &mut FaultList,
) -> Vec<Mesh> {
    let quantization_declared = document
        .extensions_used
        .iter()
        .any(|name| name == "KHR_mesh_quantization");
    let mut quantized = false;
    let meshes = document
        .meshes
        .iter()
        .zip(joint_counts)
        .enumerate()
        .map(|(number, (row, joint_count))| {
            let mut mesh = Mesh {
                name: row.name.clone().unwrap_or_default(),
                ..Mesh::default()
            };
            let mut target_count = None;
            for (place, row) in row.primitives.iter().enumerate() {
                let reader = PrimitiveReader {
                    row,
                    path: format!("/meshes/{number}/primitives/{place}"),
                    accessors,
                };
                let position = row.attributes.get("POSITION");
                let kind = position.map(|index| accessors.component(*index, &reader.path));
                quantized |= matches!(kind, Some(Ok(kind)) if kind != Component::F32);
                let Some(primitive) = reader.read(place, *joint_count, faults) else {
                    continue;
                };
                let found = primitive.morph_targets.len();
                let expected = *target_count.get_or_insert(found);
                if found != expected {
                    faults.error(
                        format!("{}/targets", reader.path),
                        format!("{found} morph targets; expected {expected}, as in the mesh's other primitives"),
                    );
                }
                mesh.primitives.push(primitive);
            }
            mesh.morph_target_count = target_count.unwrap_or(0);
            mesh
        });
    let meshes = meshes.collect();
    if quantized && !quantization_declared {
        faults.warn(
            "/extensionsUsed",
            "positions are integers, but KHR_mesh_quantization is not named; they are decoded",
        );
    }
    meshes
}

/// The vertices that a primitive claims to have.
#[derive(Clone, Copy)]
struct Vertices {
    count: usize,
    /// Positions have been decoded, so that the count is more than a claim.
    backed: bool,
}

struct PrimitiveReader<'a> {
    row: &'a schema::Primitive,
    path: String,
    accessors: &'a Accessors<'a>,
}

impl PrimitiveReader<'_> {
    /// The primitive, or nothing where it has no triangles or a fault.
    fn read(&self, place: usize, joint_count: Option<usize>, faults: &mut FaultList) -> Option<Primitive> {
        let topology = match self.row.mode.map_or(4, |mode| mode.0) {
            4 => Topology::List,
            5 => Topology::Strip,
            6 => Topology::Fan,
            0..=3 => {
                faults.warn(
                    format!("{}/mode", self.path),
                    "points and lines have no triangles; the primitive is skipped",
                );
                return None;
            }
            other => {
                faults.error(format!("{}/mode", self.path), format!("is {other}; expected 0 to 6"));
                return None;
            }
        };
        let Some(position) = self.row.attributes.get("POSITION") else {
            faults.warn(
                format!("{}/attributes", self.path),
                "no POSITION; the primitive is skipped",
            );
            return None;
        };
        if let Err(fault) = self.refuse_draco(*position) {
            faults.push(fault);
            return None;
        }
        let at = format!("{}/attributes/POSITION", self.path);
        let positions = faults.keep(self.accessors.floats::<3>(*position, Numbers::Quantized, &at));
        // The other properties are read even where the positions fail, so that their own faults are found as well.
        let vertices = match &positions {
            Some(positions) => Vertices {
                count: positions.len(),
                backed: true,
            },
            None => Vertices {
                count: self.accessors.get(*position, &at).ok()?.count.0,
                backed: false,
            },
        };
        let triangles = self.triangles(topology, vertices, faults);
        let morph_targets = self.morph_targets(vertices, faults);
        let influences = match joint_count {
            Some(joints) => influences::read(
                &self.row.attributes,
                self.accessors,
                vertices.count,
                joints,
                &self.path,
                faults,
            ),
            None => Some(Vec::new()),
        };
        let (positions, triangles) = (positions?, triangles?);
        if triangles.is_empty() {
            faults.warn(&self.path, "has no triangles; the primitive is skipped");
            return None;
        }
        Some(Primitive {
            source_primitive: place,
            positions,
            triangles,
            influences: influences?,
            morph_targets: morph_targets?,
            points: Vec::new(),
        })
    }

    /// An accessor without data stands for zeros; under Draco it stands for compressed data instead.
    fn refuse_draco(&self, position: schema::Whole) -> Result<(), Fault> {
        if !self.row.extensions.contains_key(DRACO) {
            return Ok(());
        }
        for accessor in [Some(position), self.row.indices].into_iter().flatten() {
            if self.accessors.get(accessor, &self.path)?.buffer_view.is_none() {
                let message = "the primitive is compressed with Draco and has no uncompressed copy; convert the file \
                     first, without compression";
                return Err(Fault::error(format!("{}/extensions/{DRACO}", self.path), message));
            }
        }
        Ok(())
    }

    fn triangles(&self, topology: Topology, vertices: Vertices, faults: &mut FaultList) -> Option<Vec<[u32; 3]>> {
        let (indices, at) = match self.row.indices {
            Some(index) => {
                let at = format!("{}/indices", self.path);
                let indices = self.indices(index, vertices.count, &at, faults);
                (faults.keep(indices)?, at)
            }
            None if !vertices.backed => return None,
            None => {
                let at = format!("{}/attributes/POSITION", self.path);
                let Ok(count) = u32::try_from(vertices.count) else {
                    faults.error(
                        at,
                        format!("{} vertices; expected at most {}", vertices.count, u32::MAX),
                    );
                    return None;
                };
                faults.keep(self.accessors.charge(vertices.count, size_of::<u32>(), &at))?;
                ((0..count).collect(), at)
            }
        };
        let left_over = topology.left_over(indices.len());
        if left_over > 0 {
            faults.warn(
                &at,
                format!(
                    "the last {left_over} of {} vertices form no triangle and are ignored",
                    indices.len()
                ),
            );
        }
        let count = topology.triangle_count(indices.len());
        faults.keep(self.accessors.charge(count, size_of::<[u32; 3]>(), &at))?;
        Some(topology.triangles(&indices))
    }

    fn indices(
        &self,
        index: schema::Whole,
        vertex_count: usize,
        at: &str,
        faults: &mut FaultList,
    ) -> Result<Vec<u32>, Fault> {
        let indices: Vec<u32> = self
            .accessors
            .wholes::<1>(index, at)?
            .into_iter()
            .map(|[index]| index)
            .collect();
        if let Some((place, index)) = indices
            .iter()
            .enumerate()
            .find(|(_, index)| **index as usize >= vertex_count)
        {
            return Err(Fault::error(
                at,
                format!("index {place} is {index}; the primitive has {vertex_count} vertices"),
            ));
        }
        let restart = match self.accessors.component(index, at)? {
            Component::U8 => u32::from(u8::MAX),
            Component::U16 => u32::from(u16::MAX),
            _ => u32::MAX,
        };
        if indices.contains(&restart) {
            faults.warn(
                at,
                format!("index {restart} restarts primitives on some hardware; here it is vertex {restart}"),
            );
        }
        Ok(indices)
    }

    fn morph_targets(&self, vertices: Vertices, faults: &mut FaultList) -> Option<Vec<Vec<[f32; 3]>>> {
        let mut out = Some(Vec::new());
        for (number, target) in self.row.targets.iter().enumerate() {
            let at = format!("{}/targets/{number}/POSITION", self.path);
            let read = match target.get("POSITION") {
                Some(accessor) => self
                    .accessors
                    .get(*accessor, &at)
                    .and_then(|row| expect_count(row.count.0, vertices.count, &at))
                    .and_then(|()| self.accessors.floats::<3>(*accessor, Numbers::Quantized, &at)),
                None if !vertices.backed => return None,
                None => self
                    .accessors
                    .charge(vertices.count, size_of::<[f32; 3]>(), &at)
                    .map(|()| vec![[0.0; 3]; vertices.count]),
            };
            match (faults.keep(read), &mut out) {
                (Some(target), Some(targets)) => targets.push(target),
                _ => out = None,
            }
        }
        out
    }
}

/// The name of an attribute as it stands in a JSON pointer below a primitive.
pub(super) fn attribute_path(primitive: &str, name: &str) -> String {
    format!("{primitive}/attributes/{}", escape(name))
}

/// # Errors
/// A fault at `at`: the counts differ.
pub(super) fn expect_count(found: usize, expected: usize, at: &str) -> Result<(), Fault> {
    if found == expected {
        return Ok(());
    }
    Err(Fault::error(
        at,
        format!("{found} elements; expected {expected}, one per vertex"),
    ))
}
