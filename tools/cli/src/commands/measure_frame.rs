use super::{
    Context,
    measure::{answer, failure, rows_lines, write},
};
use crate::{
    args::FrameArgs, exit_code::ExitCode, failure::Failure, output::Answer, output_folder::OutputFolder, source_files,
};
use restpose_bake::BakeSettings;
use restpose_measure::frame::{self, FrameReport, FrameScene, measure_frame};
use std::{
    collections::HashMap,
    path::{Path, PathBuf},
};

/// Measures whole frames of each scene.
pub fn run(args: &FrameArgs, context: &Context) -> Result<Answer, Failure> {
    let sources: Vec<Vec<PathBuf>> = args.scenes.iter().map(|scene| source_files::joined(scene)).collect();
    sources.iter().try_for_each(|paths| source_files::check(paths))?;
    if args.keep.is_some() {
        check_names(&sources)?;
    }
    let folder = args.output.as_deref().map(OutputFolder::prepare).transpose()?;
    let settings = args.settings();
    let mut measured: Option<FrameReport> = None;
    let mut files = Vec::new();
    for paths in &sources {
        let path = source_files::first(paths);
        if sources.len() > 1 {
            context.reporter.set_label(&path.display().to_string());
        }
        context.reporter.stage("import", 0);
        let kept = args.keep.as_deref().map(OutputFolder::prepare).transpose()?;
        let mut scene = scene(args, paths, context)?;
        scene
            .bake(&settings, &context.reporter)
            .map_err(|error| failure(path, error))?;
        if let Some(folder) = kept.filter(|_| !is_baked(path)) {
            files.extend(keep(&scene, args.subdivide, path, folder)?);
        }
        let own = measure_frame(&mut scene, &settings, &context.reporter).map_err(|error| failure(path, error))?;
        match &mut measured {
            Some(all) => all.append(own),
            None => measured = Some(own),
        }
    }
    // The command line has at least one scene.
    let Some(measured) = measured else {
        return Err(Failure::new(ExitCode::CommandLine, "no scene given".to_owned()));
    };
    files.extend(write("frame", &measured, &frame::page(&measured), folder)?);
    answer(&measured, lines(&measured), &files, context)
}

/// Refuses sources whose kept files would have one name.
fn check_names(sources: &[Vec<PathBuf>]) -> Result<(), Failure> {
    let mut known = HashMap::new();
    for path in sources.iter().map(|paths| source_files::first(paths)) {
        let stem = path.file_stem().filter(|_| !is_baked(path));
        if let Some(other) = stem.and_then(|stem| known.insert(stem, path)) {
            let (other, path) = (other.display(), path.display());
            let message =
                format!("{other}, {path}: --keep would write both to one file; measure them one after the other");
            return Err(Failure::new(ExitCode::CommandLine, message));
        }
    }
    Ok(())
}

fn is_baked(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "rpose")
}

fn keep(
    scene: &FrameScene,
    subdivisions: u32,
    source: &Path,
    mut folder: OutputFolder,
) -> Result<Vec<PathBuf>, Failure> {
    let name = source.file_stem().unwrap_or_default().to_string_lossy();
    for (tree, bytes) in scene.files() {
        let name = format!("{name}-{}-{}.rpose", 4u32.pow(subdivisions), tree.name());
        folder.add(&name, bytes)?;
    }
    folder.publish()
}

fn scene(args: &FrameArgs, paths: &[PathBuf], context: &Context) -> Result<FrameScene, Failure> {
    let path = source_files::first(paths);
    if is_baked(path) {
        if args.subdivide > 0 {
            let message = format!("{}: a baked file cannot be subdivided; give its source", path.display());
            return Err(Failure::new(ExitCode::CommandLine, message));
        }
        let bytes = std::fs::read(path).map_err(|error| Failure::io("read", path, &error))?;
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        return FrameScene::baked(name, bytes, args.instances).map_err(|error| failure(path, error));
    }
    let bake = BakeSettings {
        class_overrides: args
            .classes
            .iter()
            .map(|class| (class.part.clone(), class.class))
            .collect(),
        ..args.keyframed.settings()
    };
    let source = source_files::import(paths, &args.frames.settings())?;
    if args.subdivide > 0 {
        context.reporter.stage("subdivide", 0);
    }
    FrameScene::imported(&source.animation, args.subdivide, args.instances, bake).map_err(|error| failure(path, error))
}

fn lines(measured: &FrameReport) -> Vec<String> {
    [
        rows_lines(&measured.frames),
        rows_lines(&measured.crossovers),
        rows_lines(&measured.fixed_costs()),
        rows_lines(&measured.glances),
    ]
    .concat()
}
