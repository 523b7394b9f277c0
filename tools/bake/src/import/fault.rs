use super::{ConnectivityDifference, FrameRange};
use std::path::{Path, PathBuf};

/// How bad a fault is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// The bake goes on; the text says what was done instead.
    Warning,
    /// The bake cannot go on.
    Error,
}

/// Something wrong in a source file.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Fault {
    /// How bad it is.
    pub severity: Severity,
    /// Where: of a glTF file a JSON pointer such as `/meshes/0/primitives/1/attributes/POSITION`, of an OBJ file
    /// `line N` counted from 1, of a vertex cache `header`, `frame N` or `frame N point M` counted from 0; empty for
    /// the file as a whole.
    pub path: String,
    /// What was expected, what was found, what to do.
    pub message: String,
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.path.is_empty() {
            write!(f, "{}", self.message)
        } else {
            write!(f, "{}: {}", self.path, self.message)
        }
    }
}

/// The names, each with what the user can do about it where we know.
fn named(extensions: &[String]) -> String {
    let one = |name: &String| match super::gltf::remedy(name) {
        Some(remedy) => format!("{name} ({remedy})"),
        None => name.clone(),
    };
    extensions.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// What goes together as input.
const INPUTS: &str = "one glTF 2.0 file (.gltf or .glb), one OBJ mesh (.obj), an OBJ mesh and its vertex cache (.pc2 or \
    .mdd), several .obj files as frames, or a folder of them";

/// Why a source file was not imported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// The file cannot be read. A buffer beside it that cannot be read is a fault at `/buffers/N/uri`.
    #[error("{path}: cannot read: {source}", path = .path.display())]
    Read {
        /// File.
        path: PathBuf,
        /// Reason.
        source: std::io::Error,
    },
    /// No reader takes this kind of file.
    #[error("{path}: {found}; expected a glTF 2.0 file (.gltf or .glb), an OBJ mesh (.obj), a vertex cache (.pc2 or .mdd) or a folder of .obj files", path = .path.display())]
    UnknownFormat {
        /// File.
        path: PathBuf,
        /// What it is instead.
        found: String,
    },
    /// The file needs extensions that this reader does not have.
    #[error("{path}: needs glTF extensions that are not supported: {names}", path = .path.display(), names = named(.extensions))]
    UnsupportedExtensions {
        /// File.
        path: PathBuf,
        /// Their names, in the file's order.
        extensions: Vec<String>,
    },
    /// The file breaks rules; all faults found are listed.
    #[error("{path}: {count} fault(s); first: {first}", path = .path.display(), count = .faults.len(), first = .faults[0])]
    Faults {
        /// File.
        path: PathBuf,
        /// At least one of severity error.
        faults: Vec<Fault>,
    },
    /// No file is named.
    #[error("no input is named; expected {INPUTS}")]
    NoInput,
    /// The inputs do not belong together.
    #[error("{path}: {found}; expected {INPUTS}", path = .path.display())]
    Inputs {
        /// The one that does not fit.
        path: PathBuf,
        /// Why not.
        found: String,
    },
    /// The frame rate is not a positive number.
    #[error("the frame rate is {found} frames per second; expected a finite number above zero")]
    FrameRate {
        /// Rate given.
        found: f64,
    },
    /// The source does not have the frames that were asked for.
    #[error("{path}: asked for {range}, but it has {frame_count} frames; expected first ≤ last, last below {frame_count} (the first frame is 0), and a step of at least 1", path = .path.display())]
    FrameRange {
        /// Vertex cache, folder or first OBJ file.
        path: PathBuf,
        /// Range given.
        range: FrameRange,
        /// Frames of the source.
        frame_count: usize,
    },
    /// There are more frames than a channel can count.
    #[error("{path}: {found} frames, more than {limit}: keep fewer by range or step", path = .path.display())]
    TooManyFrames {
        /// Vertex cache, folder or first OBJ file.
        path: PathBuf,
        /// Frames to keep.
        found: usize,
        /// Most that are taken.
        limit: usize,
    },
    /// A vertex cache is not one of the mesh beside it.
    #[error("{cache}: has {cache_points} points, but {mesh} has {mesh_points}; expected as many, export both from one mesh", cache = .cache.display(), mesh = .mesh.display())]
    PointCount {
        /// Vertex cache.
        cache: PathBuf,
        /// Its points per frame.
        cache_points: usize,
        /// OBJ file.
        mesh: PathBuf,
        /// Its points.
        mesh_points: usize,
    },
    /// A frame of a sequence is another mesh than the first one.
    #[error("{path} (frame {frame}): {difference}; expected the faces of {first} in every frame, only points may move", path = .path.display(), first = .first.display())]
    Connectivity {
        /// First file that differs.
        path: PathBuf,
        /// Its number in the sequence, counted from 0.
        frame: usize,
        /// The file that it was compared with: the first kept frame.
        first: PathBuf,
        /// How it differs.
        difference: ConnectivityDifference,
    },
}

impl ImportError {
    /// The file or folder at fault, where there is one.
    #[must_use]
    pub fn path(&self) -> Option<&Path> {
        match self {
            Self::Read { path, .. }
            | Self::UnknownFormat { path, .. }
            | Self::UnsupportedExtensions { path, .. }
            | Self::Faults { path, .. }
            | Self::Inputs { path, .. }
            | Self::FrameRange { path, .. }
            | Self::TooManyFrames { path, .. }
            | Self::PointCount { cache: path, .. }
            | Self::Connectivity { path, .. } => Some(path),
            Self::NoInput | Self::FrameRate { .. } => None,
        }
    }
}
