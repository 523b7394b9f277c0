use crate::{BakeError, DecomposeSettings};
use restpose_formats::{Bounds, rows::MotionClass};

/// Which clips the pose space is made of.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum ClipSelection {
    /// All clips of the source.
    #[default]
    All,
    /// Clips by name, or by number in the source. The others are left out of the file.
    Named(Vec<String>),
}

/// What a bake does. Each field changes the file and is part of its options hash.
#[derive(Clone, Debug, PartialEq)]
pub struct BakeSettings {
    /// Clips to keep and to sample. Default: all.
    pub clips: ClipSelection,
    /// Greatest step between sampled poses of a clip, seconds, above zero. Default 1/60. Key times are sampled too.
    pub sample_step_seconds: f64,
    /// How fuzzy boxes are bounded. Default: around the samples.
    pub bounds: Bounds,
    /// Classes that the user decides, as part name and class. `static` freezes a part in the pose without any clip,
    /// `rigid` keeps a bone for a part that no clip moves.
    pub class_overrides: Vec<(String, MotionClass)>,
    /// Vertex caches: greatest distance, in scene units, by which a stored position may be off at a key. 0 stores
    /// positions as they are. Default: 2⁻¹⁶ of the part's greatest diagonal.
    pub position_error: Option<f64>,
    /// Vertex caches: how motion is decomposed.
    pub motion: DecomposeSettings,
    /// Vertex caches: time segments.
    pub segments: SegmentSettings,
    /// Vertex caches: rays for which a frame is made, at least 0. Where a tree built for each frame would cost less than
    /// fuzzy trees, the part is in free motion. Default 10,000.
    pub rays_per_frame: f64,
}

/// Splitting vertex caches in time.
#[derive(Clone, Debug, PartialEq)]
pub struct SegmentSettings {
    /// Most segments of a cache. At least 1; default 1: no splitting.
    pub most: usize,
    /// A split is kept if the part of the expected cost that it saves is at least this times the part of bytes that it
    /// adds. At least 0; default 0.1: one percent of the cost for ten percent of bytes.
    pub worth: f64,
}

impl Default for SegmentSettings {
    fn default() -> Self {
        Self { most: 1, worth: 0.1 }
    }
}

impl Default for BakeSettings {
    fn default() -> Self {
        Self {
            clips: ClipSelection::All,
            sample_step_seconds: 1.0 / 60.0,
            bounds: Bounds::Sampled,
            class_overrides: Vec::new(),
            position_error: None,
            motion: DecomposeSettings::default(),
            segments: SegmentSettings::default(),
            rays_per_frame: 10_000.0,
        }
    }
}

impl BakeSettings {
    /// Refuses settings that no bake can follow.
    ///
    /// # Errors
    /// [`BakeError::SampleStep`], [`BakeError::Setting`].
    pub fn check(&self) -> Result<(), BakeError> {
        if !(self.sample_step_seconds.is_finite() && self.sample_step_seconds > 0.0) {
            return Err(BakeError::SampleStep {
                found: self.sample_step_seconds,
            });
        }
        let numbers = [
            ("position error", self.position_error.unwrap_or(0.0), f64::INFINITY),
            ("iteration threshold", self.motion.iteration_threshold, 1.0),
            ("cluster threshold", self.motion.cluster_threshold, 1.0),
            ("segment worth", self.segments.worth, f64::INFINITY),
            ("rays per frame", self.rays_per_frame, f64::INFINITY),
        ];
        for (name, found, most) in numbers {
            if !(found.is_finite() && (0.0..=most).contains(&found)) {
                return Err(BakeError::Setting { name, found, most });
            }
        }
        Ok(())
    }

    /// Option names and values, those of the import behind them, in a fixed order: what the metadata keeps and the options hash is made of.
    #[must_use]
    pub fn listed(&self, import_options: &[(String, String)]) -> Vec<(String, String)> {
        let clips = match &self.clips {
            ClipSelection::All => "all".to_owned(),
            ClipSelection::Named(names) => format!("{names:?}"),
        };
        let bounds = match self.bounds {
            Bounds::Sampled => "sampled",
            Bounds::Envelope => "envelope",
        };
        let mut out = vec![
            ("clips".to_owned(), clips),
            ("sample_step_seconds".to_owned(), self.sample_step_seconds.to_string()),
            ("bounds".to_owned(), bounds.to_owned()),
        ];
        let auto = "2^-16 of the diagonal".to_owned();
        let motion = &self.motion;
        for (name, value) in [
            (
                "position_error",
                self.position_error.map_or(auto, |error| error.to_string()),
            ),
            ("max_clusters", motion.max_clusters.to_string()),
            ("iteration_threshold", motion.iteration_threshold.to_string()),
            ("cluster_threshold", motion.cluster_threshold.to_string()),
            ("max_iterations", motion.max_iterations.to_string()),
            ("rest_step", motion.rest_step.to_string()),
            ("principal_axes", motion.principal_axes.to_string()),
            ("segments", self.segments.most.to_string()),
            ("segment_worth", self.segments.worth.to_string()),
            ("rays_per_frame", self.rays_per_frame.to_string()),
        ] {
            out.push((name.to_owned(), value));
        }
        out.extend_from_slice(import_options);
        for (part, class) in &self.class_overrides {
            out.push((format!("class {part}"), class.name().to_owned()));
        }
        out
    }

    /// BLAKE3 of the program's version and the listed options, each string preceded by its length.
    #[must_use]
    pub fn hash(&self, import_options: &[(String, String)]) -> [u8; 32] {
        let mut hasher = blake3::Hasher::new();
        let mut add = |text: &str| {
            hasher.update(&(text.len() as u64).to_le_bytes());
            hasher.update(text.as_bytes());
        };
        add(env!("CARGO_PKG_VERSION"));
        for (name, value) in self.listed(import_options) {
            add(&name);
            add(&value);
        }
        *hasher.finalize().as_bytes()
    }
}
