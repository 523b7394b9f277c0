use crate::{
    Aabb, Affine, Asset, Frame, InstanceId, InstanceState, Pose, PoseError, PoseEvaluator, Posing,
    asset_instance::AssetInstance,
    instance::Instance,
    instance_state::{PoseSource, check_cache_frames, check_clip, check_palette},
    prepared::PreparedPool,
    simd::SimdLevel,
    top_level::TopLevel,
};
use std::{
    cmp::Reverse,
    collections::BinaryHeap,
    sync::{
        Arc, Weak,
        atomic::{AtomicU64, Ordering::Relaxed},
    },
};

/// Commits of all scenes so far, and one.
static COMMITS: AtomicU64 = AtomicU64::new(1);

/// Instances that one task updates.
#[cfg(feature = "parallel")]
const INSTANCES_PER_TASK: usize = 64;

/// Instances of assets, each with a pose and a transform, and of geometry that the caller supplies.
///
/// Set poses, then [`commit`](Scene::commit): the [`Frame`] that it returns borrows the scene and answers rays, so a
/// frame can neither be traced before it is prepared nor changed while it is traced. To prepare one frame while others
/// trace another, keep two scenes: they share their assets.
#[derive(Debug)]
pub struct Scene {
    slots: Vec<Slot>,
    /// Slots without an instance.
    free: BinaryHeap<Reverse<u32>>,
    /// Slots that changed since the last commit, each once.
    changed: Vec<u32>,
    /// One per asset that has had instances here.
    pools: Vec<Weak<PreparedPool>>,
    /// World box per slot, as of the last commit; empty without an instance.
    bounds: Vec<Aabb>,
    /// Over `bounds`.
    pub(crate) top_level: TopLevel,
    pub(crate) simd: SimdLevel,
    /// Unlike that of any other commit of any scene.
    pub(crate) commit: u64,
    evaluator: PoseEvaluator,
}

/// A place for an instance.
#[derive(Debug)]
struct Slot {
    instance: Option<Instance>,
    /// Instances that were removed from it.
    generation: u32,
    is_changed: bool,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            slots: Vec::new(),
            free: BinaryHeap::new(),
            changed: Vec::new(),
            pools: Vec::new(),
            bounds: Vec::new(),
            top_level: TopLevel::default(),
            simd: SimdLevel::detect(),
            commit: 0,
            evaluator: PoseEvaluator::default(),
        }
    }
}

impl Scene {
    /// A scene with nothing in it.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds an instance at the origin, in the pose without any clip.
    ///
    /// # Panics
    /// With 2³² instances.
    pub fn add(&mut self, asset: &Arc<Asset>) -> InstanceId {
        let pool = self.pool(asset);
        self.insert(Instance::Asset(Box::new(AssetInstance::new(pool))))
    }

    /// Adds an instance of no asset, at the origin and with nothing in it, for triangles that
    /// [`Scene::set_geometry`] supplies.
    ///
    /// # Panics
    /// With 2³² instances.
    pub fn add_geometry(&mut self) -> InstanceId {
        self.insert(Instance::Geometry(Box::default()))
    }

    fn pool(&mut self, asset: &Arc<Asset>) -> Arc<PreparedPool> {
        let mut known = self.pools.iter().filter_map(Weak::upgrade);
        if let Some(pool) = known.find(|pool| Arc::ptr_eq(pool.asset(), asset)) {
            return pool;
        }
        let pool = Arc::new(PreparedPool::new(asset));
        self.pools.retain(|pool| pool.strong_count() > 0);
        self.pools.push(Arc::downgrade(&pool));
        pool
    }

    fn insert(&mut self, instance: Instance) -> InstanceId {
        let index = match self.free.pop() {
            Some(Reverse(index)) => index,
            None => {
                let index = u32::try_from(self.slots.len()).expect("fewer than 2^32 instances");
                self.slots.push(Slot {
                    instance: None,
                    generation: 0,
                    is_changed: false,
                });
                self.bounds.push(Aabb::EMPTY);
                index
            }
        };
        self.slots[index as usize].instance = Some(instance);
        self.mark(index);
        self.id(index)
    }

    /// Removes an instance. Its id means no other instance later. What was prepared of it serves the next of its asset.
    ///
    /// # Errors
    /// [`PoseError::UnknownInstance`].
    pub fn remove(&mut self, instance: InstanceId) -> Result<(), PoseError> {
        self.instance(instance)?;
        let slot = &mut self.slots[instance.index()];
        slot.instance = None;
        slot.generation = slot.generation.wrapping_add(1);
        self.free.push(Reverse(instance.index));
        self.mark(instance.index);
        Ok(())
    }

