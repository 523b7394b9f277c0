use crate::MeasureError;
use restpose_bake::import::Animation;

/// Most times that a mesh is subdivided: 1,024 triangles of each.
const LARGEST_SUBDIVISION: u64 = 5;

/// Most triangles that are measured. A triangle takes about 300 bytes while its file and the static tree of a posed
/// frame are in memory.
const TRIANGLE_LIMIT: u64 = 1 << 25;

/// Refuses more subdivisions than a measurement takes; `setting` is their name.
pub(crate) fn check_subdivisions(
    setting: &'static str,
    subdivisions: u32,
    animation: &Animation,
) -> Result<(), MeasureError> {
    MeasureError::check_setting(setting, subdivisions.into(), 0, LARGEST_SUBDIVISION, "0 to 5")?;
    let parts = animation.parts.iter().map(|part| &animation.meshes[part.mesh]);
    let triangles: u64 = parts
        .flat_map(|mesh| &mesh.primitives)
        .map(|primitive| primitive.triangles.len() as u64)
        .sum();
    if triangles > TRIANGLE_LIMIT >> (2 * subdivisions) {
        return Err(MeasureError::TooManyTriangles {
            triangles,
            subdivisions,
            limit: TRIANGLE_LIMIT,
        });
    }
    Ok(())
}
