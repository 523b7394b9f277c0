use crate::{
    Aabb, FrameStats, Hit, InstanceId, Ray, Scene, SurfacePoint, TraceCounters,
    cluster_frame::Way,
    instance::Instance,
    trace::{Stack, trace},
};

/// Rays of a batch that one task traces.
#[cfg(feature = "parallel")]
const RAYS_PER_TASK: usize = 256;

/// A scene that is ready for rays. Copy it freely; any number of threads may trace it at once.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    pub(crate) scene: &'a Scene,
}

/// A cluster in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClusterBounds {
    /// Instance.
    pub instance: InstanceId,
    /// Cluster row of the instance's asset.
    pub cluster: u32,
    /// Contains every posed vertex of the cluster.
    pub bounds_world: Aabb,
    /// By how much its boxes are widened, per local axis in rest space, for a pose outside the pose space that they were
    /// made for; inside it is what rounding adds, and zero with sampled bounds.
    pub excess: [f64; 3],
    /// Whether the cluster has a local space in this pose: false where its frame has no usable inverse, and in free motion.
    pub has_inverse: bool,
}

impl Frame<'_> {
    /// The hit with the least `t` in the ray's range; of equals the one with the lowest instance, then triangle.
    #[must_use]
    pub fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        trace::<false>(self.scene, ray, &mut Stack::new(), &mut ())
    }

    /// Whether anything is hit in the ray's range: `closest_hit(ray).is_some()`, found sooner.
    #[must_use]
    pub fn any_hit(&self, ray: &Ray) -> bool {
        trace::<true>(self.scene, ray, &mut Stack::new(), &mut ()).is_some()
    }

    /// [`Frame::closest_hit`], counting what it does.
    #[must_use]
    pub fn closest_hit_counted(&self, ray: &Ray, counters: &mut TraceCounters) -> Option<Hit> {
        trace::<false>(self.scene, ray, &mut Stack::new(), counters)
    }

    /// [`Frame::closest_hit`] of many rays, on all cores (feature `parallel`).
    ///
    /// # Panics
    /// When the slices differ in length.
    pub fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        self.batch(rays, hits, |ray, stack| trace::<false>(self.scene, ray, stack, &mut ()));
    }

    /// [`Frame::any_hit`] of many rays, on all cores (feature `parallel`).
    ///
    /// # Panics
    /// When the slices differ in length.
    pub fn any_hits(&self, rays: &[Ray], occluded: &mut [bool]) {
        self.batch(rays, occluded, |ray, stack| {
            trace::<true>(self.scene, ray, stack, &mut ()).is_some()
        });
    }

    fn batch<T: Send>(&self, rays: &[Ray], results: &mut [T], one: impl Fn(&Ray, &mut Stack) -> T + Sync) {
        assert_eq!(rays.len(), results.len(), "one result per ray");
        let run = |rays: &[Ray], results: &mut [T]| {
            let mut stack = Stack::new();
            for (ray, result) in rays.iter().zip(results) {
                *result = one(ray, &mut stack);
            }
        };
        #[cfg(feature = "parallel")]
        {
            use rayon::prelude::*;
            rays.par_chunks(RAYS_PER_TASK)
                .zip(results.par_chunks_mut(RAYS_PER_TASK))
                .for_each(|(rays, results)| run(rays, results));
        }
        #[cfg(not(feature = "parallel"))]
        run(rays, results);
    }

    /// What was hit, in the source's words.
    ///
    /// # Panics
    /// When the hit is not from this scene and names an instance or triangle that it does not have.
    #[must_use]
    pub fn surface(&self, hit: &Hit) -> SurfacePoint {
        SurfacePoint::new(hit, &self.scene.instances[hit.instance.index()])
    }

    /// A posed vertex in world space, by vertex row; `None` when there is no such instance or vertex.
    #[must_use]
    pub fn vertex(&self, instance: InstanceId, vertex: u32) -> Option<[f32; 3]> {
        self.scene.instances.get(instance.index())?.vertex(vertex)
    }

    /// A posed triangle's corners in world space, by triangle row; `None` when there is no such instance or triangle.
    #[must_use]
    pub fn triangle(&self, instance: InstanceId, triangle: u32) -> Option<[[f32; 3]; 3]> {
        self.scene.instances.get(instance.index())?.triangle(triangle)
    }

    /// The clusters of all instances of assets with their world boxes.
    pub fn clusters(&self) -> impl Iterator<Item = ClusterBounds> {
        self.scene.entries.iter().filter_map(|entry| {
            let Instance::Asset(instance) = &self.scene.instances[entry.instance as usize] else {
                return None;
            };
            let active = &instance.clusters[entry.slot as usize];
            Some(ClusterBounds {
                instance: InstanceId(entry.instance),
                cluster: active.row,
                bounds_world: active.frame.bounds_world,
                excess: active.excess.local,
                has_inverse: matches!(active.frame.way, Way::Local(_)),
            })
        })
    }

    /// A box that contains every posed vertex that some triangle with area uses.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.scene
            .boxes
            .iter()
            .fold(Aabb::EMPTY, |bounds, other| bounds.union(*other))
    }

    /// What this frame holds.
    #[must_use]
    pub fn stats(&self) -> &FrameStats {
        &self.scene.stats
    }
}
