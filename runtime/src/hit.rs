/// An instance in a [`Scene`](crate::Scene). One that was removed has no namesake later, though its index is used again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct InstanceId {
    pub(crate) index: u32,
    /// How often the index was used before.
    pub(crate) generation: u32,
}

impl InstanceId {
    /// Its place in the scene: the lowest that was free when it was added. Of two hits at the same distance the one with
    /// the lower index counts.
    #[must_use]
    pub fn index(self) -> usize {
        self.index as usize
    }
}

/// Where a ray meets a triangle.
///
/// The point is `(1 − u − v)·A + u·B + v·C` for the triangle's posed corners A, B, C.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Ray parameter.
    pub t: f32,
    /// Weight of the second corner.
    pub u: f32,
    /// Weight of the third corner.
    pub v: f32,
    /// Instance that was hit.
    pub instance: InstanceId,
    /// Triangle row of the instance's asset.
    pub triangle: u32,
}

impl Hit {
    /// The order that decides between hits: nearer first, then lower instance, then lower triangle.
    pub(crate) fn is_before(&self, other: &Self) -> bool {
        self.t < other.t || (self.t == other.t && (self.instance, self.triangle) < (other.instance, other.triangle))
    }
}
