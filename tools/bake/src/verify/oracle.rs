use restpose_runtime::{Frame, Hit, InstanceId, Ray, triangle::PreparedRay};

/// Brute force: every triangle of some instances, posed first, tested one after the other in order.
///
/// Uses the runtime's own vertex function and triangle test and nothing else of it, so an accelerated hit can be
/// compared with its hits bit for bit.
pub struct Oracle {
    triangles: Vec<(InstanceId, u32, [[f32; 3]; 3])>,
}

impl Oracle {
    /// Poses every triangle of `instances`, which ascend.
    #[must_use]
    pub fn new(frame: &Frame, instances: &[InstanceId]) -> Self {
        let mut triangles = Vec::new();
        for instance in instances {
            for triangle in 0u32.. {
                let Some(corners) = frame.triangle(*instance, triangle) else {
                    break;
                };
                triangles.push((*instance, triangle, corners));
            }
        }
        Self { triangles }
    }

    /// The hit with the least `t`; of equals the first, which has the lowest instance and triangle.
    #[must_use]
    pub fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        let prepared = PreparedRay::new(ray)?;
        let mut best: Option<Hit> = None;
        for (instance, triangle, corners) in &self.triangles {
            if let Some(found) = prepared.intersect(corners)
                && best.as_ref().is_none_or(|best| found.t < best.t)
            {
                let (instance, triangle) = (*instance, *triangle);
                best = Some(Hit {
                    t: found.t,
                    u: found.u,
                    v: found.v,
                    instance,
                    triangle,
                });
            }
        }
        best
    }

    /// Posed triangles, degenerate ones included.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// Corners of a posed triangle, by position.
    pub(super) fn corners(&self, index: usize) -> [[f32; 3]; 3] {
        self.triangles[index].2
    }
}
