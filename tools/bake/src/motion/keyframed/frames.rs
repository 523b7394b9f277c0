use super::{fit::Map, members::Members, rigid::rounded, states::States, tracks::Track};
use glam::{DMat3, DVec3};
use restpose_formats::geom::Affine;
use restpose_runtime::invert_frame;

/// A track in scene units and the other way round: part space from local space, as numbers of the file.
///
/// The local origin is moved to the centroid of the cluster's points in the rest key, so that its boxes keep their
/// digits wherever the cluster is.
///
/// Guarantee: every map is accepted by [`invert_frame`].
pub(super) fn frames_of(states: &States, members: &Members, track: &Track, rest_key: usize) -> Vec<Affine> {
    let total: f64 = members.weights.iter().sum();
    let sum = members
        .points
        .iter()
        .zip(&members.weights)
        .fold(DVec3::ZERO, |sum, (point, weight)| {
            sum + track[rest_key].apply(states.position(rest_key, *point as usize)) * *weight
        });
    let origin = if total > 0.0 { sum / total } else { DVec3::ZERO };
    let mut usable = DMat3::IDENTITY;
    track
        .iter()
        .zip(&states.centres)
        .map(|(map, centre)| {
            let linear = map.linear.inverse();
            let offset = *centre + linear * (origin - map.offset) * states.unit;
            let frame = rounded(&Map { linear, offset });
            if invert_frame(&frame).is_some() {
                usable = linear;
                return frame;
            }
            rounded(&Map {
                linear: usable,
                offset: if offset.is_finite() { offset } else { *centre },
            })
        })
        .collect()
}
