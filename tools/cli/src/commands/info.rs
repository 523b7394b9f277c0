use super::cache_contents::CacheContents;
use crate::{args::InfoArgs, failure::Failure, input_file, output::Answer, table::Table};
use restpose_formats::{
    Bounds, ModelView, TreeKind,
    rows::{ClipBoundsRow, MotionClass, NONE},
};
use serde::{Serialize, Serializer};
use std::collections::BTreeSet;

#[derive(Serialize)]
struct Report {
    file: String,
    file_bytes: u64,
    generator: String,
    source_name: String,
    source_hash: String,
    options_hash: String,
    #[serde(serialize_with = "as_object")]
    options: Vec<(String, String)>,
    bounds: Bounds,
    tree: TreeKind,
    parts: Vec<Part>,
    clips: Vec<Clip>,
    caches: Vec<CacheContents>,
    clusters: Vec<Cluster>,
    counts: Counts,
}

#[derive(Serialize)]
struct Part {
    name: String,
    class: &'static str,
    triangles: u32,
    vertices: u32,
    clusters: usize,
    source_node: u32,
    source_mesh: u32,
    source_skin: Option<u32>,
}

#[derive(Serialize)]
struct Clip {
    name: String,
    start_seconds: f32,
    end_seconds: f32,
    channels: u32,
    /// Where the asset is during it; none where nothing bounds some stretch of it.
    bounds: Option<[[f32; 3]; 2]>,
}

#[derive(Serialize)]
struct Cluster {
    bone: u32,
    bone_name: String,
    /// Track row; none where the bone alone moves it.
    track: Option<u32>,
    triangles: u32,
    nodes: u32,
    references: u32,
    influencing_bones: u32,
    envelopes: u32,
}

#[derive(Serialize)]
struct Counts {
    triangles: usize,
    degenerate_triangles: u32,
    vertices: usize,
    influences: usize,
    nodes: usize,
    bones: usize,
    morph_targets: usize,
    samples: usize,
    segments: usize,
    tracks: usize,
    track_keys: usize,
    kd_nodes: usize,
    wide_nodes: usize,
    references: usize,
    envelopes: u64,
}

/// Shows what a file holds.
pub fn run(args: &InfoArgs) -> Result<Answer, Failure> {
    let file_bytes = input_file::check(&args.file)?;
    let asset = input_file::open_asset(&args.file)?;
    let report = report(args.file.display().to_string(), file_bytes, asset.model());
    Answer::new(&report, text(&report))
}

fn report(file: String, file_bytes: u64, model: &ModelView<'_>) -> Report {
    let meta = &model.meta;
    let clusters_of = clusters_of_parts(model);
    let name = |names: &[String], row: usize| names.get(row).cloned().unwrap_or_default();
    let parts = model.parts.iter().enumerate().map(|(row, part)| Part {
        name: name(&meta.part_names, row),
        class: MotionClass::from_number(part.class).map_or("unknown", MotionClass::name),
        triangles: part.triangle_count,
        vertices: part.vertex_count,
        clusters: clusters_of.get(row).map_or(0, BTreeSet::len),
        source_node: part.source_node,
        source_mesh: part.source_mesh,
        source_skin: Some(part.source_skin).filter(|skin| *skin != NONE),
    });
    let clips = model.clips.iter().enumerate().map(|(row, clip)| Clip {
        name: name(&meta.clip_names, row),
        start_seconds: clip.start_seconds,
        end_seconds: clip.end_seconds,
        channels: clip.channel_count,
        bounds: ClipBoundsRow::around_clip(model.clip_bounds, row).map(|bounds| [bounds.min, bounds.max]),
    });
    let clusters = model.clusters.iter().enumerate().map(|(row, cluster)| Cluster {
        bone: cluster.bone,
        bone_name: name(&meta.bone_names, cluster.bone as usize),
        track: Some(cluster.track).filter(|track| *track != NONE),
        triangles: cluster.triangle_count,
        nodes: cluster.node_count,
        references: cluster.reference_count,
        influencing_bones: cluster.cluster_bone_count,
        envelopes: model.pose_spaces.get(row).map_or(0, |space| space.envelope_count),
    });
    Report {
        file,
        file_bytes,
        generator: meta.generator.clone(),
        source_name: meta.source_name.clone(),
        source_hash: hexadecimal(&model.hashes.source),
        options_hash: hexadecimal(&model.hashes.options),
        options: meta.options.clone(),
        bounds: meta.bounds,
        tree: meta.tree,
        parts: parts.collect(),
        clips: clips.collect(),
        caches: CacheContents::all(model),
        clusters: clusters.collect(),
        counts: Counts {
            triangles: model.triangles.len(),
            degenerate_triangles: meta.degenerate_triangle_count,
            // The last row only closes the influences of the one before.
            vertices: model.vertices.len().saturating_sub(1),
            influences: model.influences.len(),
            nodes: model.nodes.len(),
            bones: model.bones.len(),
            morph_targets: model.morph_targets.len(),
            samples: model.samples.len(),
            segments: model.segments.len(),
            tracks: model.tracks.len(),
            track_keys: model.keys.len(),
            kd_nodes: model.kd_nodes.len(),
            wide_nodes: model.wide_nodes.len(),
            references: model.references.len(),
            envelopes: model
                .pose_spaces
                .iter()
                .map(|space| u64::from(space.envelope_count))
                .sum(),
        },
    }
}

