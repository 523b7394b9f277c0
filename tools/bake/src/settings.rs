use crate::BakeError;
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
}

impl Default for BakeSettings {
    fn default() -> Self {
        Self {
            clips: ClipSelection::All,
            sample_step_seconds: 1.0 / 60.0,
            bounds: Bounds::Sampled,
            class_overrides: Vec::new(),
        }
    }
}

impl BakeSettings {
    /// Refuses settings that no bake can follow.
    ///
    /// # Errors
    /// [`BakeError::SampleStep`].
    pub fn check(&self) -> Result<(), BakeError> {
        if self.sample_step_seconds.is_finite() && self.sample_step_seconds > 0.0 {
            Ok(())
        } else {
            Err(BakeError::SampleStep {
                found: self.sample_step_seconds,
            })
        }
    }

    /// Option names and values, in a fixed order: what the metadata keeps and the options hash is made of.
    #[must_use]
    pub fn listed(&self) -> Vec<(String, String)> {
        let clips = match &self.clips {
            ClipSelection::All => "all".to_owned(),
            ClipSelection::Named(names) => format!("{names:?}"),
        };
        let bounds = match self.bounds {
            Bounds::Sampled => "sampled",
        };
        let mut out = vec![
            ("clips".to_owned(), clips),
            ("sample_step_seconds".to_owned(), self.sample_step_seconds.to_string()),
            ("bounds".to_owned(), bounds.to_owned()),
        ];
        for (part, class) in &self.class_overrides {
            out.push((format!("class {part}"), class.name().to_owned()));
        }
        out
    }

    /// BLAKE3 of the program's version and the listed options, each string preceded by its length.
    #[must_use]
    pub fn hash(&self) -> [u8; 32] {
        let mut hasher = blake3::Hasher::new();
        let mut add = |text: &str| {
            hasher.update(&(text.len() as u64).to_le_bytes());
            hasher.update(text.as_bytes());
        };
        add(env!("CARGO_PKG_VERSION"));
        for (name, value) in self.listed() {
            add(&name);
            add(&value);
        }
        *hasher.finalize().as_bytes()
    }
}
