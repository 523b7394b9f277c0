use super::{
    homes::{shared_points, weld},
    report::{CacheReport, ExpectedFrame},
    rows,
    segment::{PartKeys, Segment, SegmentOutput},
    split::split_in_time,
    structure::{fuzzy_trees, rebuilt_cost},
};
use crate::{
    BakeError, BakeSettings, Progress,
    cost::StructureCost,
    import::Animation,
    motion::Classified,
    motion::keyframed::{DecomposeSettings, TrackKind},
};
use restpose_formats::{
    Model,
    geom::{Aabb, round::f32_above},
    rows::{CacheRow, KeyVertexRow, MotionClass, NONE},
};
use std::borrow::Cow;

/// Part of the model's diagonal that positions may be off by where the settings do not say.
const DEFAULT_POSITION_ERROR: f64 = 1.0 / 65_536.0;

/// Bakes the caches of all parts that have one: their rows, and their part's class, reason and rest positions.
///
/// Gives one report per part, `None` for those without a cache.
pub(crate) fn add_caches(
    model: &mut Model,
    animation: &Animation,
    classes: &mut [Classified],
    settings: &BakeSettings,
    progress: &dyn Progress,
) -> Result<Vec<Option<CacheReport>>, BakeError> {
    let mut out = Vec::with_capacity(classes.len());
    for (part, class) in classes.iter_mut().enumerate() {
        out.push(match model.parts[part].cache {
            NONE => None,
            cache => Some(add_cache(
                model,
                animation,
                part,
                cache as usize,
                class,
                settings,
                progress,
            )?),
        });
    }
    rows::close_words(model)?;
    Ok(out)
}

fn add_cache(
    model: &mut Model,
    animation: &Animation,
    part: usize,
    cache: usize,
    class: &mut Classified,
    settings: &BakeSettings,
    progress: &dyn Progress,
) -> Result<CacheReport, BakeError> {
    let mut keys = part_keys(animation, part);
    let triangles = triangles_with_area(model, part, &mut keys);
    if triangles.is_empty() {
        class.reason = "no triangle has an area in any key".to_owned();
        rows::add_free(model, cache, &keys.frames, &triangles, settings.tree)?;
        let nothing = ExpectedFrame::new(&StructureCost::default(), settings.rays_per_frame);
        return Ok(CacheReport::without_clusters(keys.frames.len(), nothing));
    }
    let budget = settings
        .position_error
        .unwrap_or_else(|| diagonal(&keys) * DEFAULT_POSITION_ERROR);
    let output = SegmentOutput {
        position_error: budget,
        tree: settings.tree,
        size_worth: settings.size_worth,
    };
    let decompose = DecomposeSettings {
        rigid_tolerance: budget,
        ..settings.motion.clone()
    };
    let last = keys.frames.len() - 1;
    let whole = Segment::new(&keys, 0..=last, &decompose, output, progress)?;
    let (one_cost, one_bytes) = (whole.cost, whole.byte_count());
    let segments = match class.asked {
        Some(MotionClass::Free) => vec![whole],
        _ => split_in_time(&keys, whole, settings.segments, &decompose, output, progress)?,
    };
    let (fuzzy, rebuilt) = (fuzzy_trees(&segments), rebuilt_cost(&keys));
    let costs = StructureCost::new(&fuzzy, rebuilt, triangles.len());
    let expected = ExpectedFrame::new(&costs, settings.rays_per_frame);
    let counts = KindCounts::new(&segments);
    let (found, numbers) = if counts.coherent_triangles == 0 && segments.iter().all(|one| one.clusters.len() == 1) {
        (MotionClass::Rigid, "one map moves all of it".to_owned())
    } else {
        let free = costs.is_free(settings.rays_per_frame);
        let class = if free {
            MotionClass::Free
        } else {
            MotionClass::Keyframed
        };
        (class, format!("{}; {expected}", counts.text()))
    };
    class.decide(&animation.parts[part].name, found, |asked| {
        let kind = if asked { "asked for; " } else { "" };
        format!("{kind}{numbers}")
    })?;

    let mut report = CacheReport {
        expected_cost: fuzzy.cost,
        expected_cost_one_segment: one_cost,
        expected_cost_rebuilt: rebuilt,
        bytes_one_segment: one_bytes,
        ..CacheReport::without_clusters(keys.frames.len(), expected)
    };
    model.parts[part].class = class.class as u32;
    let (vertex_first, vertex_count) = (model.parts[part].vertex_first as usize, keys.weld.len());
    let mut rest_key = 0;
    if class.class == MotionClass::Free {
        rows::add_free(model, cache, &keys.frames, &triangles, settings.tree)?;
        report.bytes = (vertex_count * (12 * keys.frames.len() + size_of::<KeyVertexRow>())) as u64;
        report.bytes_per_vertex_key = report.bytes as f64 / (vertex_count * keys.frames.len()) as f64;
    } else {
        rows::add_coherent(model, cache, &segments, &triangles)?;
        rest_key = segments[0].rest_key;
        report.add_segments(&segments, vertex_count);
    }
    model.caches[cache].position_error = f32_above(report.position_error);
    let rows = &mut model.vertices[vertex_first..vertex_first + vertex_count];
    for (row, position) in rows.iter_mut().zip(keys.frames[rest_key].iter()) {
        row.position_rest = *position;
    }
    Ok(report)
}

