use super::{
    Animation, Channel, ChannelTarget, Clip, Imported, Local, Node, VertexCache,
    fault_list::FaultList,
    obj::{mesh::ObjMesh, parts},
    timeline::Timeline,
};
use restpose_formats::rows::Interpolation;

/// What an OBJ mesh and the frames of it are called, and where from.
#[derive(Debug)]
pub(super) struct Origin {
    /// File name of the source.
    pub source_name: String,
    /// BLAKE3 of what was read.
    pub source_hash: [u8; 32],
    /// Name of the node.
    pub node_name: String,
}

/// Frames that move an OBJ mesh.
#[derive(Debug)]
pub(super) struct Motion {
    /// Name of the clip.
    pub clip_name: String,
    /// When the frames are.
    pub timeline: Timeline,
    /// Points of a frame, as many as the mesh has.
    pub point_count: usize,
    /// Frame after frame, at least one.
    pub positions: Vec<[f32; 3]>,
}

/// The scene: one node, a part per group, and the frames as one vertex cache and one clip. A single frame is no motion:
/// it is the mesh, with a warning.
pub(super) fn scene(origin: Origin, mesh: &ObjMesh, motion: Option<Motion>, mut faults: FaultList) -> Imported {
    let mut animation = Animation {
        source_name: origin.source_name,
        source_hash: origin.source_hash,
        nodes: vec![Node {
            name: origin.node_name,
            parent: None,
            local: Local::Trs {
                translation: [0.0; 3],
                rotation: [0.0, 0.0, 0.0, 1.0],
                scale: [1.0; 3],
            },
            weights: Vec::new(),
        }],
        ..Animation::default()
    };
    let Some(motion) = motion else {
        (animation.meshes, animation.parts) = parts::build(mesh, &mesh.positions, None);
        return Imported {
            animation,
            faults: faults.into_faults(),
        };
    };
    animation.import_options = motion.timeline.options;
    let point_count = motion.point_count;
    let frame_count = motion.positions.len() / point_count.max(1);
    let rest = motion.positions.get(..point_count).unwrap_or_default();
    if frame_count == 1 {
        faults.warn("", "only one frame is there or kept; the mesh is static");
        (animation.meshes, animation.parts) = parts::build(mesh, rest, None);
    } else {
        (animation.meshes, animation.parts) = parts::build(mesh, rest, Some(0));
        animation.clips = vec![Clip {
            name: motion.clip_name,
            channels: vec![Channel {
                node: 0,
                target: ChannelTarget::Frame,
                interpolation: Interpolation::Linear,
                times: motion.timeline.times,
                values: (0..frame_count).map(|frame| frame as f32).collect(),
            }],
        }];
        animation.caches = vec![VertexCache {
            point_count,
            positions: motion.positions,
        }];
    }
    Imported {
        animation,
        faults: faults.into_faults(),
    }
}
