use super::{Context, measure_frame};
use crate::{
    args::{BuildersArgs, MeasureArgs, MeasureTable, MotionArgs, PosesArgs, TessellationsArgs},
    exit_code::ExitCode,
    failure::Failure,
    input_file,
    output::Answer,
    output_folder::OutputFolder,
    progress::StageSeconds,
    source_files,
    table::Table,
};
use restpose_bake::{BakeSettings, import::import};
use restpose_measure::{
    MeasureError, TextRow,
    builders::{self, BuilderScene, BuildersReport, BuildersSettings, measure_builders},
    motion::{self, MotionReport, MotionSettings, measure_motion},
    poses::{self, PosesReport, PosesSettings, measure_poses},
    tessellations::{self, TessellationsReport, TessellationsSettings, measure_tessellations},
};
use serde::Serialize;
use std::{
    num::NonZeroUsize,
    path::{Path, PathBuf},
};

#[derive(Serialize)]
struct Report<'a, M> {
    #[serde(flatten)]
    measured: &'a M,
    files: &'a [PathBuf],
    seconds: StageSeconds,
}

/// Measures one table.
pub fn run(args: &MeasureArgs, context: &Context) -> Result<Answer, Failure> {
    match &args.table {
        MeasureTable::Frame(args) => measure_frame::run(args, context),
        MeasureTable::Tessellations(args) => tessellations(args, context),
        MeasureTable::Motion(args) => motion(args, context),
        MeasureTable::Poses(args) => poses(args, context),
        MeasureTable::Builders(args) => builders(args, context),
    }
}

fn tessellations(args: &TessellationsArgs, context: &Context) -> Result<Answer, Failure> {
    input_file::check(&args.source)?;
    let folder = args.output.as_deref().map(OutputFolder::prepare).transpose()?;
    context.reporter.stage("import", 0);
    let source = import(&args.source).map_err(|error| Failure::import(&args.source, error))?;
    let mut settings = TessellationsSettings {
        subdivide_max: args.subdivide,
        frames: usize::from(args.frames),
        tree: args.tree.kind(),
        ..TessellationsSettings::default()
    };
    if !args.thread_counts.is_empty() {
        settings.threads = args.thread_counts.iter().copied().map(NonZeroUsize::get).collect();
    }
    let measured = measure_tessellations(&source.animation, &settings, &context.reporter)
        .map_err(|error| failure(&args.source, error))?;
    let files = write("tessellations", &measured, &tessellations::page(&measured), folder)?;
    answer(&measured, tessellations_lines(&measured), &files, context)
}

fn motion(args: &MotionArgs, context: &Context) -> Result<Answer, Failure> {
    source_files::check(&args.inputs)?;
    let folder = args.output.as_deref().map(OutputFolder::prepare).transpose()?;
    context.reporter.stage("import", 0);
    let source = source_files::import(&args.inputs, &args.frames.settings())?;
    let bake = BakeSettings {
        tree: args.tree.kind(),
        class_overrides: args
            .classes
            .iter()
            .map(|class| (class.part.clone(), class.class))
            .collect(),
        ..args.keyframed.settings()
    };
    let mut settings = MotionSettings {
        poses: args.poses,
        picture_side: args.picture_side,
        random_rays: args.random_rays,
        repeats: args.repeats,
        ..MotionSettings::default()
    };
    if !args.thread_counts.is_empty() {
        settings.threads = args.thread_counts.iter().copied().map(NonZeroUsize::get).collect();
    }
    let measured = measure_motion(&source.animation, &bake, &settings, &context.reporter)
        .map_err(|error| failure(source_files::first(&args.inputs), error))?;
    let files = write("motion", &measured, &motion::page(&measured), folder)?;
    answer(&measured, motion_lines(&measured), &files, context)
}

fn poses(args: &PosesArgs, context: &Context) -> Result<Answer, Failure> {
    source_files::check(&args.scenes)?;
    let folder = args.output.as_deref().map(OutputFolder::prepare).transpose()?;
    let settings = PosesSettings {
        rays: args.rays,
        poses: args.poses,
        levels: args.levels,
        clip: args.clip.clone(),
        repeats: args.repeats,
        seed: args.seed,
        tree: args.tree.kind(),
    };
    let mut measured: Option<PosesReport> = None;
    for path in &args.scenes {
        if args.scenes.len() > 1 {
            context.reporter.set_label(&path.display().to_string());
        }
        context.reporter.stage("import", 0);
        let source = import(path).map_err(|error| Failure::import(path, error))?;
        let own =
            measure_poses(&source.animation, &settings, &context.reporter).map_err(|error| failure(path, error))?;
        match &mut measured {
            Some(all) => all.append(own),
            None => measured = Some(own),
        }
    }
    // The command line has at least one scene.
    let Some(measured) = measured else {
        return Err(Failure::new(ExitCode::CommandLine, "no scene given".to_owned()));
    };
    let files = write("poses", &measured, &poses::page(&measured), folder)?;
    answer(&measured, poses_lines(&measured), &files, context)
}