    /// Notes that a slot changes.
    fn mark(&mut self, index: u32) {
        let slot = &mut self.slots[index as usize];
        if !std::mem::replace(&mut slot.is_changed, true) {
            self.changed.push(index);
        }
    }

    pub(crate) fn id(&self, index: u32) -> InstanceId {
        InstanceId {
            index,
            generation: self.slots[index as usize].generation,
        }
    }

    /// What is in a slot.
    pub(crate) fn in_slot(&self, index: u32) -> Option<&Instance> {
        self.slots[index as usize].instance.as_ref()
    }

    /// The slots with an instance.
    pub(crate) fn occupied(&self) -> impl Iterator<Item = (u32, &Instance)> {
        (0..)
            .zip(&self.slots)
            .filter_map(|(index, slot)| Some((index, slot.instance.as_ref()?)))
    }

    /// Places an instance: world space from asset space. Any finite map, mirrored and singular ones too.
    ///
    /// # Errors
    /// [`PoseError::UnknownInstance`], [`PoseError::TransformNotFinite`].
    pub fn set_transform(&mut self, instance: InstanceId, world_from_asset: Affine) -> Result<(), PoseError> {
        let index = instance.index;
        let instance = self.instance_mut(instance)?;
        if !world_from_asset.is_finite() {
            return Err(PoseError::TransformNotFinite);
        }
        instance.set_transform(world_from_asset);
        self.mark(index);
        Ok(())
    }

    /// Replaces the triangles of an instance that was made by [`Scene::add_geometry`]: a simulation's, say, as many as it
    /// has at the moment, shared vertices or not. They are copied. The next commit builds a tree over them, on all cores
    /// (feature `parallel`), and again when they or the transform have changed.
    ///
    /// Shapes: any number of positions, and of triangles by the indices of their corners. Space: that of the instance, from
    /// which its transform leads to world space. A hit's triangle is the index into `triangles`.
    ///
    /// # Errors
    /// [`PoseError::UnknownInstance`], [`PoseError::NotGeometry`], [`PoseError::VertexNotFinite`],
    /// [`PoseError::CornerOutOfRange`], [`PoseError::TooManyTriangles`]; the instance then keeps its triangles.
    pub fn set_geometry(
        &mut self,
        instance: InstanceId,
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
    ) -> Result<(), PoseError> {
        match self.instance_mut(instance)? {
            Instance::Geometry(geometry) => geometry.set(positions, triangles)?,
            Instance::Asset(_) => {
                return Err(PoseError::NotGeometry {
                    instance: instance.index(),
                });
            }
        }
        self.mark(instance.index);
        Ok(())
    }

    /// Poses an instance by a clip at a time in seconds. Times outside the clip give its first or last pose.
    ///
    /// Complexity: constant. The clip is evaluated when a ray needs it, or at the commit where the asset has vertex caches or the
    /// file does not bound the clip.
    ///
    /// # Errors
    /// [`PoseError::UnknownInstance`], [`PoseError::NoAsset`], [`PoseError::UnknownClip`], [`PoseError::TimeNotFinite`].
    pub fn play(&mut self, instance: InstanceId, clip: usize, seconds: f32) -> Result<(), PoseError> {
        let state = self.asset_instance_mut(instance)?;
        check_clip(state.asset().model(), clip, seconds)?;
        // A clip that exists has a number of 32 bits.
        let clip = clip as u32;
        state.set_pose(PoseSource::Clip { clip, seconds });
        self.mark(instance.index);
        Ok(())
    }

    /// Poses an instance as its source stands without any clip.
    ///
    /// # Errors
    /// [`PoseError::UnknownInstance`], [`PoseError::NoAsset`].
    pub fn set_default_pose(&mut self, instance: InstanceId) -> Result<(), PoseError> {
        self.asset_instance_mut(instance)?.set_pose(PoseSource::Default);
        self.mark(instance.index);
        Ok(())
    }

    /// Poses an instance by the caller's own maps.
    ///
    /// Shapes: one map per bone row, one weight per morph target row of the asset.
    /// Space: asset space from rest space, `world(joint) · inverse_bind` for a joint; bone 0 carries what is static.
    ///
    /// # Errors
    /// One of [`PoseError`]; the instance then keeps its pose.
    pub fn set_palette(
        &mut self,
        instance: InstanceId,
        palette: &[Affine],
        morph_weights: &[f32],
    ) -> Result<(), PoseError> {
        self.change_pose(
            instance,
            |asset| check_palette(asset.model(), palette, morph_weights),
            |pose| {
                pose.palette.copy_from_slice(palette);
                pose.morph_weights.copy_from_slice(morph_weights);
            },
        )
    }

