use crate::{MeasureError, subdivision_limit::check_subdivisions};
use restpose_bake::{BakeSettings, NoProgress, bake, import::Animation, subdivide::subdivide};
use restpose_formats::{TreeKind, write};
use restpose_runtime::Asset;
use std::{sync::Arc, time::Instant};

/// Most instances of a scene.
const INSTANCE_LIMIT: u64 = 1 << 20;

/// What is measured: an asset, as often as is asked for.
pub struct FrameScene {
    pub(super) name: String,
    pub(super) instances: usize,
    source: Source,
    /// Files that were made so far, by their settings.
    files: Vec<(BakeSettings, Arc<File>)>,
}

enum Source {
    Animation(Box<(Animation, BakeSettings)>),
    Baked(Arc<File>),
}

/// A file in memory.
pub(super) struct File {
    pub asset: Arc<Asset>,
    pub bytes: Vec<u8>,
    /// Zero where it was baked before.
    pub bake_seconds: f64,
}

impl FrameScene {
    /// A source, subdivided so many times and baked by these settings, with the trees of each strategy.
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
            source: Source::Animation(Box::new((subdivide(animation, subdivisions), settings))),
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
            source: Source::Baked(Arc::new(file)),
            files: Vec::new(),
        })
    }

    /// The file with such trees; `None` where it was baked before, with others.
    pub(super) fn file(&mut self, tree: TreeKind) -> Result<Option<Arc<File>>, MeasureError> {
        let (animation, settings) = match &self.source {
            Source::Baked(file) => {
                return Ok((file.asset.model().meta.tree == tree).then(|| Arc::clone(file)));
            }
            Source::Animation(source) => &**source,
        };
        let settings = BakeSettings {
            tree,
            ..settings.clone()
        };
        if let Some((_, file)) = self.files.iter().find(|(known, _)| *known == settings) {
            return Ok(Some(Arc::clone(file)));
        }
        let start = Instant::now();
        let bytes = write(&bake(animation, &settings, &NoProgress)?.model)?;
        let file = Arc::new(File {
            asset: Arc::new(Asset::from_bytes(&bytes)?),
            bytes,
            bake_seconds: start.elapsed().as_secs_f64(),
        });
        self.files.push((settings, Arc::clone(&file)));
        Ok(Some(file))
    }
}

fn check_instances(instances: usize) -> Result<(), MeasureError> {
    MeasureError::check_setting("instances", instances as u64, 1, INSTANCE_LIMIT, "1 to 1048576")
}
