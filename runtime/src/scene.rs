use crate::{
    Aabb, Affine, Asset, Frame, FrameStats, InstanceId, PoseError, PoseEvaluator, asset_instance::AssetInstance,
    box_tree::BoxTree, build::BvhSettings, instance::Instance,
};
use std::sync::Arc;

/// Instances of assets, each with a pose and a transform, and of geometry that the caller supplies.
///
/// Set poses, then [`commit`](Scene::commit): the [`Frame`] that it returns borrows the scene and answers rays, so a
/// frame can neither be traced before it is prepared nor changed while it is traced.
#[derive(Debug, Default)]
pub struct Scene {
    pub(crate) instances: Vec<Instance>,
    /// The clusters of all instances, in order.
    pub(crate) entries: Vec<Entry>,
    /// World box of each entry.
    pub(crate) boxes: Vec<Aabb>,
    /// Over `boxes`.
    pub(crate) top_level: BoxTree,
    pub(crate) stats: FrameStats,
    evaluator: PoseEvaluator,
}

/// To enter a cluster takes as long as eight steps (the baker's cost model counts as many): so leaves have one, where boxes
/// differ at all.
const TOP_LEVEL: BvhSettings = BvhSettings {
    traversal_cost: 1.0,
    intersection_cost: 8.0,
};