    /// Sets the frames of an instance's vertex caches, one per cache row of the asset: keys count from 0, fractions stand
    /// between keys, and beyond the ends the first or last key counts.
    ///
    /// # Errors
    /// One of [`PoseError`]; the instance then keeps its pose.
    pub fn set_cache_frames(&mut self, instance: InstanceId, frames: &[f64]) -> Result<(), PoseError> {
        self.change_pose(
            instance,
            |asset| check_cache_frames(asset.model(), frames),
            |pose| {
                pose.cache_frames.copy_from_slice(frames);
            },
        )
    }

    /// Changes the rest of a pose no more than `change` does.
    fn change_pose(
        &mut self,
        id: InstanceId,
        check: impl FnOnce(&Asset) -> Result<(), PoseError>,
        change: impl FnOnce(&mut Pose),
    ) -> Result<(), PoseError> {
        let mut evaluator = std::mem::take(&mut self.evaluator);
        let changed = self.asset_instance_mut(id).and_then(|instance| {
            let asset = Arc::clone(instance.asset());
            check(&asset)?;
            change(instance.given_pose(asset.model(), &mut evaluator));
            Ok(())
        });
        self.evaluator = evaluator;
        changed?;
        self.mark(id.index);
        Ok(())
    }

    /// Where an instance stands and how: a small value to keep. A palette in it is shared with the instance until one of
    /// the two is set anew.
    ///
    /// # Errors
    /// [`PoseError::UnknownInstance`], [`PoseError::NoAsset`].
    pub fn state(&self, instance: InstanceId) -> Result<InstanceState, PoseError> {
        Ok(self.asset_instance(instance)?.state.clone())
    }

    /// Gives an instance a state that one of the same asset was in: a past one, say. Copies no palette.
    ///
    /// # Errors
    /// One of [`PoseError`], where the state is of another asset whose shapes differ; the instance then keeps its state.
    pub fn set_state(&mut self, instance: InstanceId, state: &InstanceState) -> Result<(), PoseError> {
        let target = self.asset_instance_mut(instance)?;
        state.check(target.asset().model())?;
        target.state.transform = state.transform;
        target.set_pose(state.pose.clone());
        self.mark(instance.index);
        Ok(())
    }

    /// Lets an instance move, during the time interval of the coming frames, from the state that it has to `end`, or stand:
    /// for rays with times of their own ([`Frame::closest_hit_at`](crate::Frame::closest_hit_at)). All others meet it where it
    /// is now. At time s all numbers of its transform, palette, morph weights and cache frames are `(1 − s)·a + s·b`.
    ///
    /// Complexity: the next commit evaluates both poses.
    ///
    /// # Errors
    /// As [`Scene::set_state`]; the instance then moves as before.
    pub fn set_motion(&mut self, instance: InstanceId, end: Option<&InstanceState>) -> Result<(), PoseError> {
        let target = self.asset_instance_mut(instance)?;
        if let Some(end) = end {
            end.check(target.asset().model())?;
        }
        target.set_motion(end);
        self.mark(instance.index);
        Ok(())
    }

    /// Says how the triangles of an instance are posed. Default [`Posing::Chosen`].
    ///
    /// # Errors
    /// [`PoseError::UnknownInstance`], [`PoseError::NoAsset`].
    pub fn set_posing(&mut self, instance: InstanceId, posing: Posing) -> Result<(), PoseError> {
        self.asset_instance_mut(instance)?.posing = posing;
        self.mark(instance.index);
        Ok(())
    }

    /// The pose of an instance, evaluated.
    ///
    /// # Errors
    /// [`PoseError::UnknownInstance`], [`PoseError::NoAsset`].
    pub fn pose(&self, instance: InstanceId) -> Result<Pose, PoseError> {
        let instance = self.asset_instance(instance)?;
        let mut pose = Pose::default();
        let model = instance.asset().model();
        instance
            .state
            .pose
            .evaluate(model, &mut PoseEvaluator::default(), &mut pose);
        Ok(pose)
    }