/// The part's positions in every key, by the order of its vertices in the file.
fn part_keys(animation: &Animation, part: usize) -> PartKeys<'_> {
    let source = &animation.parts[part];
    let primitives = &animation.meshes[source.mesh].primitives;
    let points: Vec<u32> = primitives
        .iter()
        .flat_map(|primitive| primitive.points.iter().copied())
        .collect();
    let cache = source.cache.map(|cache| &animation.caches[cache]);
    let in_order = cache.is_some_and(|cache| points.iter().copied().eq(0..cache.point_count as u32));
    let frames: Vec<Cow<[[f32; 3]]>> = cache
        .map(|cache| {
            (0..cache.frame_count())
                .map(|key| match cache.frame(key) {
                    frame if in_order => Cow::Borrowed(frame),
                    frame => points.iter().map(|point| frame[*point as usize]).collect(),
                })
                .collect()
        })
        .unwrap_or_default();
    let users = animation.parts.iter().filter(|other| other.cache == source.cache);
    let shared = shared_points(
        cache.map_or(0, |cache| cache.point_count),
        users.flat_map(|user| &animation.meshes[user.mesh].primitives),
    );
    PartKeys {
        weld: weld(&frames),
        frames,
        triangles: Vec::new(),
        raw: points.iter().map(|point| shared[*point as usize]).collect(),
    }
}

/// Fills in the triangles and gives their rows; those with two corners that coincide in every key are marked degenerate.
fn triangles_with_area(model: &mut Model, part: usize, keys: &mut PartKeys) -> Vec<u32> {
    let row = model.parts[part];
    let mut out = Vec::with_capacity(row.triangle_count as usize);
    for triangle in row.triangle_first..row.triangle_first + row.triangle_count {
        let corners = &mut model.triangles[triangle as usize].corners;
        let local = corners.map(|corner| corner - row.vertex_first);
        let [a, b, c] = local.map(|corner| keys.weld[corner as usize]);
        if a == b || b == c || c == a {
            *corners = [corners[0]; 3];
            model.meta.degenerate_triangle_count += 1;
        } else {
            keys.triangles.push(local);
            out.push(triangle);
        }
    }
    out
}

/// Greatest diagonal of the box around the part at any key.
fn diagonal(keys: &PartKeys) -> f64 {
    keys.frames.iter().fold(0.0, |longest, frame| {
        let bounds = Aabb::around(frame.iter().copied());
        let square: f64 = (0..3)
            .map(|k| (f64::from(bounds.max[k]) - f64::from(bounds.min[k])).powi(2))
            .sum();
        f64::max(longest, square.sqrt())
    })
}

/// Clusters and triangles by kind.
#[derive(Default)]
struct KindCounts {
    static_triangles: usize,
    rigid: usize,
    rigid_triangles: usize,
    coherent: usize,
    coherent_triangles: usize,
}

impl KindCounts {
    fn new(segments: &[Segment]) -> Self {
        let mut out = Self::default();
        // Triangles count once, as the first segment has them.
        for cluster in segments.iter().take(1).flat_map(|segment| &segment.clusters) {
            let triangles = cluster.triangles.len();
            match cluster.kind {
                TrackKind::Static => out.static_triangles += triangles,
                TrackKind::Rigid => {
                    out.rigid += 1;
                    out.rigid_triangles += triangles;
                }
                TrackKind::Coherent => {
                    out.coherent += 1;
                    out.coherent_triangles += triangles;
                }
            }
        }
        out
    }

    fn text(&self) -> String {
        let mut out = Vec::new();
        if self.static_triangles > 0 {
            out.push(format!("{} triangles never move", self.static_triangles));
        }
        if self.rigid > 0 {
            out.push(format!(
                "{} rigid clusters of {} triangles",
                self.rigid, self.rigid_triangles
            ));
        }
        if self.coherent > 0 {
            out.push(format!(
                "{} coherent clusters of {} triangles",
                self.coherent, self.coherent_triangles
            ));
        }
        out.join(", ")
    }
}

/// The row of a part's cache, before its segments are known.
pub(crate) fn cache_row(part: u32, bone: u32, key_count: u32) -> CacheRow {
    CacheRow {
        part,
        bone,
        key_count,
        segment_first: 0,
        segment_count: 0,
        position_error: 0.0,
        reserved: [0; 2],
    }
}
