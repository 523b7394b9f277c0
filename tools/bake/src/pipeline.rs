use crate::{
    BakeError, BakeReport, BakeSettings, CacheReport, ClipSelection, PartReport, PoseSpace, Progress, StageSeconds,
    assemble::assemble,
    bounds::{Poses, bound_by_envelopes},
    caches::add_caches,
    clip_bounds::clip_bounds,
    import::Animation,
    motion::{Carried, Moving, classify, decompose, with_morph_caches},
    poses::{self, BoneSpans},
    trees,
};
use rayon::prelude::*;
use restpose_formats::{
    Bounds, Hashes, Model,
    geom::Aabb,
    rows::{ClipBoundsRow, MotionClass},
};
use std::time::Instant;

/// A baked animation.
#[derive(Clone, Debug)]
pub struct Baked {
    /// The contents of the file; [`restpose_formats::write`] makes it bytes.
    pub model: Model,
    /// What was found and made.
    pub report: BakeReport,
}

/// Bakes an animation: classify, assemble, sample, decompose, build, in this order.
///
/// Guarantee: the same model, bit for bit, for the same animation and settings, on any number of threads.
///
/// # Errors
/// [`BakeError`]: settings that do not fit the source, or a source too large for the format.
pub fn bake(animation: &Animation, settings: &BakeSettings, progress: &dyn Progress) -> Result<Baked, BakeError> {
    settings.check()?;
    let mut seconds = StageSeconds::default();
    let mut clock = Instant::now();
    let mut lap = |stage: &mut f64| *stage = std::mem::replace(&mut clock, Instant::now()).elapsed().as_secs_f64();

    progress.stage("assemble", 1);
    let clips = selected_clips(animation, &settings.clips)?;
    let posed_clips = clips_of_pose_space(animation, &clips, &settings.pose_space)?;
    let source = animation;
    let animation = &*with_morph_caches(source, &clips, settings);
    let mut moving = Moving::new(animation, &clips);
    if settings.pose_space.is_random() {
        moving.turn_joints(animation);
    }
    let mut classes = classify(animation, &moving, settings)?;
    let assembled = assemble(animation, &classes, &clips)?;
    let mut model = assembled.model;
    for (row, part) in model.parts.iter_mut().zip(&source.parts) {
        // A part whose morph targets became a cache has a mesh of its own.
        row.source_mesh = part.mesh as u32;
    }
    progress.advance(1);
    lap(&mut seconds.assemble);

    model.samples = poses::sample_rows(&model, &posed_clips, settings)?;
    progress.stage("sample", model.samples.len() as u64);
    let mut sampled = poses::evaluate(&model, &model.samples, progress)?;
    let of_clips = sampled.len();
    let random_poses = poses::random_poses(&model, settings, &sampled, progress)?;
    let random_pose_count = random_poses.len() as u64;
    sampled.extend(random_poses);
    lap(&mut seconds.sample);

    progress.stage("decompose", model.triangles.len() as u64);
    let mut carried = decompose(&model, &assembled.bones_of_part, &sampled, settings.bounds, progress);
    lap(&mut seconds.decompose);

    let mut spaces = Vec::new();
    if settings.bounds == Bounds::Envelope {
        progress.stage("bound", carried.len() as u64);
        let spans: Vec<_> = poses::spans(&model)
            .into_par_iter()
            .map(|span| (BoneSpans::new(&model, &span), span))
            .collect();
        let poses = Poses {
            spans: &spans,
            sampled: &sampled,
            of_clips,
            all_clips: posed_clips.len() == model.clips.len(),
        };
        spaces = bound_by_envelopes(&model, &mut carried, &poses, settings.envelopes, progress);
        lap(&mut seconds.bound);
    }

    progress.stage("build", carried.len() as u64);
    trees::add_clusters(&mut model, carried.clone(), &sampled, settings.tree, progress)?;
    for (cluster, space) in spaces.iter().enumerate() {
        space.add_rows(&mut model, cluster)?;
    }
    lap(&mut seconds.build);

    let caches = add_caches(&mut model, animation, &mut classes, settings, progress)?;
    if model.clusters.is_empty() {
        return Err(BakeError::NothingToTrace);
    }
    lap(&mut seconds.caches);

    progress.stage("bound clips", model.clips.len() as u64);
    model.clip_bounds = clip_bounds(&model, progress);
    lap(&mut seconds.clip_bounds);

    model.hashes = Hashes {
        source: animation.source_hash,
        options: settings.hash(&animation.import_options),
    };
    model.meta.generator = concat!("restpose ", env!("CARGO_PKG_VERSION")).to_owned();
    model.meta.source_name = animation.source_name.clone();
    model.meta.options = settings.listed(&animation.import_options);
    model.meta.bounds = settings.bounds;
    model.meta.tree = settings.tree;

    let is_bounded = |clip: &usize| ClipBoundsRow::around_clip(&model.clip_bounds, *clip).is_some();
    let bounded_clips = (0..model.clips.len()).filter(is_bounded).count();
    let reasons = classes.into_iter().map(|class| class.reason);
    let parts = part_reports(&model, &carried, reasons.zip(caches));
    let report = BakeReport {
        triangles: model.triangles.len() as u64,
        degenerate_triangles: u64::from(model.meta.degenerate_triangle_count),
        vertices: model.vertices.len().saturating_sub(1) as u64,
        bones: model.bones.len() as u64,
        clusters: model.clusters.len() as u64,
        samples: sampled.len() as u64,
        random_poses: random_pose_count,
        fuzzy_box_area: parts.iter().map(|part| part.fuzzy_box_area).sum(),
        parts,
        clips: model.clips.len() as u64,
        clips_bounded: bounded_clips as u64,
        tree_nodes: (model.kd_nodes.len() + model.wide_nodes.len()) as u64,
        tree_references: model.references.len() as u64,
        seconds,
    };
    Ok(Baked { model, report })
}

