use super::{
    ConnectivityDifference, ImportError, ImportSettings, Imported,
    fault_list::FaultList,
    keyframes::{self, Motion, Origin},
    mesh_files::{failed, name_of},
    obj::{
        mesh::{self, ObjMesh},
        reader::{self, Sink},
    },
    ordinary_file,
    timeline::{Seconds, Timeline},
};
use std::path::{Path, PathBuf};

/// No point of an OBJ file takes fewer bytes: `v 0 0 0` and a line end.
const LEAST_POINT_BYTES: usize = 8;

/// Reads OBJ files as the frames of one mesh. The first kept one gives faces and groups; one file is in memory at a time,
/// and those that are not kept are not opened.
///
/// `named_after` is a folder or a file that gives the names.
pub(super) fn import_sequence(
    named_after: &Path,
    files: &[PathBuf],
    settings: &ImportSettings,
) -> Result<Imported, ImportError> {
    let kept = settings.kept_frames(named_after, files.len())?;
    let kept_files: Vec<(usize, &PathBuf)> = kept
        .numbers()
        .filter_map(|number| files.get(number).map(|path| (number, path)))
        .collect();
    let mut byte_count = 0usize;
    for (_, path) in &kept_files {
        let length = ordinary_file::named(path, ordinary_file::length(path))?;
        byte_count = byte_count.saturating_add(usize::try_from(length).unwrap_or(usize::MAX));
    }

    let (stem, source_name) = names(named_after);
    let mut hasher = blake3::Hasher::new();
    let mut faults = FaultList::default();
    let seconds = || Ok(Seconds::at_rate(kept, 0.0, 1.0, settings.frame_rate_or_default()));
    let timeline = match Timeline::new(kept, seconds, &mut faults) {
        Ok(timeline) => timeline,
        Err(fault) => {
            faults.push(fault);
            return Err(failed(named_after, faults));
        }
    };
    let mut read = |path: &Path| {
        let bytes = ordinary_file::named(path, ordinary_file::read(path))?;
        if kept.count > 1 {
            hasher.update(&(bytes.len() as u64).to_le_bytes());
        }
        hasher.update(&bytes);
        Ok(bytes)
    };
    let Some(((_, first_path), others)) = kept_files.split_first() else {
        return Err(ImportError::NoInput);
    };
    let mut mesh = mesh::read(&read(first_path)?, &stem, &mut faults);
    if faults.has_errors() {
        return Err(failed(first_path, faults));
    }
    let point_count = mesh.positions.len();
    let mut positions = std::mem::take(&mut mesh.positions);
    let expected = point_count
        .saturating_mul(kept.count)
        .min(byte_count / LEAST_POINT_BYTES);
    // Only spares copies; where it fails, the frames may still fit.
    let _ = positions.try_reserve_exact(expected.saturating_sub(point_count));
    for (number, path) in others {
        let mut sink = FrameSink {
            first: &mesh,
            first_point_count: point_count,
            begin: positions.len(),
            positions: &mut positions,
            face_count: 0,
            different: None,
        };
        let mut own_faults = FaultList::default();
        reader::read(&read(path)?, &mut sink, &mut own_faults);
        if own_faults.has_errors() {
            return Err(failed(path, own_faults));
        }
        if let Some(difference) = sink.difference() {
            return Err(ImportError::Connectivity {
                path: path.to_path_buf(),
                frame: *number,
                first: first_path.to_path_buf(),
                difference,
            });
        }
    }

    let motion = Motion {
        clip_name: stem.clone(),
        timeline,
        point_count,
        positions,
    };
    let origin = Origin {
        source_name,
        source_hash: *hasher.finalize().as_bytes(),
        node_name: stem,
    };
    Ok(keyframes::scene(origin, &mesh, Some(motion), faults))
}

/// The name of the scene's things, and that of the source.
fn names(named_after: &Path) -> (String, String) {
    if !named_after.is_dir() {
        return (name_of(named_after.file_stem()), name_of(named_after.file_name()));
    }
    // Of `.` and `..` the name is found only so.
    let whole = std::fs::canonicalize(named_after);
    let name = name_of(whole.as_deref().unwrap_or(named_after).file_name());
    (name.clone(), name)
}

/// Takes a frame's points, and compares its faces with those of the first frame.
struct FrameSink<'a> {
    first: &'a ObjMesh,
    first_point_count: usize,
    positions: &'a mut Vec<[f32; 3]>,
    /// Where this frame's points begin.
    begin: usize,
    face_count: usize,
    /// The first face that differs.
    different: Option<ConnectivityDifference>,
}

impl FrameSink<'_> {
    fn difference(self) -> Option<ConnectivityDifference> {
        let point_count = self.positions.len() - self.begin;
        if point_count != self.first_point_count {
            return Some(ConnectivityDifference::PointCount {
                expected: self.first_point_count,
                found: point_count,
            });
        }
        if self.face_count != self.first.faces.len() {
            return Some(ConnectivityDifference::FaceCount {
                expected: self.first.faces.len(),
                found: self.face_count,
            });
        }
        self.different
    }
}

impl Sink for FrameSink<'_> {
    fn point(&mut self, position: [f32; 3]) {
        self.positions.push(position);
    }

    fn face(&mut self, corners: &[u32], line: usize, _: &mut FaultList) {
        let expected = self.first.faces.get(self.face_count);
        if self.different.is_none() && expected != Some(corners) {
            self.different = Some(ConnectivityDifference::Corners {
                face: self.face_count,
                line,
                expected: expected.unwrap_or_default().to_vec(),
                found: corners.to_vec(),
            });
        }
        self.face_count += 1;
    }

    fn group(&mut self, _: &str) {}
}
