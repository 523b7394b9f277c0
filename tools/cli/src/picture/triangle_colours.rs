use super::colour::{Colour, decode, distinct};
use restpose_formats::{ModelView, rows::ClusterRow};

/// Colours of parts in a shaded picture; parts beyond the last begin again.
const PART_COLOURS: [[u8; 3]; 6] = [
    [222, 190, 152],
    [158, 182, 190],
    [196, 150, 134],
    [176, 186, 142],
    [188, 168, 190],
    [204, 196, 176],
];

/// What no cluster holds: triangles without area, which no ray meets.
const NO_CLUSTER: Colour = Colour::splat(0.5);

/// A colour per triangle, by the part that it belongs to.
pub fn by_part(model: &ModelView<'_>) -> Vec<Colour> {
    let mut colours = vec![NO_CLUSTER; model.triangles.len()];
    for (part, srgb) in model.parts.iter().zip(PART_COLOURS.iter().cycle()) {
        let end = part.triangle_first.saturating_add(part.triangle_count);
        if let Some(own) = colours.get_mut(part.triangle_first as usize..end as usize) {
            own.fill(decode(*srgb));
        }
    }
    colours
}

/// A colour per triangle, by the bone whose cluster holds it.
pub fn by_cluster(model: &ModelView<'_>) -> Vec<Colour> {
    let mut colours = vec![NO_CLUSTER; model.triangles.len()];
    for cluster in model.clusters {
        for triangle in references(model, cluster) {
            if let Some(own) = colours.get_mut(*triangle as usize) {
                *own = distinct(cluster.bone);
            }
        }
    }
    colours
}

fn references<'a>(model: &ModelView<'a>, cluster: &ClusterRow) -> &'a [u32] {
    let end = cluster.reference_first.saturating_add(cluster.reference_count);
    model
        .references
        .get(cluster.reference_first as usize..end as usize)
        .unwrap_or_default()
}
