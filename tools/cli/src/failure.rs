use crate::exit_code::ExitCode;
use restpose_bake::{
    BakeError, JointLimitsError,
    import::{Fault, ImportError},
};
use restpose_runtime::OpenError;
use serde::{Serialize, Serializer, ser::SerializeStruct};
use std::path::Path;

/// Why a command did not do what was asked.
#[derive(Debug)]
pub struct Failure {
    /// How the program ends.
    pub code: ExitCode,
    /// What went wrong, where, and what to do.
    pub message: String,
    /// File or folder at fault.
    pub path: Option<String>,
    /// All faults found in a source file.
    pub faults: Vec<Fault>,
}

impl Failure {
    /// A failure without a file.
    pub fn new(code: ExitCode, message: impl Into<String>) -> Self {
        Self {
            code,
            message: message.into(),
            path: None,
            faults: Vec::new(),
        }
    }

    /// A failure about a file or folder.
    pub fn at(code: ExitCode, path: &Path, message: impl Into<String>) -> Self {
        Self {
            path: Some(path.display().to_string()),
            ..Self::new(code, message)
        }
    }

    /// A file or folder could not be read or written; `action` is a verb.
    pub fn io(action: &str, path: &Path, error: &std::io::Error) -> Self {
        Self::at(
            ExitCode::Io,
            path,
            format!("{}: cannot {action}: {error}", path.display()),
        )
    }

    /// A source was refused; the file at fault is the error's where it names one, else `path`.
    pub fn import(path: &Path, error: ImportError) -> Self {
        let code = match &error {
            ImportError::Read { .. } => ExitCode::Io,
            ImportError::UnsupportedExtensions { .. } | ImportError::TooManyFrames { .. } => ExitCode::Unsupported,
            ImportError::NoInput
            | ImportError::Inputs { .. }
            | ImportError::FrameRate { .. }
            | ImportError::FrameRange { .. } => ExitCode::CommandLine,
            _ => ExitCode::InvalidInput,
        };
        let message = error.to_string();
        let path = error.path().unwrap_or(path).to_owned();
        let faults = if let ImportError::Faults { faults, .. } = error {
            faults
        } else {
            Vec::new()
        };
        Self {
            faults,
            ..Self::at(code, &path, message)
        }
    }

    /// An imported animation was not baked.
    pub fn bake(path: &Path, error: &BakeError) -> Self {
        let code = match error {
            BakeError::JointLimits(error) => return Self::joint_limits(error),
            BakeError::SampleStep { .. }
            | BakeError::Setting { .. }
            | BakeError::UnknownClip { .. }
            | BakeError::PoseSpaceClip { .. }
            | BakeError::UnknownPart { .. }
            | BakeError::TooManySamples { .. } => ExitCode::CommandLine,
            BakeError::Class { .. } | BakeError::TooMany { .. } => ExitCode::Unsupported,
            BakeError::PoseOverflow { .. } | BakeError::NothingToTrace => ExitCode::InvalidInput,
            _ => ExitCode::Internal,
        };
        Self::at(code, path, format!("{}: {error}", path.display()))
    }

    /// Joint limits, from a file, were refused.
    pub fn joint_limits(error: &JointLimitsError) -> Self {
        let code = match error {
            JointLimitsError::Read { .. } => ExitCode::Io,
            _ => ExitCode::InvalidInput,
        };
        Self::at(code, Path::new(error.file()), error.to_string())
    }

    /// A `.rpose` file was refused.
    pub fn open(path: &Path, error: &OpenError) -> Self {
        let code = if matches!(error, OpenError::Format { .. }) {
            ExitCode::InvalidInput
        } else {
            ExitCode::Io
        };
        Self::at(code, path, error.to_string())
    }
}

impl Serialize for Failure {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut object = serializer.serialize_struct("Failure", 5)?;
        object.serialize_field("code", &self.code.number())?;
        object.serialize_field("name", self.code.name())?;
        object.serialize_field("message", &self.message)?;
        object.serialize_field("path", &self.path)?;
        object.serialize_field("faults", &self.faults)?;
        object.end()
    }
}
