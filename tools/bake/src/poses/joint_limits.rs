use serde::{Deserialize, Deserializer, de::Error};
use std::{
    collections::BTreeMap,
    fs::File,
    io::{self, Read},
    path::Path,
};

/// Longest joint-limit file that is read: ten thousand joints take one of these.
const MOST_BYTES: u64 = 1 << 20;

/// How far joints turn, as a file says it. Joints that it does not name are none of its business.
///
/// A joint's rotation, relative to its own without any clip, is a rotation vector: axis times angle, in the joint's own
/// axes. Each of its components has a range.
///
/// The file is TOML:
///
/// ```toml
/// [joints."LeftForeArm"]
/// x = [-5, 140]
/// z = [-20, 20]
/// ```
///
/// Degrees within −180 to 180; an axis that is not there keeps still. Nodes that share a name share the ranges.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointLimits {
    /// Where they are from, for messages.
    pub source: String,
    /// By the name of the joint's node.
    pub joints: BTreeMap<String, JointRange>,
}

/// Ranges of a joint's rotation vector, from least to greatest, degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointRange {
    /// About the joint's x axis.
    #[serde(default, deserialize_with = "pair")]
    pub x: [f64; 2],
    /// About its y axis.
    #[serde(default, deserialize_with = "pair")]
    pub y: [f64; 2],
    /// About its z axis.
    #[serde(default, deserialize_with = "pair")]
    pub z: [f64; 2],
}

impl JointRange {
    /// The ranges about x, y, z.
    #[must_use]
    pub fn axes(&self) -> [[f64; 2]; 3] {
        [self.x, self.y, self.z]
    }
}

/// What is wrong with joint limits.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum JointLimitsError {
    /// The file cannot be read.
    #[error("{file}: cannot read: {cause}")]
    Read {
        /// File.
        file: String,
        /// Why.
        #[source]
        cause: io::Error,
    },
    /// The file is longer than any that is read.
    #[error("{file}: is longer than {MOST_BYTES} bytes; expected joint limits in TOML")]
    TooLong {
        /// File.
        file: String,
    },
    /// Not TOML, or not joint limits.
    #[error(
        "{file}: {place}: {message}; expected [joints.\"NAME\"] with x, y, z = [LEAST, GREATEST] in degrees, in TOML"
    )]
    Syntax {
        /// File.
        file: String,
        /// The line, and the joint where it is about one.
        place: String,
        /// What the parser says.
        message: String,
    },
    /// A limit is not an angle that a joint can have.
    #[error("{file}: joint {joint:?}: {axis} = {found}; expected degrees from -180 to 180")]
    Angle {
        /// File.
        file: String,
        /// Joint.
        joint: String,
        /// `x`, `y` or `z`.
        axis: &'static str,
        /// Limit given.
        found: f64,
    },
    /// The least angle is greater than the greatest.
    #[error("{file}: joint {joint:?}: {axis} = [{least}, {greatest}] is reversed; expected the least angle first")]
    Reversed {
        /// File.
        file: String,
        /// Joint.
        joint: String,
        /// `x`, `y` or `z`.
        axis: &'static str,
        /// First angle.
        least: f64,
        /// Second angle.
        greatest: f64,
    },
    /// The file names joints that the bake has not.
    #[error("{file}: no joint is called {unknown}; the skins have: {known}", unknown = quoted(.unknown), known = quoted(.known))]
    Unknown {
        /// File.
        file: String,
        /// Names that no joint has.
        unknown: Vec<String>,
        /// Names that joints have.
        known: Vec<String>,
    },
}

impl JointLimitsError {
    /// The file at fault, as [`JointLimits::source`].
    #[must_use]
    pub fn file(&self) -> &str {
        match self {
            Self::Read { file, .. }
            | Self::TooLong { file }
            | Self::Syntax { file, .. }
            | Self::Angle { file, .. }
            | Self::Reversed { file, .. }
            | Self::Unknown { file, .. } => file,
        }
    }
}

