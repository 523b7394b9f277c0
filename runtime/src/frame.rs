use crate::{
    Aabb, FrameStats, Hit, InstanceId, InstanceState, PoseError, Ray, Scene, SurfacePoint, TraceCounters,
    cluster_frame::Way,
    excess::Motions,
    instance::Instance,
    trace::{Answer, RayOrder, TraceContext, place, trace, trace_among, trace_sorted, trace_together},
    wide::PACKET,
};

/// Rays of a batch that one task traces.
#[cfg(feature = "parallel")]
const RAYS_PER_TASK: usize = 256;

/// Rays that are sorted at once, 2¹⁸: what that takes, some 10 MiB, stays bounded, and tasks are many.
const RAYS_SORTED: usize = 1 << 18;

// A packet of rays is in one task, which alone says which of its rays go alone.
#[cfg(feature = "parallel")]
const _: () = assert!(RAYS_PER_TASK.is_multiple_of(PACKET));
const _: () = assert!(RAYS_SORTED.is_multiple_of(PACKET));

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
    /// Whether the cluster has a local space in this pose: false where its frame has no usable inverse, between two keys
    /// where a cluster of a vertex cache turns over or collapses, and in free motion.
    pub has_inverse: bool,
}

impl Frame<'_> {
    /// The hit with the least `t` in the ray's range; of equals the one with the lowest instance, then triangle.
    #[must_use]
    pub fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        TraceContext::with(|context| trace::<false>(self.scene, ray, 0.0, context, &mut ()))
    }

    /// Whether anything is hit in the ray's range: `closest_hit(ray).is_some()`, found sooner.
    #[must_use]
    pub fn any_hit(&self, ray: &Ray) -> bool {
        TraceContext::with(|context| trace::<true>(self.scene, ray, 0.0, context, &mut ())).is_some()
    }

    /// [`Frame::closest_hit`], counting what it does.
    #[must_use]
    pub fn closest_hit_counted(&self, ray: &Ray, counters: &mut TraceCounters) -> Option<Hit> {
        TraceContext::with(|context| trace::<false>(self.scene, ray, 0.0, context, counters))
    }

    /// [`Frame::closest_hit`] among the instances for which `accept` is true: a shot passes through who fires it.
    #[must_use]
    pub fn closest_hit_among(&self, ray: &Ray, accept: impl Fn(InstanceId) -> bool) -> Option<Hit> {
        TraceContext::with(|context| trace_among::<false>(self.scene, ray, 0.0, &accept, context, &mut ()))
    }

    /// [`Frame::any_hit`] among the instances for which `accept` is true.
    #[must_use]
    pub fn any_hit_among(&self, ray: &Ray, accept: impl Fn(InstanceId) -> bool) -> bool {
        TraceContext::with(|context| trace_among::<true>(self.scene, ray, 0.0, &accept, context, &mut ())).is_some()
    }

    /// [`Frame::closest_hit`] at a time of the interval in which instances move ([`Scene::set_motion`]): 0 is its begin, 1 its
    /// end, times outside of it count as these. A NaN hits nothing.
    ///
    /// Guarantee: the hit is that of a frame in which each instance has the state that [`Frame::state_at`] tells.
    #[must_use]
    pub fn closest_hit_at(&self, ray: &Ray, time: f32) -> Option<Hit> {
        TraceContext::with(|context| self.at::<Option<Hit>>(ray, time, context))
    }

    /// [`Frame::any_hit`] at a time, as [`Frame::closest_hit_at`].
    #[must_use]
    pub fn any_hit_at(&self, ray: &Ray, time: f32) -> bool {
        TraceContext::with(|context| self.at::<bool>(ray, time, context))
    }

    /// [`Frame::closest_hit_at`] of many rays, each with its time, on all cores (feature `parallel`). Fastest where rays of
    /// the same time follow each other.
    ///
    /// # Panics
    /// When the slices differ in length.
    pub fn closest_hits_at(&self, rays: &[Ray], times: &[f32], hits: &mut [Option<Hit>]) {
        self.batch_at(rays, times, hits);
    }

    /// [`Frame::any_hit_at`] of many rays, as [`Frame::closest_hits_at`].
    ///
    /// # Panics
    /// When the slices differ in length.
    pub fn any_hits_at(&self, rays: &[Ray], times: &[f32], occluded: &mut [bool]) {
        self.batch_at(rays, times, occluded);
    }

    fn batch_at<A: Answer>(&self, rays: &[Ray], times: &[f32], answers: &mut [A]) {
        assert_eq!(rays.len(), times.len(), "one time per ray");
        self.in_tasks(rays.len(), answers, |first, answers, context| {
            for (at, answer) in (first..).zip(answers) {
                *answer = self.at(&rays[at], times[at], context);
            }
        });
    }

    fn at<A: Answer>(&self, ray: &Ray, time: f32, context: &mut TraceContext) -> A {
        if time.is_nan() {
            return A::of(None);
        }
        A::of(A::find(self.scene, ray, time.clamp(0.0, 1.0), context))
    }

    /// The state of an instance at a time of the interval in which it moves.
    ///
    /// # Errors
    /// [`PoseError::UnknownInstance`], [`PoseError::NoAsset`].
    pub fn state_at(&self, instance: InstanceId, time: f32) -> Result<InstanceState, PoseError> {
        Ok(self.scene.asset_instance(instance)?.state_at(time.clamp(0.0, 1.0)))
    }

    /// [`Frame::closest_hit`] of many rays, on all cores (feature `parallel`). Fastest where rays that follow each other are
    /// alike, as those of a picture's tiles of eight by eight pixels.
    ///
    /// # Panics
    /// When the slices differ in length.
    pub fn closest_hits(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        self.batch(rays, hits);
    }

    /// [`Frame::any_hit`] of many rays, on all cores (feature `parallel`).
    ///
    /// # Panics
    /// When the slices differ in length.
    pub fn any_hits(&self, rays: &[Ray], occluded: &mut [bool]) {
        self.batch(rays, occluded);
    }

    /// Coherent rays first, then those that are in no bundle in an order of their own.
    fn batch<A: Answer>(&self, rays: &[Ray], answers: &mut [A]) {
        assert_eq!(rays.len(), answers.len(), "one answer per ray");
        for (rays, answers) in rays.chunks(RAYS_SORTED).zip(answers.chunks_mut(RAYS_SORTED)) {
            RayOrder::with(|order| {
                order.begin(rays.len());
                self.in_tasks(rays.len(), answers, |first, answers, context| {
                    trace_together(self.scene, &rays[first..], answers, context, |place, alone| {
                        order.leave(first + place, alone)
                    });
                });
                order.sort(rays, &self.bounds());
                let (keys, hits) = order.sorted();
                self.in_tasks(keys.len(), hits, |first, hits, context| {
                    trace_sorted::<A>(self.scene, rays, &keys[first..], hits, context);
                });
                for (key, hit) in keys.iter().zip(hits) {
                    answers[place(*key)] = A::of(*hit);
                }
            });
        }
    }

    /// Runs `task` for the answers from its first on.
    fn in_tasks<A: Send>(
        &self,
        rays: usize,
        answers: &mut [A],
        task: impl Fn(usize, &mut [A], &mut TraceContext) + Sync,
    ) {
        assert_eq!(rays, answers.len(), "one answer per ray");
        #[cfg(feature = "parallel")]
        {
            use rayon::prelude::*;
            let tasks = answers.par_chunks_mut(RAYS_PER_TASK).enumerate();
            tasks.for_each(|(place, answers)| {
                TraceContext::with(|context| task(place * RAYS_PER_TASK, answers, context));
            });
        }
        #[cfg(not(feature = "parallel"))]
        TraceContext::with(|context| task(0, answers, context));
    }

    /// Prepares all of every instance that rays could need but posed vertices, which is what the first rays to come would
    /// do: for those who want no ray to take longer than others, or all of [`Frame::stats`]. On all cores (feature
    /// `parallel`).
    pub fn prepare(&self) {
        let one = |instance: &Instance| {
            if let Instance::Asset(instance) = instance {
                let mut motions = Motions::default();
                let prepared = instance.prepared();
                for slot in 0..prepared.clusters.len() as u32 {
                    prepared.cluster(instance.asset(), slot, &mut motions);
                }
            }
        };
        #[cfg(feature = "parallel")]
        {
            use rayon::prelude::*;
            self.scene
                .occupied()
                .par_bridge()
                .for_each(|(_, instance)| one(instance));
        }
        #[cfg(not(feature = "parallel"))]
        self.scene.occupied().for_each(|(_, instance)| one(instance));
    }

    /// What was hit, in the source's words; of a hit at a time see [`Frame::surface_at`].
    ///
    /// # Errors
    /// [`PoseError::UnknownInstance`] for a hit whose instance was removed since, [`PoseError::UnknownTriangle`] for a triangle
    /// that the instance does not have. A hit of another scene may name an instance that this one has, too.
    pub fn surface(&self, hit: &Hit) -> Result<SurfacePoint, PoseError> {
        self.surface_at(hit, 0.0)
    }

    /// What was hit at a time of the interval in which instances move, where it was then. A NaN counts as the begin.
    ///
    /// # Errors
    /// As [`Frame::surface`].
    pub fn surface_at(&self, hit: &Hit, time: f32) -> Result<SurfacePoint, PoseError> {
        SurfacePoint::new(hit, self.scene.instance(hit.instance)?, |instance, cache, triangle| {
            let model = instance.asset().model();
            TraceContext::with(|context| {
                let prepared = context.prepared_at(self.scene, hit.instance, instance, time.clamp(0.0, 1.0));
                prepared.recomputed_triangle(model, cache, triangle)
            })
        })
    }

    /// A posed vertex in world space, by vertex row; `None` when there is no such instance or vertex.
    #[must_use]
    pub fn vertex(&self, instance: InstanceId, vertex: u32) -> Option<[f32; 3]> {
        self.scene.instance(instance).ok()?.vertex(vertex)
    }

    /// All posed vertices of an instance in world space, in place of what is in `vertices`: for those who need them
    /// anyway, to draw them say. On all cores (feature `parallel`).
    ///
    /// # Errors
    /// [`PoseError::UnknownInstance`].
    pub fn vertices(&self, instance: InstanceId, vertices: &mut Vec<[f32; 3]>) -> Result<(), PoseError> {
        self.scene.instance(instance)?.vertices(vertices);
        Ok(())
    }

    /// A posed triangle's corners in world space, by triangle row; `None` when there is no such instance or triangle.
    #[must_use]
    pub fn triangle(&self, instance: InstanceId, triangle: u32) -> Option<[[f32; 3]; 3]> {
        self.scene.instance(instance).ok()?.triangle(triangle)
    }

    /// The clusters of all instances of assets with their world boxes. Prepares them as [`Frame::prepare`] does.
    pub fn clusters(&self) -> impl Iterator<Item = ClusterBounds> {
        let scene = self.scene;
        scene.occupied().flat_map(move |(index, instance)| {
            let mut motions = Motions::default();
            let clusters = match instance {
                Instance::Asset(instance) => instance.prepared().clusters.len() as u32,
                Instance::Geometry(_) => 0,
            };
            (0..clusters).filter_map(move |slot| {
                let Instance::Asset(instance) = instance else {
                    return None;
                };
                let (state, posed) = instance.prepared().cluster(instance.asset(), slot, &mut motions);
                Some(ClusterBounds {
                    instance: scene.id(index),
                    cluster: state.row,
                    bounds_world: posed.frame.bounds_world,
                    excess: posed.excess.local,
                    has_inverse: matches!(posed.frame.way, Way::Local(_)),
                })
            })
        })
    }

    /// A box that contains every posed vertex that some triangle with area uses.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.scene.top_level.bounds()
    }

    /// The same of one instance.
    ///
    /// # Errors
    /// [`PoseError::UnknownInstance`].
    pub fn instance_bounds(&self, instance: InstanceId) -> Result<Aabb, PoseError> {
        self.scene.instance(instance).map(Instance::bounds)
    }

    /// What this frame holds, and what rays have needed of it so far.
    #[must_use]
    pub fn stats(&self) -> FrameStats {
        let mut stats = FrameStats {
            top_level_nodes: self.scene.top_level.nodes().len() as u32,
            ..FrameStats::default()
        };
        for (_, instance) in self.scene.occupied() {
            stats.instances += 1;
            match instance {
                Instance::Asset(instance) => {
                    if let Some(prepared) = instance.prepared_so_far() {
                        stats.add(prepared);
                    }
                }
                Instance::Geometry(_) => {
                    stats.clusters += 1;
                    stats.clusters_rebuilt += 1;
                }
            }
        }
        stats
    }
}
