use super::{ImportError, cache::pc2, natural_order, ordinary_file};
use std::path::{Path, PathBuf};

/// What the inputs are together.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Source {
    Gltf(PathBuf),
    /// An OBJ file, and the vertex cache that moves it.
    Mesh {
        mesh: PathBuf,
        cache: Option<PathBuf>,
    },
    /// OBJ files, one per frame.
    Sequence {
        /// What the sequence is called after: the folder, else its first file.
        named_after: PathBuf,
        /// At least one, in the order in which they are played.
        files: Vec<PathBuf>,
    },
}

/// What one input is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Gltf,
    Obj,
    Cache,
    Folder,
}

/// Enough to see a byte-order mark, some white space and the first character behind it.
const START_BYTES: u64 = 64;

/// Tells what the inputs are, by content where content tells, else by extension; opens ordinary files only.
///
/// # Errors
/// [`ImportError::Read`], [`ImportError::UnknownFormat`], [`ImportError::NoInput`], [`ImportError::Inputs`].
pub(super) fn tell(inputs: &[PathBuf]) -> Result<Source, ImportError> {
    let kinds: Vec<Kind> = inputs.iter().map(|path| kind(path)).collect::<Result<_, _>>()?;
    Ok(match (inputs, kinds.as_slice()) {
        ([], _) => return Err(ImportError::NoInput),
        ([path], [Kind::Gltf]) => Source::Gltf(path.clone()),
        ([path], [Kind::Folder]) => Source::Sequence {
            files: obj_files(path)?,
            named_after: path.clone(),
        },
        ([mesh], [Kind::Obj]) => Source::Mesh {
            mesh: mesh.clone(),
            cache: None,
        },
        ([mesh, cache], [Kind::Obj, Kind::Cache]) | ([cache, mesh], [Kind::Cache, Kind::Obj]) => Source::Mesh {
            mesh: mesh.clone(),
            cache: Some(cache.clone()),
        },
        ([first, ..], kinds) if kinds.iter().all(|kind| *kind == Kind::Obj) => Source::Sequence {
            named_after: first.clone(),
            files: inputs.to_vec(),
        },
        _ => return Err(misfit(inputs, &kinds)),
    })
}

/// Which input does not fit the others, and why.
fn misfit(inputs: &[PathBuf], kinds: &[Kind]) -> ImportError {
    let nth = |kind: Kind, n: usize| {
        let mut matching = inputs.iter().zip(kinds).filter(|(_, found)| **found == kind);
        matching.nth(n).map(|(path, _)| path.clone())
    };
    let rules = [
        (Kind::Gltf, 0, "a glTF file goes with no other input"),
        (Kind::Folder, 0, "a folder of .obj files goes with no other input"),
        (Kind::Cache, 1, "is a second vertex cache"),
        (Kind::Obj, 1, "is a second .obj file beside a vertex cache"),
    ];
    let broken = rules
        .into_iter()
        .find_map(|(kind, n, found)| nth(kind, n).map(|path| (path, found)));
    let (path, found) = broken.unwrap_or_else(|| {
        let lonely = "a vertex cache has no faces: name the .obj file that it moves, too";
        (inputs.first().cloned().unwrap_or_default(), lonely)
    });
    ImportError::Inputs {
        path,
        found: found.to_owned(),
    }
}

fn kind(path: &Path) -> Result<Kind, ImportError> {
    if path.is_dir() {
        return Ok(Kind::Folder);
    }
    let start = ordinary_file::named(path, ordinary_file::read_start(path, START_BYTES))?;
    let text = start.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(&start);
    if start.starts_with(pc2::MAGIC) {
        return Ok(Kind::Cache);
    }
    if start.starts_with(b"glTF") || text.trim_ascii_start().starts_with(b"{") {
        return Ok(Kind::Gltf);
    }
    match extension(path).as_str() {
        "gltf" | "glb" => Ok(Kind::Gltf),
        "obj" => Ok(Kind::Obj),
        "pc2" | "mdd" => Ok(Kind::Cache),
        _ => Err(ImportError::UnknownFormat {
            path: path.to_owned(),
            found: if start.is_empty() {
                "the file is empty".to_owned()
            } else {
                "neither content nor extension tells what the file is".to_owned()
            },
        }),
    }
}

/// The extension in lower case; empty where there is none.
pub(super) fn extension(path: &Path) -> String {
    let extension = path.extension().unwrap_or_default();
    extension.to_string_lossy().to_ascii_lowercase()
}

