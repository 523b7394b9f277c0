use crate::{
    BakeSettings,
    import::{Animation, Channel, ChannelTarget, VertexCache},
};
use restpose_formats::rows::{Interpolation, MotionClass};
use std::borrow::Cow;

/// Positions of a cache that is made of morph targets: 3 GiB of them.
const MOST_POSITIONS: usize = 1 << 28;

/// Turns the morph targets of parts into vertex caches, where the user asks for such a class.
///
/// Positions are linear in the weights, so a clip whose weights are interpolated linearly is a vertex cache with a key at
/// each of its key times, exactly but for one rounding to `f32`. The first key is the pose without any clip; the clips'
/// follow. In the file the part then has no morph targets: its weights can no longer be set from elsewhere, a vertex costs
/// two keys instead of all its targets, and its boxes hold at any time. That is why it has to be asked for.
///
/// A part that cannot be turned (it has a skin, a clip moves its weights in steps or by splines, or the cache would have
/// more than [`MOST_POSITIONS`]) is left as it is.
pub(crate) fn with_morph_caches<'a>(
    animation: &'a Animation,
    clips: &[usize],
    settings: &BakeSettings,
) -> Cow<'a, Animation> {
    let asked = |name: &str| {
        let mut of_part = settings.class_overrides.iter().rev().filter(|(part, _)| part == name);
        of_part
            .next()
            .is_some_and(|(_, class)| matches!(class, MotionClass::Keyframed | MotionClass::Free))
    };
    let parts: Vec<usize> = (0..animation.parts.len())
        .filter(|part| asked(&animation.parts[*part].name) && is_linear(animation, clips, *part))
        .collect();
    turned(animation, clips, &parts)
}

/// The same for parts that are known to have been turned.
pub(crate) fn turned<'a>(animation: &'a Animation, clips: &[usize], parts: &[usize]) -> Cow<'a, Animation> {
    if parts.is_empty() {
        return Cow::Borrowed(animation);
    }
    let mut out = animation.clone();
    for part in parts {
        turn(&mut out, clips, *part);
    }
    Cow::Owned(out)
}

/// Channels of the selected clips that move the part's weights, each with its clip.
fn weight_channels<'a>(
    animation: &'a Animation,
    clips: &'a [usize],
    part: usize,
) -> impl Iterator<Item = (usize, &'a Channel)> {
    let node = animation.parts[part].node;
    clips.iter().flat_map(move |clip| {
        let channels = animation.clips[*clip].channels.iter();
        channels
            .filter(move |channel| channel.target == ChannelTarget::Weights && channel.node == node)
            .map(move |channel| (*clip, channel))
    })
}

fn is_linear(animation: &Animation, clips: &[usize], part: usize) -> bool {
    let source = &animation.parts[part];
    let mut channels = weight_channels(animation, clips, part).peekable();
    source.skin.is_none()
        && source.cache.is_none()
        && channels.peek().is_some()
        && channels.all(|(_, channel)| channel.interpolation == Interpolation::Linear)
        && position_count(animation, clips, part).is_some_and(|count| count <= MOST_POSITIONS)
}

fn position_count(animation: &Animation, clips: &[usize], part: usize) -> Option<usize> {
    let keys: usize = weight_channels(animation, clips, part)
        .map(|(_, channel)| channel.times.len())
        .sum();
    let primitives = &animation.meshes[animation.parts[part].mesh].primitives;
    let vertices: usize = primitives.iter().map(|primitive| primitive.positions.len()).sum();
    keys.checked_add(1)?.checked_mul(vertices)
}

fn turn(animation: &mut Animation, clips: &[usize], part: usize) {
    let mut weights = vec![animation.nodes[animation.parts[part].node].weights.clone()];
    let mut played = Vec::new();
    for (clip, channel) in weight_channels(animation, clips, part) {
        let first = weights.len();
        let width = channel.values.len() / channel.times.len();
        weights.extend(channel.values.chunks_exact(width).map(<[f32]>::to_vec));
        played.push((clip, channel.times.clone(), first));
    }
    let cache = animation.caches.len();
    // The part gets a mesh of its own: others may show the same one under morph targets.
    let mut mesh = animation.meshes[animation.parts[part].mesh].clone();
    let mut positions = Vec::new();
    for key in &weights {
        for primitive in &mesh.primitives {
            positions.extend((0..primitive.positions.len()).map(|vertex| {
                let mut p = primitive.positions[vertex].map(f64::from);
                for (target, weight) in primitive.morph_targets.iter().zip(key) {
                    p = std::array::from_fn(|k| p[k] + f64::from(*weight) * f64::from(target[vertex][k]));
                }
                p.map(|x| x as f32)
            }));
        }
    }
    let mut first_point = 0;
    for primitive in &mut mesh.primitives {
        let count = primitive.positions.len();
        primitive.points = (first_point as u32..(first_point + count) as u32).collect();
        primitive
            .positions
            .copy_from_slice(&positions[first_point..first_point + count]);
        primitive.morph_targets.clear();
        first_point += count;
    }
    mesh.morph_target_count = 0;
    animation.caches.push(VertexCache {
        point_count: first_point,
        positions,
    });
    animation.parts[part].cache = Some(cache);
    animation.parts[part].mesh = animation.meshes.len();
    animation.meshes.push(mesh);
    for (clip, times, first) in played {
        let values = (first..first + times.len()).map(|frame| frame as f32).collect();
        animation.clips[clip].channels.push(Channel {
            node: cache,
            target: ChannelTarget::Frame,
            interpolation: Interpolation::Linear,
            times,
            values,
        });
    }
}
