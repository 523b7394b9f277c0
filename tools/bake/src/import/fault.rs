use std::path::PathBuf;

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
    /// Where: a JSON pointer such as `/meshes/0/primitives/1/attributes/POSITION`; empty for the file as a whole.
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
    #[error("{path}: {found}; expected a glTF 2.0 file (.gltf or .glb)", path = .path.display())]
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
}