/// A cluster of an instance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    pub instance: u32,
    /// Place among the instance's clusters.
    pub slot: u32,
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
        let instance = AssetInstance::new(asset, &mut self.evaluator);
        self.push(Instance::Asset(Box::new(instance)))
    }

    /// Adds an instance of no asset, at the origin and with nothing in it, for triangles that
    /// [`Scene::set_geometry`] supplies.
    ///
    /// # Panics
    /// With 2³² instances.
    pub fn add_geometry(&mut self) -> InstanceId {
        self.push(Instance::Geometry(Box::default()))
    }

    fn push(&mut self, instance: Instance) -> InstanceId {
        let id = InstanceId(u32::try_from(self.instances.len()).expect("fewer than 2^32 instances"));
        self.instances.push(instance);
        id
    }

    /// Places an instance: world space from asset space. Any finite map, mirrored and singular ones too.
    ///
    /// # Errors
    /// [`PoseError::UnknownInstance`], [`PoseError::TransformNotFinite`].
    pub fn set_transform(&mut self, instance: InstanceId, world_from_asset: Affine) -> Result<(), PoseError> {
        let instance = self.instance_mut(instance)?;
        if !world_from_asset.is_finite() {
            return Err(PoseError::TransformNotFinite);
        }
        instance.set_transform(world_from_asset);
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
            Instance::Geometry(geometry) => geometry.set(positions, triangles),
            Instance::Asset(_) => Err(PoseError::NotGeometry {
                instance: instance.index(),
            }),
        }
    }

    /// Poses an instance by a clip at a time in seconds. Times outside the clip give its first or last pose.
    ///
    /// # Errors
    /// [`PoseError::UnknownInstance`], [`PoseError::UnknownClip`], [`PoseError::TimeNotFinite`].
    pub fn play(&mut self, instance: InstanceId, clip: usize, seconds: f32) -> Result<(), PoseError> {
        let count = self.asset_instance_mut(instance)?.asset.model().clips.len();
        if clip >= count {
            return Err(PoseError::UnknownClip { clip, count });
        }
        if !seconds.is_finite() {
            return Err(PoseError::TimeNotFinite { seconds });
        }
        self.evaluate(instance, Some(clip), seconds)
    }

    /// Poses an instance as its source stands without any clip.
    ///
    /// # Errors
    /// [`PoseError::UnknownInstance`].
    pub fn set_default_pose(&mut self, instance: InstanceId) -> Result<(), PoseError> {
        self.evaluate(instance, None, 0.0)
    }

    fn evaluate(&mut self, id: InstanceId, clip: Option<usize>, seconds: f32) -> Result<(), PoseError> {
        let instance = asset_instance(&mut self.instances, id)?;
        let asset = Arc::clone(&instance.asset);
        self.evaluator
            .evaluate(asset.model(), clip, seconds, &mut instance.pose);
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
        let instance = self.asset_instance_mut(instance)?;
        let model = instance.asset.model();
        let (expected, found) = (model.bones.len(), palette.len());
        if expected != found {
            return Err(PoseError::PaletteLength { expected, found });
        }
        let (expected, found) = (model.morph_targets.len(), morph_weights.len());
        if expected != found {
            return Err(PoseError::MorphWeightsLength { expected, found });
        }
        if let Some(bone) = palette.iter().position(|x| !x.is_finite()) {
            let name = model.meta.bone_names.get(bone).cloned().unwrap_or_default();
            return Err(PoseError::BoneNotFinite { bone, name });
        }
        if let Some(target) = morph_weights.iter().position(|weight| !weight.is_finite()) {
            return Err(PoseError::MorphWeightNotFinite { target });
        }
        instance.pose.palette.copy_from_slice(palette);
        instance.pose.morph_weights.copy_from_slice(morph_weights);
        Ok(())
    }

    /// Sets the frames of an instance's vertex caches, one per cache row of the asset: keys count from 0, fractions stand
    /// between keys, and beyond the ends the first or last key counts.
    ///
    /// # Errors
    /// One of [`PoseError`]; the instance then keeps its pose.
    pub fn set_cache_frames(&mut self, instance: InstanceId, frames: &[f64]) -> Result<(), PoseError> {
        let instance = self.asset_instance_mut(instance)?;
        let (expected, found) = (instance.pose.cache_frames.len(), frames.len());
        if expected != found {
            return Err(PoseError::CacheFramesLength { expected, found });
        }
        if let Some(cache) = frames.iter().position(|frame| !frame.is_finite()) {
            return Err(PoseError::CacheFrameNotFinite { cache });
        }
        instance.pose.cache_frames.copy_from_slice(frames);
        Ok(())
    }

    /// An instance's palette, as [`Scene::set_palette`] takes it.
    ///
    /// # Errors
    /// [`PoseError::UnknownInstance`].
    pub fn palette(&self, instance: InstanceId) -> Result<&[Affine], PoseError> {
        Ok(&self.asset_instance(instance)?.pose.palette)
    }

    /// An instance's morph weights, as [`Scene::set_palette`] takes them.
    ///
    /// # Errors
    /// [`PoseError::UnknownInstance`].
    pub fn morph_weights(&self, instance: InstanceId) -> Result<&[f32], PoseError> {
        Ok(&self.asset_instance(instance)?.pose.morph_weights)
    }

    fn asset_instance(&self, instance: InstanceId) -> Result<&AssetInstance, PoseError> {
        let count = self.instances.len();
        let index = instance.index();
        match self.instances.get(index) {
            Some(Instance::Asset(instance)) => Ok(instance),
            Some(Instance::Geometry(_)) => Err(PoseError::NoAsset { instance: index }),
            None => Err(PoseError::UnknownInstance { instance: index, count }),
        }
    }

    fn asset_instance_mut(&mut self, instance: InstanceId) -> Result<&mut AssetInstance, PoseError> {
        asset_instance(&mut self.instances, instance)
    }

    fn instance_mut(&mut self, instance: InstanceId) -> Result<&mut Instance, PoseError> {
        let count = self.instances.len();
        self.instances
            .get_mut(instance.index())
            .ok_or(PoseError::UnknownInstance {
                instance: instance.index(),
                count,
            })
    }

    /// Prepares everything that rays need: cluster frames, margins, world boxes and the top-level tree.
    ///
    /// Complexity: per bone and cluster, not per triangle, but for clusters whose frame has no usable inverse, whose
    /// vertices are posed for their bounds, and free motion and supplied geometry, for which a tree is built. Allocates
    /// nothing once its buffers have grown to the scene, but for the tasks in which such trees are built.
    pub fn commit(&mut self) -> Frame<'_> {
        self.entries.clear();
        self.boxes.clear();
        self.stats = FrameStats::default();
        for (index, instance) in (0..).zip(&mut self.instances) {
            instance.update();
            for (slot, bounds) in (0..).zip(instance.boxes()) {
                self.entries.push(Entry { instance: index, slot });
                self.boxes.push(bounds);
            }
            match instance {
                Instance::Asset(instance) => self.stats.add(&instance.clusters),
                Instance::Geometry(_) => self.stats.clusters_rebuilt += 1,
            }
        }
        let boxes = &self.boxes;
        self.top_level
            .rebuild(0..boxes.len() as u32, |entry| boxes[entry as usize], &TOP_LEVEL);
        self.stats.instances = self.instances.len() as u32;
        self.stats.clusters = self.entries.len() as u32;
        self.stats.top_level_nodes = self.top_level.node_count() as u32;
        Frame { scene: self }
    }

    /// As [`Scene::commit`], but refuses poses outside the pose space that their asset was baked for instead of tracing
    /// them with wider boxes: for those who would rather bake again than pay for it. A bone without usable inverse is not
    /// refused: it has no boxes to leave.
    ///
    /// # Errors
    /// [`PoseError::OutsidePoseSpace`], of the first cluster outside. The pose stays set: set another, or commit this one.
    pub fn commit_inside(&mut self) -> Result<Frame<'_>, PoseError> {
        self.commit();
        for (index, instance) in self.instances.iter().enumerate() {
            let Instance::Asset(instance) = instance else {
                continue;
            };
            let Some(active) = instance.clusters.iter().find(|active| active.excess.is_outside) else {
                continue;
            };
            let model = instance.asset.model();
            let bone = model.clusters[active.row as usize].bone as usize;
            return Err(PoseError::OutsidePoseSpace {
                instance: index,
                bone,
                name: model.meta.bone_names[bone].clone(),
                excess: active.excess.largest(),
            });
        }
        Ok(Frame { scene: self })
    }
}

fn asset_instance(instances: &mut [Instance], instance: InstanceId) -> Result<&mut AssetInstance, PoseError> {
    let count = instances.len();
    let index = instance.index();
    match instances.get_mut(index) {
        Some(Instance::Asset(instance)) => Ok(instance),
        Some(Instance::Geometry(_)) => Err(PoseError::NoAsset { instance: index }),
        None => Err(PoseError::UnknownInstance { instance: index, count }),
    }
}