    /// An instance of this scene.
    pub(crate) fn instance(&self, id: InstanceId) -> Result<&Instance, PoseError> {
        let slot = self
            .slots
            .get(id.index())
            .filter(|slot| slot.generation == id.generation);
        slot.and_then(|slot| slot.instance.as_ref())
            .ok_or_else(|| self.unknown(id))
    }

    fn unknown(&self, id: InstanceId) -> PoseError {
        PoseError::UnknownInstance {
            instance: id.index(),
            count: self.slots.len() - self.free.len(),
        }
    }

    fn instance_mut(&mut self, id: InstanceId) -> Result<&mut Instance, PoseError> {
        let unknown = self.unknown(id);
        let slot = self
            .slots
            .get_mut(id.index())
            .filter(|slot| slot.generation == id.generation);
        slot.and_then(|slot| slot.instance.as_mut()).ok_or(unknown)
    }

    pub(crate) fn asset_instance(&self, id: InstanceId) -> Result<&AssetInstance, PoseError> {
        match self.instance(id)? {
            Instance::Asset(instance) => Ok(instance),
            Instance::Geometry(_) => Err(PoseError::NoAsset { instance: id.index() }),
        }
    }

    fn asset_instance_mut(&mut self, id: InstanceId) -> Result<&mut AssetInstance, PoseError> {
        match self.instance_mut(id)? {
            Instance::Asset(instance) => Ok(instance),
            Instance::Geometry(_) => Err(PoseError::NoAsset { instance: id.index() }),
        }
    }

    /// Bounds the instances that changed, and refits the tree over all, or builds it anew where it has become worse than it was
    /// or instances were added. What rays need beside that is made when they
    /// come, by whichever comes first.
    ///
    /// Complexity: constant per changed instance where its file bounds its clip, else per bone; per cluster where it has
    /// vertex caches, per triangle in free motion and for supplied geometry, whose trees are built now. On all cores
    /// (feature `parallel`). Allocates nothing once its buffers have grown to the scene, but for the tasks in which such
    /// trees are built and for instances that [move](Scene::set_motion).
    pub fn commit(&mut self) -> Frame<'_> {
        if self.changed.is_empty() {
            return Frame { scene: self };
        }
        self.commit = COMMITS.fetch_add(1, Relaxed);
        self.update_changed();
        for index in self.changed.drain(..) {
            let slot = &mut self.slots[index as usize];
            slot.is_changed = false;
            self.bounds[index as usize] = slot.instance.as_ref().map_or(Aabb::EMPTY, Instance::bounds);
        }
        let bounds = &self.bounds;
        self.top_level
            .update(bounds.len() as u32, |index| bounds[index as usize]);
        Frame { scene: self }
    }

    fn update_changed(&mut self) {
        #[cfg(feature = "parallel")]
        if self.changed.len() > INSTANCES_PER_TASK {
            use rayon::prelude::*;
            let slots = self.slots.par_iter_mut().with_min_len(INSTANCES_PER_TASK);
            slots
                .filter(|slot| slot.is_changed)
                .filter_map(|slot| slot.instance.as_mut())
                .for_each(Instance::update);
            return;
        }
        for index in &self.changed {
            if let Some(instance) = &mut self.slots[*index as usize].instance {
                instance.update();
            }
        }
    }

    /// As [`Scene::commit`], but refuses poses outside the pose space that their asset was baked for instead of tracing
    /// them with wider boxes: for those who would rather bake again than pay for it. A bone without usable inverse is not
    /// refused: it has no boxes to leave. Prepares every instance ([`Frame::prepare`]).
    ///
    /// # Errors
    /// [`PoseError::OutsidePoseSpace`], of the first cluster outside. The pose stays set: set another, or commit this one.
    pub fn commit_inside(&mut self) -> Result<Frame<'_>, PoseError> {
        let frame = self.commit();
        frame.prepare();
        for (index, instance) in self.occupied() {
            let Instance::Asset(instance) = instance else {
                continue;
            };
            let clusters = instance.prepared().clusters.iter();
            let mut posed = clusters.filter_map(|cluster| Some((cluster.row, cluster.posed_so_far()?)));
            let Some((row, posed)) = posed.find(|(_, posed)| posed.excess.is_outside) else {
                continue;
            };
            let model = instance.asset().model();
            let bone = model.clusters[row as usize].bone as usize;
            return Err(PoseError::OutsidePoseSpace {
                instance: index as usize,
                bone,
                name: model.meta.bone_names[bone].clone(),
                excess: posed.excess.largest(),
            });
        }
        Ok(Frame { scene: self })
    }
}
