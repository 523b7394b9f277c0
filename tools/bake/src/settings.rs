use crate::{BakeError, DecomposeSettings, PoseSpace};
use restpose_formats::{Bounds, TreeKind, rows::MotionClass};

/// Most random poses that a bake takes.
const MOST_SAMPLES: usize = 100_000;
/// Most envelopes that a cluster may have.
const MOST_ENVELOPES: usize = 1024;

/// Which clips are kept.
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
    /// Clips to keep. Default: all.
    pub clips: ClipSelection,
    /// Poses that the boxes are made for. Default: those of the clips that are kept.
    pub pose_space: PoseSpace,
    /// Random poses of a pose space that has some, at most 100,000. Default: [`PoseSpace::default_samples`].
    pub pose_samples: Option<usize>,
    /// Seed of the random poses. Default 1.
    pub seed: u64,
    /// Greatest step between sampled poses of a clip, seconds, above zero. Default 1/60. Key times are sampled too.
    pub sample_step_seconds: f64,
    /// How fuzzy boxes are bounded. Default: by envelopes, so that no pose misses a hit.
    pub bounds: Bounds,
    /// Most envelopes of a cluster, 1 to 1024, where boxes are bounded by envelopes. Default 64.
    pub envelopes: usize,
    /// What the fuzzy trees are. Default: wide trees.
    pub tree: TreeKind,
    /// Classes that the user decides, as part name and class. `static` freezes a part in the pose without any clip,
    /// `rigid` keeps a bone for a part that no clip moves.
    pub class_overrides: Vec<(String, MotionClass)>,
    /// Vertex caches: greatest distance, in scene units, by which a stored position may be off at a key. 0 stores
    /// positions as they are. Default: 2⁻¹⁶ of the part's greatest diagonal.
    pub position_error: Option<f64>,
    /// Vertex caches: how motion is decomposed.
    pub motion: DecomposeSettings,
    /// Vertex caches: most time segments. At least 1; default 1: no splitting.
    pub segments: usize,
    /// Vertex caches: more time segments, and boxes at more keys, are kept if the part of the expected cost that they save is at
    /// least this times the part of bytes that they add. At least 0; default 0.1: a tenth of the cost for twice the bytes.
    pub size_worth: f64,
    /// Vertex caches: rays of a frame that meet the part, at least 0. Where a tree built for each frame is expected to take
    /// less time than fuzzy trees, on one thread, the part is in free motion; 0: only where that is asked for. Default 1,000:
    /// line of sight and hit-scan ask for hundreds, a picture for a million.
    pub rays_per_frame: f64,
}

impl Default for BakeSettings {
    fn default() -> Self {
        Self {
            clips: ClipSelection::All,
            pose_space: PoseSpace::Clips,
            pose_samples: None,
            seed: 1,
            sample_step_seconds: 1.0 / 60.0,
            bounds: Bounds::Envelope,
            envelopes: 64,
            tree: TreeKind::Wide,
            class_overrides: Vec::new(),
            position_error: None,
            motion: DecomposeSettings::default(),
            segments: 1,
            size_worth: 0.1,
            rays_per_frame: 1_000.0,
        }
    }
}

impl BakeSettings {
    /// Random poses that the pose space asks for.
    pub(crate) fn random_samples(&self) -> usize {
        if self.pose_space.is_random() {
            self.pose_samples.unwrap_or_else(|| self.pose_space.default_samples())
        } else {
            0
        }
    }

    /// Refuses settings that no bake can follow.
    ///
    /// # Errors
    /// [`BakeError::SampleStep`], [`BakeError::Setting`], [`BakeError::JointLimits`].
    pub fn check(&self) -> Result<(), BakeError> {
        if !(self.sample_step_seconds.is_finite() && self.sample_step_seconds > 0.0) {
            return Err(BakeError::SampleStep {
                found: self.sample_step_seconds,
            });
        }
        let slack = if let PoseSpace::Limits(limits) = &self.pose_space {
            limits.joints.check()?;
            limits.slack_deg
        } else {
            0.0
        };
        let samples = self.random_samples() as f64;
        let numbers = [
            ("limit slack", slack, 0.0, 180.0),
            ("pose samples", samples, 0.0, MOST_SAMPLES as f64),
            ("envelopes", self.envelopes as f64, 1.0, MOST_ENVELOPES as f64),
            ("position error", self.position_error.unwrap_or(0.0), 0.0, f64::INFINITY),
            ("iteration threshold", self.motion.iteration_threshold, 0.0, 1.0),
            ("cluster threshold", self.motion.cluster_threshold, 0.0, 1.0),
            ("size worth", self.size_worth, 0.0, f64::INFINITY),
            ("rays per frame", self.rays_per_frame, 0.0, f64::INFINITY),
        ];
        for (name, found, least, most) in numbers {
            if !(found.is_finite() && (least..=most).contains(&found)) {
                return Err(BakeError::Setting {
                    name,
                    found,
                    least,
                    most,
                });
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
        let mut out = vec![("clips".to_owned(), clips)];
        let mut add = |name: &str, value: String| out.push((name.to_owned(), value));
        add("pose_space", self.pose_space.listed());
        if self.pose_space.is_random() {
            add("pose_samples", self.random_samples().to_string());
            add("seed", self.seed.to_string());
        }
        if let PoseSpace::Limits(limits) = &self.pose_space {
            add("joint_limits", limits.joints.listed());
            add("limit_slack_deg", limits.slack_deg.to_string());
        }
        add("sample_step_seconds", self.sample_step_seconds.to_string());
        match self.bounds {
            Bounds::Sampled => add("bounds", "sampled".to_owned()),
            Bounds::Envelope => {
                add("bounds", "envelope".to_owned());
                add("envelopes", self.envelopes.to_string());
            }
        }
        add("tree", self.tree.name().to_owned());
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
            ("segments", self.segments.to_string()),
            ("size_worth", self.size_worth.to_string()),
            ("rays_per_frame", self.rays_per_frame.to_string()),
        ] {
            add(name, value);
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