/// The `.obj` files of a folder, in natural order of their names; hidden ones are not looked at.
fn obj_files(folder: &Path) -> Result<Vec<PathBuf>, ImportError> {
    let mut files = Vec::new();
    for entry in ordinary_file::named(folder, std::fs::read_dir(folder))? {
        let path = ordinary_file::named(folder, entry)?.path();
        let is_hidden = path
            .file_name()
            .is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
        if extension(&path) == "obj" && !is_hidden {
            files.push(path);
        }
    }
    if files.is_empty() {
        return Err(ImportError::Inputs {
            path: folder.to_owned(),
            found: "the folder holds no .obj files".to_owned(),
        });
    }
    let stem = |path: &PathBuf| path.file_stem().unwrap_or_default().as_encoded_bytes().to_vec();
    files.sort_by(|a, b| natural_order::compare(&stem(a), &stem(b)).then_with(|| a.cmp(b)));
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    /// What inputs with these names and contents are; of an error, the file and what is said of it.
    fn told(files: &[(&str, &[u8])]) -> Result<Source, (String, String)> {
        let folder = tempfile::tempdir().unwrap();
        let mut inputs = Vec::new();
        for (name, content) in files {
            let path = folder.path().join(name);
            match name.strip_suffix('/') {
                Some(_) => fs::create_dir(&path).unwrap(),
                None => fs::write(&path, content).unwrap(),
            }
            inputs.push(path);
        }
        let name = |path: PathBuf| path.file_name().unwrap().to_string_lossy().into_owned();
        tell(&inputs)
            .map(|source| match source {
                Source::Gltf(path) => Source::Gltf(name(path).into()),
                Source::Mesh { mesh, cache } => Source::Mesh {
                    mesh: name(mesh).into(),
                    cache: cache.map(|path| name(path).into()),
                },
                Source::Sequence { named_after, files } => Source::Sequence {
                    named_after: name(named_after).into(),
                    files: files.into_iter().map(|path| name(path).into()).collect(),
                },
            })
            .map_err(|error| match error {
                ImportError::Inputs { path, found } | ImportError::UnknownFormat { path, found } => (name(path), found),
                other => (String::new(), other.to_string()),
            })
    }

    #[test]
    fn content_goes_before_extension() {
        let gltf = |name: &str| Ok(Source::Gltf(name.into()));
        assert_eq!(told(&[("a.obj", b"glTF")]), gltf("a.obj"));
        assert_eq!(told(&[("a", b"\xEF\xBB\xBF \r\n{")]), gltf("a"));
        assert_eq!(told(&[("a.GLB", b"nonsense")]), gltf("a.GLB"));
        let mesh = |mesh: &str, cache: Option<&str>| {
            Ok(Source::Mesh {
                mesh: mesh.into(),
                cache: cache.map(PathBuf::from),
            })
        };
        assert_eq!(told(&[("a.OBJ", b"")]), mesh("a.OBJ", None));
        assert_eq!(told(&[("a.obj", b""), ("b", pc2::MAGIC)]), mesh("a.obj", Some("b")));
        assert_eq!(told(&[("b.mdd", b""), ("a.obj", b"")]), mesh("a.obj", Some("b.mdd")));
        assert_eq!(told(&[("b.pc2", b""), ("a.obj", b"")]), mesh("a.obj", Some("b.pc2")));
    }

    #[test]
    fn inputs_that_do_not_belong_together_are_refused_by_name() {
        let refused = |files: &[(&str, &[u8])]| told(files).unwrap_err().0;
        assert_eq!(refused(&[]), "");
        assert_eq!(refused(&[("a.txt", b"v 0 0 0")]), "a.txt");
        assert_eq!(refused(&[("a.obj", b""), ("a.txt", b"")]), "a.txt");
        assert_eq!(refused(&[("a.mdd", b"")]), "a.mdd");
        assert_eq!(refused(&[("a.obj", b""), ("b.mdd", b""), ("c.pc2", b"")]), "c.pc2");
        assert_eq!(refused(&[("a.obj", b""), ("b.obj", b""), ("c.pc2", b"")]), "b.obj");
        assert_eq!(refused(&[("a.obj", b""), ("b.glb", b"")]), "b.glb");
        assert_eq!(refused(&[("a.obj", b""), ("b/", b"")]), "b");
        assert_eq!(refused(&[("b/", b"")]), "b");
    }
}
