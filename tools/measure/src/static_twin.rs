use crate::MeasureError;
use restpose_bake::{
    BakeReport, BakeSettings, NoProgress, bake,
    import::{Animation, Local, Mesh, Node, Part, Primitive},
};
use restpose_formats::write;
use restpose_runtime::{Asset, Frame, InstanceId};
use std::sync::Arc;

/// A posed frame baked as a mesh that does not move: one tree over tight boxes, of the same kind and by the same
/// builder, traced by the same runtime. What a tree built afresh for this frame would be.
///
/// Guarantee: its triangles are those of the frame, row by row and bit for bit, so hits must be equal too.
pub(crate) struct StaticTwin {
    pub asset: Arc<Asset>,
    pub report: BakeReport,
}

impl StaticTwin {
    /// The twin of an instance of `asset`.
    pub(crate) fn new(frame: &Frame, instance: InstanceId, asset: &Asset) -> Result<Self, MeasureError> {
        let vertices = 0..asset.model().vertices.len().saturating_sub(1) as u32;
        let primitive = Primitive {
            positions: vertices.filter_map(|vertex| frame.vertex(instance, vertex)).collect(),
            triangles: asset.model().triangles.iter().map(|row| row.corners).collect(),
            ..Primitive::default()
        };
        let node = Node {
            name: String::new(),
            parent: None,
            local: Local::Trs {
                translation: [0.0; 3],
                rotation: [0.0, 0.0, 0.0, 1.0],
                scale: [1.0; 3],
            },
            weights: Vec::new(),
        };
        let animation = Animation {
            source_name: "posed frame".to_owned(),
            nodes: vec![node],
            meshes: vec![Mesh {
                primitives: vec![primitive],
                ..Mesh::default()
            }],
            parts: vec![Part {
                name: "posed frame".to_owned(),
                node: 0,
                mesh: 0,
                skin: None,
                cache: None,
            }],
            ..Animation::default()
        };
        let baked = bake(
            &animation,
            &BakeSettings {
                tree: asset.model().meta.tree,
                ..BakeSettings::default()
            },
            &NoProgress,
        )?;
        Ok(Self {
            asset: Arc::new(Asset::from_bytes(&write(&baked.model)?)?),
            report: baked.report,
        })
    }
}
