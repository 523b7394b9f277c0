use bytemuck::{Pod, Zeroable};

/// The pose space of a cluster without a track: envelopes, each a set of poses, for all of which its fuzzy boxes hold.
///
/// Of all poses of the bones that move the cluster's vertices only their motion against the cluster's own bone matters.
/// With X the map of that bone and Xᵢ that of another, a pivot k and R = X⁻¹·Xᵢ = (A | b), a vertex p is displaced by
/// (R − 1)·p = (A − 1)·(p − k) + d with d = (A − 1)·k + b. The *relative motion* of the bone is the twelve numbers of
/// A − 1, columns first, and d.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct PoseSpaceRow {
    /// Envelopes, at least 1; 1 where the cluster has neither a bone beside its own nor a morph.
    pub envelope_count: u32,
    /// First bone-envelope row of `envelope_count` times as many as the cluster has bones beside its own: those of the
    /// first envelope in the order of the cluster's bones, then those of the second, and so on.
    pub bone_envelope_first: u32,
    /// First cluster-morph row.
    pub morph_first: u32,
    /// Cluster-morph rows: the morph targets that displace vertices of the cluster.
    pub morph_count: u32,
    /// First morph-envelope row of `envelope_count · morph_count`, ordered alike.
    pub morph_envelope_first: u32,
    /// 1 where every pose of the file's clips, at every time, and the one without any clip lies in an envelope, their palettes as
    /// rounded to `f32` in exact arithmetic; 0 where that is not known.
    pub clips_inside: u32,
    /// Zero.
    pub reserved: [u32; 2],
}

/// By how much a bone can displace vertices of a cluster: one row per cluster-bone row of a cluster without a track. Zero
/// for the cluster's own bone.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct LeverRow {
    /// k: the point about which the bone moves against the cluster, rest space.
    pub pivot: [f32; 3],
    /// At least the largest [`Self::arm`] per axis over the cluster's vertices that the bone moves.
    pub lever: [f32; 3],
    /// At least the largest weight with which the bone moves one of these; at most one.
    pub weight: f32,
    /// Zero.
    pub reserved: u32,
}

impl LeverRow {
    /// `w·|position_rest − pivot|` per axis, for a vertex that the bone moves with weight w: rest space, each of the two
    /// operations rounded to nearest in `f64`.
    ///
    /// Guarantee: no weight of a checked file and no finite numbers make it overflow or underflow, so it is within two
    /// roundings of the exact length.
    #[inline]
    #[must_use]
    pub fn arm(&self, position_rest: [f32; 3], weight: f32) -> [f64; 3] {
        std::array::from_fn(|k| f64::from(weight) * (f64::from(position_rest[k]) - f64::from(self.pivot[k])).abs())
    }
}

/// A morph target that displaces vertices of a cluster.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ClusterMorphRow {
    /// Morph target row.
    pub target: u32,
    /// At least the largest `|delta|` per axis over the cluster's vertices.
    pub extent: [f32; 3],
}

/// The relative motion of one bone in one envelope: all numbers within `reach` of `center + α·direction`, with one α in
/// [−1, 1] for all bones of the envelope.
///
/// A set of this form is an affine form with one shared symbol: motion along a path stays close to a line for a while,
/// and its twelve numbers do not move independently of each other.
///
/// Source: Günther, *Ray Tracing of Dynamic Scenes*, §3.6, wishes for boxes by affine arithmetic in place of samples.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct BoneEnvelopeRow {
    /// Middle of the line.
    pub center: [f32; 12],
    /// From the middle to its end.
    pub direction: [f32; 12],
    /// Not negative.
    pub reach: [f32; 12],
}

/// The weights of one morph target in one envelope.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct MorphEnvelopeRow {
    /// Least weight.
    pub min: f32,
    /// Greatest weight.
    pub max: f32,
}
