use super::{ours::STRATEGIES, settings::FrameSettings};
use crate::{MeasureError, subdivision_limit::check_subdivisions};
use restpose_bake::{BakeSettings, Progress, bake, import::Animation, subdivide::subdivide};
use restpose_formats::{TreeKind, write};
use restpose_runtime::Asset;
use std::{sync::Arc, time::Instant};

/// Most instances of a scene.
const INSTANCE_LIMIT: u64 = 1 << 20;

/// What is measured: an asset, as often as is asked for.
pub struct FrameScene {
    pub(super) name: String,
    pub(super) instances: usize,
    /// What to bake; none where that was done before.
    source: Option<Box<(Animation, BakeSettings)>>,
    /// Each with other trees.
    files: Vec<Arc<File>>,
}

/// A file in memory.
pub(super) struct File {
    pub asset: Arc<Asset>,
    pub bytes: Vec<u8>,
    /// Zero where it was baked before.
    pub bake_seconds: f64,
}

impl FrameScene {
    /// A source, subdivided so many times, to be baked by these settings, with the trees of each strategy.
    ///
    /// # Errors
    /// [`MeasureError`]: too many subdivisions or instances, or none.
    pub fn imported(
        animation: &Animation,
        subdivisions: u32,
        instances: usize,
        settings: BakeSettings,
    ) -> Result<Self, MeasureError> {
        check_subdivisions("subdivide", subdivisions, animation)?;
        check_instances(instances)?;
        Ok(Self {
            name: animation.source_name.clone(),
            instances,
            source: Some(Box::new((subdivide(animation, subdivisions), settings))),
            files: Vec::new(),
        })
    }

    /// The bytes of a baked file. Strategies of other trees than it has are left out.
    ///
    /// # Errors
    /// [`MeasureError`]: too many instances or none, or the file is refused.
    pub fn baked(name: String, bytes: Vec<u8>, instances: usize) -> Result<Self, MeasureError> {
        check_instances(instances)?;
        let file = File {
            asset: Arc::new(Asset::from_bytes(&bytes)?),
            bytes,
            bake_seconds: 0.0,
        };
        Ok(Self {
            name,
            instances,
            source: None,
            files: vec![Arc::new(file)],
        })
    }

    /// Bakes what the chosen strategies take, where that was not done before.
    ///
    /// # Errors
    /// [`MeasureError`]: the source does not bake.
    pub fn bake(&mut self, settings: &FrameSettings, progress: &dyn Progress) -> Result<(), MeasureError> {
        let chosen = || STRATEGIES.iter().filter(|strategy| settings.chosen(strategy.name));
        let several_trees = TreeKind::ALL
            .iter()
            .all(|tree| chosen().any(|strategy| strategy.tree == *tree));
        for strategy in chosen() {
            let Some(source) = &self.source else { break };
            if self.file(strategy.tree).is_some() {
                continue;
            }
            let (animation, bake_settings) = &**source;
            let mut bake_settings = BakeSettings {
                tree: strategy.tree,
                ..bake_settings.clone()
            };
            if several_trees {
                // Clusters are chosen for the trees, and positions are stored by clusters: only as they are do all have the same.
                bake_settings.position_error = Some(0.0);
            }
            let start = Instant::now();
            let bytes = write(&bake(animation, &bake_settings, progress)?.model)?;
            self.files.push(Arc::new(File {
                asset: Arc::new(Asset::from_bytes(&bytes)?),
                bytes,
                bake_seconds: start.elapsed().as_secs_f64(),
            }));
        }
        Ok(())
    }

    /// The files, by their trees.
    pub fn files(&self) -> impl Iterator<Item = (TreeKind, &[u8])> {
        self.files.iter().map(|file| (file.tree(), file.bytes.as_slice()))
    }

    /// The file with such trees; `None` where it was baked before, with others.
    pub(super) fn file(&self, tree: TreeKind) -> Option<Arc<File>> {
        self.files.iter().find(|file| file.tree() == tree).map(Arc::clone)
    }
}

impl File {
    fn tree(&self) -> TreeKind {
        self.asset.model().meta.tree
    }
}

fn check_instances(instances: usize) -> Result<(), MeasureError> {
    MeasureError::check_setting("instances", instances as u64, 1, INSTANCE_LIMIT, "1 to 1048576")
}
