use crate::poses::SampledPose;
use restpose_formats::Model;

/// Positions of one vertex in all samples, asset space, in `f64` from the numbers that the runtime poses with.
///
/// The same function as the runtime's vertex function but for its rounding, which the run-time margin covers.
pub(crate) fn vertex_track(model: &Model, poses: &[&SampledPose], vertex: usize, track: &mut Vec<[f64; 3]>) {
    let rest = model.vertices[vertex].position_rest.map(f64::from);
    let deltas = model.morph_deltas_of(vertex);
    let influences = model.influences_of(vertex);
    track.clear();
    track.extend(poses.iter().map(|pose| {
        let mut p = rest;
        for delta in deltas {
            let weight = f64::from(pose.morph_weights[delta.target as usize]);
            p = std::array::from_fn(|k| p[k] + weight * f64::from(delta.delta[k]));
        }
        let mut sum = [0.0; 3];
        for influence in influences {
            let c = &pose.palette[influence.bone as usize].columns;
            let weight = f64::from(influence.weight);
            for k in 0..3 {
                let at = |j: usize| f64::from(c[j][k]);
                sum[k] += weight * (at(0) * p[0] + at(1) * p[1] + at(2) * p[2] + at(3));
            }
        }
        sum
    }));
}