fn builders(args: &BuildersArgs, context: &Context) -> Result<Answer, Failure> {
    let sources: Vec<Vec<PathBuf>> = args.scenes.iter().map(|scene| source_files::joined(scene)).collect();
    sources.iter().try_for_each(|paths| source_files::check(paths))?;
    let folder = args.output.as_deref().map(OutputFolder::prepare).transpose()?;
    let mut settings = BuildersSettings {
        shuffled: args.shuffled,
        repeats: args.repeats,
        seconds: args.seconds,
        picture_side: args.picture_side,
        random_rays: args.random_rays,
        frames: args.animation_frames,
        seed: args.seed,
        ..BuildersSettings::default()
    };
    if !args.builders.is_empty() {
        settings.builders.clone_from(&args.builders);
    }
    if !args.thread_counts.is_empty() {
        settings.threads = args.thread_counts.iter().copied().map(NonZeroUsize::get).collect();
        settings.threads.sort_unstable();
        settings.threads.dedup();
    }
    let mut measured: Option<BuildersReport> = None;
    let mut measure = |scene: &BuilderScene, path: &Path| {
        let own = measure_builders(scene, &settings, &context.reporter).map_err(|error| failure(path, error))?;
        match &mut measured {
            Some(all) => all.append(own),
            None => measured = Some(own),
        }
        Ok(())
    };
    for paths in &sources {
        let path = source_files::first(paths);
        context.reporter.set_label(&path.display().to_string());
        context.reporter.stage("import", 0);
        let source = source_files::import(paths, &args.frames.settings())?;
        let scene =
            BuilderScene::imported(&source.animation, args.animation_frames).map_err(|error| failure(path, error))?;
        measure(&scene, path)?;
    }
    for generated in &args.generated {
        let name = generated.to_string();
        context.reporter.set_label(&name);
        context.reporter.stage("generate", 0);
        let scene = BuilderScene::generated(*generated, args.seed);
        measure(&scene, Path::new(&name))?;
    }
    // The command line has at least one scene.
    let Some(measured) = measured else {
        return Err(Failure::new(ExitCode::CommandLine, "no scene given".to_owned()));
    };
    let files = write("builders", &measured, &builders::page(&measured), folder)?;
    answer(&measured, builders_lines(&measured), &files, context)
}

pub(super) fn answer(
    measured: &impl Serialize,
    mut lines: Vec<String>,
    files: &[PathBuf],
    context: &Context,
) -> Result<Answer, Failure> {
    let report = Report {
        measured,
        files,
        seconds: context.reporter.finish(),
    };
    lines.extend(files.iter().map(|path| path.display().to_string()));
    Answer::new(&report, lines.join("\n"))
}

/// Writes the page and the report, under this name, into the folder if there is one.
pub(super) fn write(
    name: &str,
    measured: &impl Serialize,
    page: &str,
    folder: Option<OutputFolder>,
) -> Result<Vec<PathBuf>, Failure> {
    let Some(mut folder) = folder else {
        return Ok(Vec::new());
    };
    let json = serde_json::to_vec(measured).map_err(|error| {
        Failure::new(
            ExitCode::Internal,
            format!("the report cannot be written as JSON: {error}"),
        )
    })?;
    folder.add(&format!("{name}.html"), page.as_bytes())?;
    folder.add(&format!("{name}.json"), &json)?;
    folder.publish()
}

pub(super) fn failure(source: &Path, error: MeasureError) -> Failure {
    let code = match &error {
        MeasureError::Bake(error) => return Failure::bake(source, error),
        MeasureError::Setting { .. }
        | MeasureError::TooManyTriangles { .. }
        | MeasureError::UnknownBuilder { .. }
        | MeasureError::UnknownStrategy { .. }
        | MeasureError::NoStrategy { .. }
        | MeasureError::NoReference { .. } => ExitCode::CommandLine,
        MeasureError::NoClip { .. } | MeasureError::Boxes { .. } => ExitCode::InvalidInput,
        MeasureError::WrongHit(_) | MeasureError::WrongTreeHit(_) | MeasureError::WrongFrame { .. } => {
            ExitCode::VerificationFailed
        }
        _ => ExitCode::Internal,
    };
    Failure::at(code, source, format!("{}: {error}", source.display()))
}

fn tessellations_lines(measured: &TessellationsReport) -> Vec<String> {
    let mut table = Table::new(tessellations::COLUMNS);
    for row in &measured.rows {
        table.add(row.cells());
    }
    vec![table.to_string(), String::new(), tessellations::LEGEND.to_owned()]
}

fn motion_lines(measured: &MotionReport) -> Vec<String> {
    let mut table = Table::new(motion::COLUMNS);
    table.add(measured.primary.cells("camera"));
    table.add(measured.wide.cells("wide camera"));
    table.add(measured.random.cells("random"));
    let mut lines = vec![table.to_string(), String::new(), motion::LEGEND.to_owned()];
    lines.extend(measured.facts());
    lines
}

fn poses_lines(measured: &PosesReport) -> Vec<String> {
    [
        rows_lines(&measured.pose_spaces),
        rows_lines(&measured.thesis_pose_spaces),
        rows_lines(&measured.bounds),
        rows_lines(&measured.tessellations),
        rows_lines(&measured.thesis_tessellations),
        rows_lines(&measured.accuracy),
    ]
    .concat()
}

fn builders_lines(measured: &BuildersReport) -> Vec<String> {
    [
        rows_lines(&measured.orders()),
        rows_lines(&measured.animations),
        rows_lines(&measured.builds),
    ]
    .concat()
}

pub(super) fn rows_lines<const N: usize, R: TextRow<N>>(rows: &[R]) -> Vec<String> {
    if rows.is_empty() {
        return Vec::new();
    }
    let mut table = Table::new(R::COLUMNS);
    for row in rows {
        table.add(row.cells());
    }
    vec![
        format!("{}: {}", R::TITLE, R::LEGEND),
        String::new(),
        table.to_string(),
        String::new(),
    ]
}
