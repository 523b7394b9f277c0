use crate::{
    Aabb, Asset, Pose, PoseEvaluator, Posing,
    instance_state::{InstanceState, PoseSource},
    motion::Motion,
    motion_bounds::motion_bounds,
    posed_bounds::{BoundedPose, morph_extent, posed_bounds},
    posing::{Expected, PosingLimits},
    prepared::{Prepared, PreparedPool},
};
use restpose_formats::ModelView;
use std::sync::{Arc, OnceLock};

/// An instance of an asset: what the caller set, and what rays have needed of it since.
#[derive(Debug)]
pub(crate) struct AssetInstance {
    pool: Arc<PreparedPool>,
    pub state: InstanceState,
    /// Memory for a pose of the caller's, from when it had one.
    spare_pose: Option<Arc<Pose>>,
    pub posing: Posing,
    expected: Expected,
    /// Where it goes during the time interval, if anywhere.
    motion: Option<Box<Motion>>,
    /// World space, as of the last commit.
    bounds: Aabb,
    /// Made when a ray first enters `bounds`; kept while the state stays.
    prepared: OnceLock<Box<Prepared>>,
}

impl AssetInstance {
    /// An instance at the origin, in the pose without any clip.
    pub(crate) fn new(pool: Arc<PreparedPool>) -> Self {
        Self {
            pool,
            state: InstanceState::NEW,
            spare_pose: None,
            posing: Posing::Chosen,
            expected: Expected::NOTHING,
            motion: None,
            bounds: Aabb::EMPTY,
            prepared: OnceLock::new(),
        }
    }

    pub(crate) fn asset(&self) -> &Arc<Asset> {
        self.pool.asset()
    }

    /// Gives it another pose.
    pub(crate) fn set_pose(&mut self, pose: PoseSource) {
        if let PoseSource::Given(spare) = std::mem::replace(&mut self.state.pose, pose) {
            self.spare_pose = Some(spare);
        }
    }

    /// Its pose as one that can be changed: shared no longer, evaluated if it was not.
    pub(crate) fn given_pose(&mut self, model: &ModelView, evaluator: &mut PoseEvaluator) -> &mut Pose {
        let pose = &mut self.state.pose;
        if !matches!(pose, PoseSource::Given(_)) {
            let mut given = self.spare_pose.take().unwrap_or_default();
            pose.evaluate(model, evaluator, Arc::make_mut(&mut given));
            *pose = PoseSource::Given(given);
        }
        match pose {
            PoseSource::Given(pose) => Arc::make_mut(pose),
            PoseSource::Default | PoseSource::Clip { .. } => unreachable!("replaced above"),
        }
    }

    /// Contains every posed vertex that some triangle with area uses.
    pub(crate) fn bounds(&self) -> &Aabb {
        &self.bounds
    }

    /// Bounds it for the state that it has now, and forgets what was prepared for another.
    pub(crate) fn update(&mut self) {
        let prepared = self.prepared.take();
        self.expected.after(prepared.as_ref().map(|prepared| prepared.demand()));
        if let Some(prepared) = prepared {
            self.pool.put(prepared);
        }
        let asset = Arc::clone(self.asset());
        if let Some(motion) = &mut self.motion {
            motion.update(&asset, &self.state, &mut PoseEvaluator::default());
            self.bounds = if asset.model().caches.is_empty() {
                motion_bounds(&asset, &self.state.transform, motion)
            } else {
                self.cached_motion_bounds()
            };
            return;
        }
        // The trees of free motion are built on all cores, which a ray on its way must not wait for; and of a vertex cache
        // the bounds are those of its tracks.
        self.bounds = if asset.model().caches.is_empty() {
            let (model, InstanceState { transform, pose }) = (asset.model(), &self.state);
            let pose = match pose {
                PoseSource::Given(pose) => {
                    let morphed = morph_extent(model, &pose.morph_weights);
                    Some(BoundedPose::Given(&pose.palette, morphed))
                }
                clip => clip.clip_bounds_row(model.clips).map(BoundedPose::Clip),
            };
            pose.and_then(|pose| posed_bounds(&asset, transform, pose))
        } else {
            None
        }
        .unwrap_or_else(|| self.prepared().bounds());
    }

