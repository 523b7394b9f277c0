use super::{
    Fault, FrameRange, ImportError, ImportSettings, Imported,
    cache::{Cache, mdd, pc2},
    fault_list::FaultList,
    inputs,
    keyframes::{self, Motion, Origin},
    obj::mesh,
    timeline::Timeline,
};
use std::path::Path;

/// A file that has been read.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReadFile<'a> {
    pub path: &'a Path,
    pub bytes: &'a [u8],
}

/// Reads an OBJ mesh from memory, and a vertex cache (PC2, told by content, else MDD) that moves it.
///
/// Each comes as its name, which stands in errors, and its bytes. Guarantee and errors: as
/// [`import_files`](super::import_files).
pub fn import_obj_bytes(
    (mesh_name, mesh_bytes): (&str, &[u8]),
    cache: Option<(&str, &[u8])>,
    settings: &ImportSettings,
) -> Result<Imported, ImportError> {
    settings.check()?;
    let file = |(name, bytes)| ReadFile {
        path: Path::new(name),
        bytes,
    };
    import_mesh(file((mesh_name, mesh_bytes)), cache.map(file), settings)
}

/// As [`import_obj_bytes`], for files at paths.
pub(super) fn import_mesh(
    mesh_file: ReadFile,
    cache_file: Option<ReadFile>,
    settings: &ImportSettings,
) -> Result<Imported, ImportError> {
    let stem = name_of(mesh_file.path.file_stem());
    let mut faults = FaultList::default();
    let mesh = mesh::read(mesh_file.bytes, &stem, &mut faults);
    if faults.has_errors() {
        return Err(failed(mesh_file.path, faults));
    }
    let origin = Origin {
        source_name: name_of(mesh_file.path.file_name()),
        source_hash: hash(mesh_file.bytes, cache_file.map(|file| file.bytes)),
        node_name: stem,
    };
    let Some(file) = cache_file else {
        warn_about_unused(settings, &mut faults);
        return Ok(keyframes::scene(origin, &mesh, None, faults));
    };
    let cache = match read_cache(file, &mut faults) {
        Ok(cache) => cache,
        Err(fault) => {
            faults.push(fault);
            return Err(failed(file.path, faults));
        }
    };
    if cache.point_count != mesh.positions.len() {
        return Err(ImportError::PointCount {
            cache: file.path.to_owned(),
            cache_points: cache.point_count,
            mesh: mesh_file.path.to_owned(),
            mesh_points: mesh.positions.len(),
        });
    }
    let motion = motion(file.path, &cache, settings, &mut faults)?;
    if faults.has_errors() {
        return Err(failed(file.path, faults));
    }
    Ok(keyframes::scene(origin, &mesh, Some(motion), faults))
}

fn read_cache<'a>(file: ReadFile<'a>, faults: &mut FaultList) -> Result<Cache<'a>, Fault> {
    if file.bytes.starts_with(pc2::MAGIC) || inputs::extension(file.path) == "pc2" {
        pc2::read(file.bytes, faults)
    } else {
        mdd::read(file.bytes, faults)
    }
}

fn motion(
    path: &Path,
    cache: &Cache,
    settings: &ImportSettings,
    faults: &mut FaultList,
) -> Result<Motion, ImportError> {
    let kept = settings.kept_frames(path, cache.frame_count)?;
    let timeline = match Timeline::new(kept, || cache.seconds(kept, settings), faults) {
        Ok(timeline) => timeline,
        Err(fault) => {
            faults.push(fault);
            return Err(failed(path, std::mem::take(faults)));
        }
    };
    Ok(Motion {
        clip_name: name_of(path.file_stem()),
        timeline,
        point_count: cache.point_count,
        positions: cache.positions(kept, faults),
    })
}

/// BLAKE3 of the mesh's file; with a cache, of both files, each after its length.
fn hash(mesh: &[u8], cache: Option<&[u8]>) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    match cache {
        None => {
            hasher.update(mesh);
        }
        Some(cache) => {
            for bytes in [mesh, cache] {
                hasher.update(&(bytes.len() as u64).to_le_bytes());
                hasher.update(bytes);
            }
        }
    }
    *hasher.finalize().as_bytes()
}

/// Warns where settings are given for frames that the source does not have.
pub(super) fn warn_about_unused(settings: &ImportSettings, faults: &mut FaultList) {
    if settings.frame_rate.is_some() || settings.frames != FrameRange::default() {
        let message = "frame rate and frame range are for vertex caches and OBJ sequences; they are ignored here";
        faults.warn("", message);
    }
}

/// The faults as an error.
pub(super) fn failed(path: &Path, faults: FaultList) -> ImportError {
    ImportError::Faults {
        path: path.to_owned(),
        faults: faults.into_faults(),
    }
}

/// A name, or nothing.
pub(super) fn name_of(name: Option<&std::ffi::OsStr>) -> String {
    name.unwrap_or_default().to_string_lossy().into_owned()
}