/// Per part, the clusters that hold some of its triangles, those of all time segments.
fn clusters_of_parts(model: &ModelView<'_>) -> Vec<BTreeSet<u32>> {
    let mut clusters_of = vec![BTreeSet::new(); model.parts.len()];
    for (number, row) in (0u32..).zip(model.clusters) {
        let references = row.reference_first as usize..row.reference_first as usize + row.reference_count as usize;
        for triangle in model.references.get(references).unwrap_or_default() {
            let after = model.parts.partition_point(|part| part.triangle_first <= *triangle);
            if let Some(own) = after.checked_sub(1).and_then(|part| clusters_of.get_mut(part)) {
                own.insert(number);
            }
        }
    }
    clusters_of
}

fn text(report: &Report) -> String {
    let counts = &report.counts;
    let mut lines = vec![
        format!(
            "{}: {} bytes, written by {}",
            report.file, report.file_bytes, report.generator
        ),
        format!("source    {} ({})", report.source_name, report.source_hash),
        format!(
            "triangles {} ({} without area)",
            counts.triangles, counts.degenerate_triangles
        ),
        format!("vertices  {} with {} influences", counts.vertices, counts.influences),
        format!("bones     {}", counts.bones),
        format!(
            "clusters  {} with {} nodes of {} trees, {} references",
            report.clusters.len(),
            counts.kd_nodes + counts.wide_nodes,
            report.tree.name(),
            counts.references
        ),
        match (report.bounds, report.caches.len()) {
            (Bounds::Sampled, 0) => format!("poses     {} sampled; boxes hold for these only", counts.samples),
            (Bounds::Sampled, _) => format!(
                "poses     {} sampled; boxes hold for the bones of these, and for vertex caches at any time",
                counts.samples
            ),
            (Bounds::Envelope, caches) => format!(
                "poses     {} sampled, in {} envelopes of clusters; boxes hold for everything in between, and widen outside{}",
                counts.samples,
                counts.envelopes,
                if caches == 0 {
                    ""
                } else {
                    "; for vertex caches at any time"
                }
            ),
        },
    ];
    let options: Vec<String> = report
        .options
        .iter()
        .map(|(name, value)| format!("{name}={value}"))
        .collect();
    lines.push(format!("options   {}", options.join(", ")));
    let mut parts = Table::new(["part", "class", "triangles", "vertices", "clusters"]);
    for part in &report.parts {
        parts.add([
            part.name.clone(),
            part.class.to_owned(),
            part.triangles.to_string(),
            part.vertices.to_string(),
            part.clusters.to_string(),
        ]);
    }
    let mut clips = Table::new(["clip", "from s", "to s", "channels", "bounded"]);
    for clip in &report.clips {
        clips.add([
            clip.name.clone(),
            format!("{:.3}", clip.start_seconds),
            format!("{:.3}", clip.end_seconds),
            clip.channels.to_string(),
            if clip.bounds.is_some() { "yes" } else { "no" }.to_owned(),
        ]);
    }
    let mut caches = Table::new([
        "vertex cache of",
        "keys",
        "segments",
        "tracks",
        "position bytes",
        "per vertex and key",
        "position error",
    ]);
    for cache in &report.caches {
        caches.add([
            cache.part.clone(),
            cache.keys.to_string(),
            cache.segments.len().to_string(),
            cache.tracks().to_string(),
            cache.position_bytes.to_string(),
            format!("{:.2}", cache.bytes_per_vertex_key),
            match cache.position_error {
                0.0 => "exact".to_owned(),
                error => format!("{error:.2e}"),
            },
        ]);
    }
    let mut clusters = Table::new([
        "cluster's bone",
        "track",
        "triangles",
        "nodes",
        "references",
        "influences",
        "envelopes",
    ]);
    for cluster in &report.clusters {
        clusters.add([
            cluster.bone_name.clone(),
            cluster
                .track
                .map_or_else(|| "none".to_owned(), |track| track.to_string()),
            cluster.triangles.to_string(),
            cluster.nodes.to_string(),
            cluster.references.to_string(),
            cluster.influencing_bones.to_string(),
            cluster.envelopes.to_string(),
        ]);
    }
    let tables = [
        parts.to_string(),
        clips.to_string(),
        caches.to_string(),
        clusters.to_string(),
    ];
    lines.extend(
        tables
            .into_iter()
            .filter(|table| !table.is_empty())
            .flat_map(|table| [String::new(), table]),
    );
    lines.join("\n")
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn as_object<S: Serializer>(options: &[(String, String)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(options.iter().map(|(name, value)| (name, value)))
}