    /// What rays need of it. Threads that come first at the same time prepare it each, and one of the results counts; all
    /// are the same.
    pub(crate) fn prepared(&self) -> &Prepared {
        if let Some(prepared) = self.prepared.get() {
            return prepared;
        }
        let mut prepared = self.pool.take();
        let InstanceState { transform, pose } = &self.state;
        let wholes = self.pool.wholes.in_use();
        let limits = self.asset().posing_limits().of(self.posing, &self.expected, wholes);
        let row = pose.clip_bounds_row(self.asset().model().clips);
        prepared.prepare(&self.pool, *transform, limits, row, |evaluator, out| {
            pose.evaluate(self.asset().model(), evaluator, out);
        });
        if let Err(late) = self.prepared.set(prepared) {
            self.pool.put(late);
        }
        self.prepared.get().expect("set above, by this thread or another")
    }

    /// Lets it move to another state during the time interval, or stand.
    pub(crate) fn set_motion(&mut self, end: Option<&InstanceState>) {
        self.motion = end.map(|end| Box::new(Motion::to(end)));
    }

    /// World box of an instance with vertex caches throughout the time interval.
    ///
    /// Between the breakpoints, its keys and both ends, a cache's vertices move on straight lines; carried by transform and
    /// bone, which are linear in time too, they stay within the box around all products of their ends, but for rounding.
    fn cached_motion_bounds(&self) -> Aabb {
        let Some(motion) = &self.motion else {
            return Aabb::EMPTY;
        };
        let breakpoints = motion.breakpoints(self.asset().model());
        let weights = motion.largest_weights();
        let mut prepared = self.pool.take();
        let mut bounds = Aabb::EMPTY;
        for transform in [&self.state.transform, motion.end.transform()] {
            for pose in motion.poses() {
                for at in 0..breakpoints.iter().map(Vec::len).max().unwrap_or(0) {
                    let frame = |cache: &Vec<f64>| cache[at.min(cache.len() - 1)];
                    prepared.prepare(&self.pool, *transform, PosingLimits::NONE, None, |_, out| {
                        out.clone_from(pose);
                        out.morph_weights.clone_from(&weights);
                        out.cache_frames.clear();
                        out.cache_frames.extend(breakpoints.iter().map(frame));
                    });
                    bounds = bounds.union(prepared.bounds_in_motion(self.asset()));
                }
            }
        }
        self.pool.put(prepared);
        bounds
    }

    pub(crate) fn is_moving(&self) -> bool {
        self.motion.is_some()
    }

    /// Prepares it at a time of the interval, as of the last commit. It moves.
    pub(crate) fn prepare_at(&self, time: f32, prepared: &mut Prepared) {
        let Some(motion) = &self.motion else {
            return;
        };
        let transform = motion.transform_at(&self.state, time);
        // How many rays come at the same time is not known; few do.
        prepared.prepare(&self.pool, transform, PosingLimits::NONE, None, |_, out| {
            motion.pose_at(time, out)
        });
    }

    /// Its state at a time from 0 to 1.
    pub(crate) fn state_at(&self, time: f32) -> InstanceState {
        match &self.motion {
            Some(motion) if time > 0.0 => {
                let mut pose = Pose::default();
                motion.pose_at(time, &mut pose);
                InstanceState {
                    transform: motion.transform_at(&self.state, time),
                    pose: PoseSource::Given(Arc::new(pose)),
                }
            }
            _ => self.state.clone(),
        }
    }

    pub(crate) fn pool(&self) -> &Arc<PreparedPool> {
        &self.pool
    }

    /// What rays have made of it so far.
    pub(crate) fn prepared_so_far(&self) -> Option<&Prepared> {
        self.prepared.get().map(|prepared| &**prepared)
    }
}

impl Drop for AssetInstance {
    fn drop(&mut self) {
        if let Some(prepared) = self.prepared.take() {
            self.pool.put(prepared);
        }
    }
}
