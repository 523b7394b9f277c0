use crate::import::{Animation, Channel, ChannelTarget, Local};
use restpose_formats::rows::Interpolation;

/// What the selected clips, or the pose space, move: nodes, with everything below them, and morph weights.
pub(crate) struct Moving {
    /// Per node: whether its world transform is not always the same.
    pub nodes: Vec<bool>,
    /// Per node: whether its morph weights do.
    pub morphs: Vec<bool>,
}

impl Moving {
    pub(crate) fn new(animation: &Animation, clips: &[usize]) -> Self {
        let mut nodes = vec![false; animation.nodes.len()];
        let mut morphs = nodes.clone();
        for channel in clips.iter().flat_map(|clip| &animation.clips[*clip].channels) {
            if holds_still(animation, channel) {
                continue;
            }
            match channel.target {
                ChannelTarget::Frame => {}
                ChannelTarget::Weights => morphs[channel.node] = true,
                _ => nodes[channel.node] = true,
            }
        }
        let mut moving = Self { nodes, morphs };
        moving.spread(animation);
        moving
    }

    /// Every joint of a skin moves, and what hangs on it: the pose space turns them.
    pub(crate) fn turn_joints(&mut self, animation: &Animation) {
        let skins = animation.parts.iter().filter_map(|part| part.skin);
        for joint in skins.flat_map(|skin| &animation.skins[skin].joints) {
            self.nodes[*joint] = true;
        }
        self.spread(animation);
    }

    /// From parents to all below them.
    fn spread(&mut self, animation: &Animation) {
        for node in parents_first(animation) {
            if let Some(parent) = animation.nodes[node].parent {
                self.nodes[node] |= self.nodes[parent];
            }
        }
    }
}

/// All nodes, each after its parent, in ascending order among those of one depth. Linear, without recursion: source
/// files may hold chains of any length.
pub(crate) fn parents_first(animation: &Animation) -> Vec<usize> {
    let mut depths = vec![None; animation.nodes.len()];
    let mut path = Vec::new();
    for start in 0..depths.len() {
        let mut next = Some(start);
        while let Some(node) = next.filter(|node| depths[*node].is_none()) {
            path.push(node);
            next = animation.nodes[node].parent;
        }
        let mut depth = next.and_then(|node| depths[node]).map_or(0usize, |depth| depth + 1);
        while let Some(node) = path.pop() {
            depths[node] = Some(depth);
            depth += 1;
        }
    }
    let mut order: Vec<usize> = (0..depths.len()).collect();
    order.sort_by_key(|node| depths[*node]);
    order
}

/// True when a channel only repeats what the node has without it.
fn holds_still(animation: &Animation, channel: &Channel) -> bool {
    if channel.target == ChannelTarget::Frame {
        return channel.values.iter().all(|frame| *frame == 0.0);
    }
    let node = &animation.nodes[channel.node];
    let unset: &[f32] = match (&node.local, channel.target) {
        (_, ChannelTarget::Weights) => &node.weights,
        (Local::Trs { translation, .. }, ChannelTarget::Translation) => translation,
        (Local::Trs { rotation, .. }, ChannelTarget::Rotation) => rotation,
        (Local::Trs { scale, .. }, ChannelTarget::Scale) => scale,
        (Local::Matrix(_), _) | (_, ChannelTarget::Frame) => return false,
    };
    if unset.is_empty() {
        return true;
    }
    channel.values.chunks(unset.len()).enumerate().all(|(chunk, values)| {
        let tangent = channel.interpolation == Interpolation::CubicSpline && chunk % 3 != 1;
        if tangent {
            values.iter().all(|x| *x == 0.0)
        } else {
            values == unset
        }
    })
}
