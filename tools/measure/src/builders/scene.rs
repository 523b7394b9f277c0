use super::{
    key_frames::key_frames,
    sampled_frames::sampled_frames,
    scenes::{Generated, Triangle},
};
use crate::MeasureError;
use restpose_bake::import::Animation;

/// Triangles to build trees over.
#[derive(Clone, Debug)]
pub struct BuilderScene {
    pub(super) name: String,
    pub(super) triangles: Vec<Triangle>,
    /// The same triangles in other poses, in order of time; empty where nothing moves.
    pub(super) frames: Vec<Vec<Triangle>>,
}

impl BuilderScene {
    /// A scene that is made.
    #[must_use]
    pub fn generated(scene: Generated, seed: u64) -> Self {
        Self {
            name: scene.to_string(),
            triangles: scene.triangles(seed),
            frames: Vec::new(),
        }
    }

    /// A source at the start of its first clip, or without any; and up to `frames` frames of that clip: those of its vertex
    /// caches, else its sampled poses.
    ///
    /// # Errors
    /// [`MeasureError`]: the source does not bake.
    pub fn imported(animation: &Animation, frames: usize) -> Result<Self, MeasureError> {
        let most = frames.max(1);
        let mut frames = match key_frames(animation, most) {
            Some(frames) => frames,
            None => sampled_frames(animation, most)?,
        };
        let triangles = if frames.len() > 1 {
            frames[0].clone()
        } else {
            frames.pop().unwrap_or_default()
        };
        Ok(Self {
            name: animation.source_name.clone(),
            triangles,
            frames,
        })
    }

    /// What the tables call it.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use restpose_bake::import::{ImportSettings, import_files};
    use std::path::Path;

    fn sample(names: &[&str]) -> Animation {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples/scenes");
        let paths: Vec<_> = names.iter().map(|name| folder.join(name)).collect();
        import_files(&paths, &ImportSettings::default()).unwrap().animation
    }

    #[test]
    fn frames_of_caches_and_of_clips_are_posed() {
        for names in [&["goose.obj", "goose.pc2"][..], &["walker.glb"]] {
            let animation = sample(names);
            let scene = BuilderScene::imported(&animation, 5).unwrap();
            assert_eq!(scene.frames.len(), 5, "{names:?}");
            assert_eq!(scene.triangles, scene.frames[0]);
            assert_ne!(scene.frames[0], scene.frames[4]);
            assert!(scene.frames.iter().all(|frame| frame.len() == scene.triangles.len()));
            let still = BuilderScene::imported(&animation, 0).unwrap();
            assert_eq!((still.triangles, still.frames.len()), (scene.triangles, 0));
        }
    }

    #[test]
    fn frames_of_caches_are_those_of_the_bake() {
        let animation = sample(&["goose.obj", "goose.pc2"]);
        let own = key_frames(&animation, 1).unwrap();
        let baked = sampled_frames(&animation, 1).unwrap();
        assert_eq!(own[0].len(), baked[0].len());
        let scale = 4.0;
        for (own, baked) in own[0].iter().flatten().zip(baked[0].iter().flatten()) {
            // Stored positions are within 2⁻¹⁶ of the diagonal, a few units.
            assert!(
                (0..3).all(|k| (own[k] - baked[k]).abs() < scale / 65_536.0),
                "{own:?} {baked:?}"
            );
        }
    }
}
