use super::{Context, cache_lines::cache_lines};
use crate::{
    args::BakeArgs, exit_code::ExitCode, failure::Failure, input_file, output::Answer, pose_settings::with_poses,
    source_files, table::Table,
};
use restpose_bake::{
    BakeReport, BakeSettings, PartReport, StageSeconds, bake,
    import::{Fault, Imported},
    write_file,
};
use restpose_runtime::Asset;
use serde::Serialize;
use std::{
    path::{Path, PathBuf},
    time::Duration,
};

/// What the file's name ends in.
const EXTENSION: &str = "rpose";

#[derive(Serialize)]
struct Report<'a> {
    /// The first of `inputs`.
    input: String,
    inputs: Vec<String>,
    output: String,
    /// True when `--if-changed` found nothing to do; only the keys to `warnings` are there then.
    skipped: bool,
    file_bytes: u64,
    warnings: &'a [Fault],
    #[serde(flatten)]
    made: Option<Made<'a>>,
}

#[derive(Serialize)]
struct Made<'a> {
    parts: &'a [PartReport],
    triangles: u64,
    degenerate_triangles: u64,
    vertices: u64,
    bones: u64,
    clusters: u64,
    samples: u64,
    random_poses: u64,
    clips: u64,
    clips_bounded: u64,
    fuzzy_box_area: f64,
    tree_nodes: u64,
    tree_references: u64,
    seconds: Seconds,
}

#[derive(Serialize)]
struct Seconds {
    import: f64,
    #[serde(flatten)]
    bake: StageSeconds,
    write: f64,
    total: f64,
}

/// A baked and written file.
pub struct Written {
    pub report: BakeReport,
    pub file_bytes: u64,
    /// Writing the file.
    pub write: Duration,
}

/// Turns the files of a scene into a `.rpose` file.
pub fn run(args: &BakeArgs, context: &Context) -> Result<Answer, Failure> {
    let settings = settings(args)?;
    check_output(&args.inputs, &args.output)?;
    source_files::check(&args.inputs)?;

    let start = std::time::Instant::now();
    context.reporter.stage("import", 0);
    let imported = source_files::import(&args.inputs, &args.frames.settings())?;
    let import_time = start.elapsed();
    let (input, label) = (source_files::first(&args.inputs), source_files::label(&args.inputs));
    for fault in &imported.faults {
        context
            .reporter
            .message(&format!("warning: {label}: {fault}"), context.quiet);
    }
    let report = |skipped, file_bytes, made| Report {
        input: input.display().to_string(),
        inputs: source_files::listed(&args.inputs),
        output: args.output.display().to_string(),
        skipped,
        file_bytes,
        warnings: &imported.faults,
        made,
    };
    if args.if_changed && is_current(&args.output, &imported, &settings) {
        context.reporter.finish();
        let text = format!("{}: unchanged", args.output.display());
        return Answer::new(&report(true, input_file::check(&args.output)?, None), text);
    }
    let written = bake_to(&imported, &settings, input, &args.output, context)?;
    context.reporter.finish();
    let total = start.elapsed().as_secs_f64();
    let seconds = Seconds {
        import: import_time.as_secs_f64(),
        bake: written.report.seconds,
        write: written.write.as_secs_f64(),
        total,
    };
    let text = text(&written, &args.output, total);
    Answer::new(
        &report(false, written.file_bytes, Some(made(&written.report, seconds))),
        text,
    )
}

/// Bakes an imported animation and writes the file, complete or not at all.
pub fn bake_to(
    imported: &Imported,
    settings: &BakeSettings,
    input: &Path,
    output: &Path,
    context: &Context,
) -> Result<Written, Failure> {
    let baked = bake(&imported.animation, settings, &context.reporter).map_err(|error| Failure::bake(input, &error))?;
    context.reporter.stage("write", 0);
    let start = std::time::Instant::now();
    let bytes = restpose_formats::write(&baked.model)
        .map_err(|error| Failure::at(ExitCode::Internal, output, format!("{}: {error}", output.display())))?;
    write_file(output, &bytes).map_err(|error| Failure::io("write", output, &error))?;
    Ok(Written {
        report: baked.report,
        file_bytes: bytes.len() as u64,
        write: start.elapsed(),
    })
}

fn settings(args: &BakeArgs) -> Result<BakeSettings, Failure> {
    let settings = BakeSettings {
        tree: args.tree.kind(),
        class_overrides: args
            .classes
            .iter()
            .map(|forced| (forced.part.clone(), forced.class))
            .collect(),
        ..args.keyframed.settings()
    };
    with_poses(settings, &args.poses)
}

/// Sees that the output can be written, before the work whose result it takes.
fn check_output(inputs: &[PathBuf], output: &Path) -> Result<(), Failure> {
    let wrong = |message: String| Failure::at(ExitCode::CommandLine, output, message);
    if output.extension().is_none_or(|extension| extension != EXTENSION) {
        return Err(wrong(format!(
            "{}: the output's name must end in .{EXTENSION}",
            output.display()
        )));
    }
    if output.is_dir() {
        return Err(wrong(format!("{}: is a folder; name a file", output.display())));
    }
    let same = |a: &Path, b: &Path| matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b);
    if inputs.iter().any(|input| same(input, output)) {
        return Err(wrong(format!(
            "{}: input and output are the same file",
            output.display()
        )));
    }
    let folder = output
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    if !folder.is_dir() {
        let message = format!("{}: is not a folder; make it first", folder.display());
        return Err(Failure::at(ExitCode::Io, folder, message));
    }
    tempfile::Builder::new()
        .prefix(".restpose-")
        .tempfile_in(folder)
        .map_err(|error| Failure::io("write into the folder", folder, &error))?;
    Ok(())
}

/// True when the file was made from this source with these settings. A file that cannot be read is not.
fn is_current(output: &Path, imported: &Imported, settings: &BakeSettings) -> bool {
    Asset::open(output).is_ok_and(|asset| {
        let hashes = asset.model().hashes;
        hashes.source == imported.animation.source_hash
            && hashes.options == settings.hash(&imported.animation.import_options)
    })
}

fn made(report: &BakeReport, seconds: Seconds) -> Made<'_> {
    Made {
        parts: &report.parts,
        triangles: report.triangles,
        degenerate_triangles: report.degenerate_triangles,
        vertices: report.vertices,
        bones: report.bones,
        clusters: report.clusters,
        samples: report.samples,
        random_poses: report.random_poses,
        clips: report.clips,
        clips_bounded: report.clips_bounded,
        fuzzy_box_area: report.fuzzy_box_area,
        tree_nodes: report.tree_nodes,
        tree_references: report.tree_references,
        seconds,
    }
}

fn text(written: &Written, output: &Path, seconds: f64) -> String {
    let report = &written.report;
    let mut table = Table::new(["part", "class", "triangles", "clusters", "because"]);
    for part in &report.parts {
        table.add([
            part.name.clone(),
            part.class.name().to_owned(),
            part.triangles.to_string(),
            part.clusters.to_string(),
            part.reason.clone(),
        ]);
    }
    let caches: Vec<String> = report.parts.iter().filter_map(cache_lines).collect();
    let caches = caches.iter().map(|lines| format!("\n\n{lines}")).collect::<String>();
    format!(
        "{table}{caches}\n\n{}: {} bytes, {} triangles ({} without area), {} clusters, {} sampled poses ({} random), {} clips ({} bounded), {seconds:.2} s",
        output.display(),
        written.file_bytes,
        report.triangles,
        report.degenerate_triangles,
        report.clusters,
        report.samples,
        report.random_poses,
        report.clips,
        report.clips_bounded,
    )
}
