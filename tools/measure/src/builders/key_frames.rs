use super::scenes::Triangle;
use restpose_bake::import::{Animation, ChannelTarget, Local, Part};

const IDENTITY: Local = Local::Trs {
    translation: [0.0; 3],
    rotation: [0.0, 0.0, 0.0, 1.0],
    scale: [1.0; 3],
};

/// The triangles of a source that nothing moves but vertex caches, in up to `most` frames of these, as they stand in the
/// source; one where there is no cache. `None` where anything else moves vertices.
pub(super) fn key_frames(animation: &Animation, most: usize) -> Option<Vec<Vec<Triangle>>> {
    let mut channels = animation.clips.iter().flat_map(|clip| &clip.channels);
    let only_caches = channels.all(|channel| channel.target == ChannelTarget::Frame)
        && animation.skins.is_empty()
        && animation
            .nodes
            .iter()
            .all(|node| node.local == IDENTITY && node.weights.is_empty());
    if !only_caches {
        return None;
    }
    let frames = animation.caches.iter().map(|cache| cache.frame_count()).max();
    let frames = frames.unwrap_or(1).min(most);
    Some((0..frames).map(|frame| triangles(animation, frame)).collect())
}

fn triangles(animation: &Animation, frame: usize) -> Vec<Triangle> {
    let mut out = Vec::new();
    for Part { mesh, cache, .. } in &animation.parts {
        let cached = cache.map(|cache| {
            let cache = &animation.caches[cache];
            cache.frame(frame.min(cache.frame_count() - 1))
        });
        for primitive in &animation.meshes[*mesh].primitives {
            let vertex = |vertex: u32| match cached {
                Some(positions) => positions[primitive.points[vertex as usize] as usize],
                None => primitive.positions[vertex as usize],
            };
            out.extend(primitive.triangles.iter().map(|corners| corners.map(vertex)));
        }
    }
    out
}
