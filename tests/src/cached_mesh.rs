use restpose_bake::import::{Animation, Channel, ChannelTarget, Clip, Local, Mesh, Node, Part, Primitive, VertexCache};
use restpose_formats::rows::Interpolation;

/// A mesh under a vertex cache, one frame per second: `frames[f][v]` is where vertex v is in frame f.
///
/// # Panics
/// Without frames.
#[must_use]
pub fn cached_mesh(triangles: &[[u32; 3]], frames: &[Vec<[f32; 3]>]) -> Animation {
    let last = frames.len() - 1;
    let points = frames[0].len();
    Animation {
        source_name: "cached mesh".to_owned(),
        nodes: vec![Node {
            name: "mesh".to_owned(),
            parent: None,
            local: Local::Trs {
                translation: [0.0; 3],
                rotation: [0.0, 0.0, 0.0, 1.0],
                scale: [1.0; 3],
            },
            weights: Vec::new(),
        }],
        meshes: vec![Mesh {
            name: "mesh".to_owned(),
            primitives: vec![Primitive {
                positions: frames[0].clone(),
                triangles: triangles.to_vec(),
                points: (0..points as u32).collect(),
                ..Primitive::default()
            }],
            morph_target_count: 0,
        }],
        clips: vec![Clip {
            name: "play".to_owned(),
            channels: vec![Channel {
                node: 0,
                target: ChannelTarget::Frame,
                interpolation: Interpolation::Linear,
                times: (0..=last).map(|frame| frame as f32).collect(),
                values: (0..=last).map(|frame| frame as f32).collect(),
            }],
        }],
        parts: vec![Part {
            name: "mesh".to_owned(),
            node: 0,
            mesh: 0,
            skin: None,
            cache: Some(0),
        }],
        caches: vec![VertexCache {
            point_count: points,
            positions: frames.concat(),
        }],
        ..Animation::default()
    }
}