fn quoted(names: &[String]) -> String {
    if names.is_empty() {
        return "none".to_owned();
    }
    let names: Vec<String> = names.iter().map(|name| format!("{name:?}")).collect();
    names.join(", ")
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Contents {
    joints: BTreeMap<String, JointRange>,
}

/// Exactly two numbers: for an array of two the TOML parser would overlook what follows.
fn pair<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f64; 2], D::Error> {
    let numbers = Vec::<f64>::deserialize(deserializer)?;
    numbers
        .try_into()
        .map_err(|numbers: Vec<f64>| D::Error::invalid_length(numbers.len(), &"two angles"))
}

impl JointLimits {
    /// Reads a file.
    ///
    /// # Errors
    /// All but [`JointLimitsError::Unknown`], which only the bake can tell.
    pub fn read(path: &Path) -> Result<Self, JointLimitsError> {
        let file = path.display().to_string();
        let bytes = read_ordinary(path).map_err(|cause| JointLimitsError::Read {
            file: file.clone(),
            cause,
        })?;
        if bytes.len() as u64 > MOST_BYTES {
            return Err(JointLimitsError::TooLong { file });
        }
        match str::from_utf8(&bytes) {
            Ok(text) => Self::parse(&file, text),
            Err(error) => Err(JointLimitsError::Syntax {
                place: line(&bytes[..error.valid_up_to()]),
                message: "not UTF-8".to_owned(),
                file,
            }),
        }
    }

    /// Reads the text of a file that messages call `source`.
    ///
    /// # Errors
    /// [`JointLimitsError::Syntax`], `Angle`, `Reversed`.
    pub fn parse(source: &str, text: &str) -> Result<Self, JointLimitsError> {
        let syntax = |path: Option<String>, error: &toml::de::Error| {
            let line = error
                .span()
                .map(|span| line(&text.as_bytes()[..span.start.min(text.len())]));
            let place: Vec<String> = line.into_iter().chain(path).collect();
            JointLimitsError::Syntax {
                file: source.to_owned(),
                place: place.join(", "),
                message: error.message().to_owned(),
            }
        };
        let parser = toml::Deserializer::parse(text).map_err(|error| syntax(None, &error))?;
        let contents: Contents = serde_path_to_error::deserialize(parser).map_err(|error| {
            let path = Some(error.path().to_string()).filter(|path| path != ".");
            syntax(path, error.inner())
        })?;
        let limits = Self {
            source: source.to_owned(),
            joints: contents.joints,
        };
        limits.check()?;
        Ok(limits)
    }

    /// Refuses angles that no joint can have.
    ///
    /// # Errors
    /// [`JointLimitsError::Angle`], `Reversed`.
    pub fn check(&self) -> Result<(), JointLimitsError> {
        for (joint, range) in &self.joints {
            for (axis, [least, greatest]) in ["x", "y", "z"].into_iter().zip(range.axes()) {
                let (file, joint) = (self.source.clone(), joint.clone());
                let wrong = [least, greatest]
                    .into_iter()
                    .find(|angle| !(-180.0..=180.0).contains(angle));
                if let Some(found) = wrong {
                    return Err(JointLimitsError::Angle {
                        file,
                        joint,
                        axis,
                        found,
                    });
                }
                if least > greatest {
                    return Err(JointLimitsError::Reversed {
                        file,
                        joint,
                        axis,
                        least,
                        greatest,
                    });
                }
            }
        }
        Ok(())
    }

    /// All names and ranges in one line, without the source: what the options of a file keep.
    #[must_use]
    pub fn listed(&self) -> String {
        let joints = self.joints.iter().map(|(name, range)| {
            let [x, y, z] = range.axes().map(|[least, greatest]| format!("{least}..{greatest}"));
            format!("{name:?} {x} {y} {z}")
        });
        joints.collect::<Vec<_>>().join(", ")
    }
}

/// A little more than the longest file that is read, so that longer ones show. A pipe or a device could block.
fn read_ordinary(path: &Path) -> io::Result<Vec<u8>> {
    if !std::fs::metadata(path)?.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "not an ordinary file"));
    }
    let mut bytes = Vec::new();
    File::open(path)?.take(MOST_BYTES + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The line that follows these bytes of a text.
fn line(before: &[u8]) -> String {
    format!("line {}", 1 + before.iter().filter(|byte| **byte == b'\n').count())
}
