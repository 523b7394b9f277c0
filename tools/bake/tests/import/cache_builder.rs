//! Small vertex caches, built in code.

use restpose_bake::import::{Animation, Fault, ImportError, ImportSettings, Imported, Severity, import_obj_bytes};

/// One triangle.
pub const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

pub type Frame = Vec<[f32; 3]>;

/// A PC2 file; `start` and `step` in frames.
pub fn pc2(start: f32, step: f32, frames: &[Frame]) -> Vec<u8> {
    let mut out = b"POINTCACHE2\0".to_vec();
    out.extend(1i32.to_le_bytes());
    out.extend((frames[0].len() as i32).to_le_bytes());
    out.extend(start.to_le_bytes());
    out.extend(step.to_le_bytes());
    out.extend((frames.len() as i32).to_le_bytes());
    out.extend(
        frames
            .concat()
            .as_flattened()
            .iter()
            .flat_map(|value| value.to_le_bytes()),
    );
    out
}

/// An MDD file; `times` in seconds.
pub fn mdd(times: &[f32], frames: &[Frame]) -> Vec<u8> {
    let mut out = (frames.len() as i32).to_be_bytes().to_vec();
    out.extend((frames[0].len() as i32).to_be_bytes());
    out.extend(times.iter().flat_map(|value| value.to_be_bytes()));
    out.extend(
        frames
            .concat()
            .as_flattened()
            .iter()
            .flat_map(|value| value.to_be_bytes()),
    );
    out
}

/// Frames of points that all differ.
pub fn frames(frame_count: usize, point_count: usize) -> Vec<Frame> {
    let point = |frame: usize, point: usize| [frame as f32, point as f32, 0.5];
    (0..frame_count)
        .map(|frame| (0..point_count).map(|place| point(frame, place)).collect())
        .collect()
}

/// Imports an OBJ mesh, which must succeed without warning.
pub fn clean_mesh(obj: &str) -> Animation {
    clean(import_obj_bytes(
        ("mesh.obj", obj.as_bytes()),
        None,
        &ImportSettings::default(),
    ))
}

/// Imports [`TRIANGLE`] with a cache of this name.
pub fn with_cache(name: &str, cache: &[u8], settings: &ImportSettings) -> Result<Imported, ImportError> {
    import_obj_bytes(("mesh.obj", TRIANGLE.as_bytes()), Some((name, cache)), settings)
}

/// The animation of an import without warning.
pub fn clean(result: Result<Imported, ImportError>) -> Animation {
    let imported = result.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(imported.faults, []);
    imported.animation
}

/// The animation of an import with exactly one warning, and that.
pub fn warned(result: Result<Imported, ImportError>) -> (Animation, Fault) {
    let mut imported = result.unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(imported.faults.len(), 1, "{:?}", imported.faults);
    let fault = imported.faults.remove(0);
    assert_eq!(fault.severity, Severity::Warning);
    (imported.animation, fault)
}