/// Numbers of the selected clips, ascending.
fn selected_clips(animation: &Animation, selection: &ClipSelection) -> Result<Vec<usize>, BakeError> {
    let names = match selection {
        ClipSelection::All => return Ok((0..animation.clips.len()).collect()),
        ClipSelection::Named(names) => names,
    };
    let all: Vec<usize> = (0..animation.clips.len()).collect();
    let mut out = Vec::new();
    for name in names {
        let found = clips_called(animation, &all, name);
        if found.is_empty() {
            return Err(BakeError::UnknownClip {
                name: name.clone(),
                known: labels(animation, &all),
            });
        }
        out.extend(found);
    }
    out.sort_unstable();
    out.dedup();
    Ok(out)
}

/// Rows of the clips that the pose space holds, ascending; `clips` are the numbers of those in the file.
fn clips_of_pose_space(
    animation: &Animation,
    clips: &[usize],
    pose_space: &PoseSpace,
) -> Result<Vec<usize>, BakeError> {
    let PoseSpace::Clip(name) = pose_space else {
        return Ok((0..clips.len()).collect());
    };
    let found = clips_called(animation, clips, name);
    if found.is_empty() {
        return Err(BakeError::PoseSpaceClip {
            name: name.clone(),
            known: labels(animation, clips),
        });
    }
    Ok((0..clips.len()).filter(|row| found.contains(&clips[*row])).collect())
}

/// Numbers of the clips among `clips` that a name or a number means.
///
/// A number chooses a clip that has a name, too, unless it is the name of another. Clips of one name go together: the file
/// tells them apart by nothing else.
fn clips_called(animation: &Animation, clips: &[usize], name: &str) -> Vec<usize> {
    let label = |number: usize| animation.clips[number].label(number);
    let is_name = clips.iter().any(|number| label(*number) == name);
    let by_number = || name.parse().ok().filter(|number| clips.contains(number)).map(label);
    let Some(meant) = is_name.then(|| name.to_owned()).or_else(by_number) else {
        return Vec::new();
    };
    clips.iter().copied().filter(|number| label(*number) == meant).collect()
}

fn labels(animation: &Animation, clips: &[usize]) -> Vec<String> {
    clips
        .iter()
        .map(|number| animation.clips[*number].label(*number))
        .collect()
}

fn part_reports(
    model: &Model,
    carried: &[Carried],
    found: impl Iterator<Item = (String, Option<CacheReport>)>,
) -> Vec<PartReport> {
    let parts = model.parts.iter().zip(&model.meta.part_names).zip(found);
    parts
        .map(|((row, name), (reason, cache))| {
            let begin = carried.partition_point(|carried| carried.triangle < row.triangle_first);
            let end = carried.partition_point(|carried| carried.triangle < row.triangle_first + row.triangle_count);
            let own = &carried[begin..end];
            let mut bones: Vec<u32> = own.iter().map(|carried| carried.bone).collect();
            bones.sort_unstable();
            bones.dedup();
            let rest_box = |triangle: u32| {
                let corners = model.triangles[triangle as usize].corners;
                Aabb::around(corners.map(|corner| model.vertices[corner as usize].position_rest)).surface_area()
            };
            PartReport {
                name: name.clone(),
                class: MotionClass::from_number(row.class).unwrap_or(MotionClass::Static),
                reason,
                triangles: u64::from(row.triangle_count),
                clusters: cache.as_ref().map_or(bones.len() as u64, |cache| {
                    cache.segments.iter().map(|segment| segment.clusters).sum()
                }),
                fuzzy_box_area: own.iter().map(|carried| carried.fuzzy_box.surface_area()).sum::<f64>()
                    + cache
                        .iter()
                        .flat_map(|cache| &cache.segments)
                        .map(|segment| segment.fuzzy_box_area)
                        .sum::<f64>(),
                rest_box_area: (row.triangle_first..row.triangle_first + row.triangle_count)
                    .map(rest_box)
                    .sum(),
                cache,
            }
        })
        .collect()
}
