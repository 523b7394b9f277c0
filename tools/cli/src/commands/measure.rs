use super::Context;
use crate::{
    args::{FrameArgs, MeasureArgs, MeasureTable},
    exit_code::ExitCode,
    failure::Failure,
    input_file,
    output::Answer,
    output_folder::OutputFolder,
    progress::StageSeconds,
    table::Table,
};
use restpose_bake::import::import;
use restpose_measure::{
    MeasureError,
    frame::{COLUMNS, FrameReport, FrameSettings, LEGEND, measure_frame, page},
};
use serde::Serialize;
use std::{
    num::NonZeroUsize,
    path::{Path, PathBuf},
};

#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    measured: &'a FrameReport,
    files: &'a [PathBuf],
    seconds: StageSeconds,
}

/// Measures one table.
pub fn run(args: &MeasureArgs, context: &Context) -> Result<Answer, Failure> {
    match &args.table {
        MeasureTable::Frame(args) => frame(args, context),
    }
}

fn frame(args: &FrameArgs, context: &Context) -> Result<Answer, Failure> {
    input_file::check(&args.source)?;
    let folder = args.output.as_deref().map(OutputFolder::prepare).transpose()?;
    context.reporter.stage("import", 0);
    let source = import(&args.source).map_err(|error| Failure::import(&args.source, error))?;
    let mut settings = FrameSettings {
        subdivide_max: args.subdivide,
        frames: usize::from(args.frames),
        ..FrameSettings::default()
    };
    if !args.thread_counts.is_empty() {
        settings.threads = args.thread_counts.iter().copied().map(NonZeroUsize::get).collect();
    }
    let measured =
        measure_frame(&source.animation, &settings, &context.reporter).map_err(|error| failure(&args.source, error))?;
    let files = match folder {
        Some(folder) => write(&measured, folder)?,
        None => Vec::new(),
    };
    let report = Report {
        measured: &measured,
        files: &files,
        seconds: context.reporter.finish(),
    };
    Answer::new(&report, text(&measured, &files))
}

fn write(measured: &FrameReport, mut folder: OutputFolder) -> Result<Vec<PathBuf>, Failure> {
    let json = serde_json::to_vec(measured).map_err(|error| {
        Failure::new(
            ExitCode::Internal,
            format!("the report cannot be written as JSON: {error}"),
        )
    })?;
    folder.add("frame.html", page(measured).as_bytes())?;
    folder.add("frame.json", &json)?;
    folder.publish()
}

fn failure(source: &Path, error: MeasureError) -> Failure {
    let code = match &error {
        MeasureError::Bake(error) => return Failure::bake(source, error),
        MeasureError::Setting { .. } | MeasureError::TooManyTriangles { .. } => ExitCode::CommandLine,
        MeasureError::WrongHit(_) => ExitCode::VerificationFailed,
        _ => ExitCode::Internal,
    };
    Failure::at(code, source, format!("{}: {error}", source.display()))
}

fn text(measured: &FrameReport, files: &[PathBuf]) -> String {
    let mut table = Table::new(COLUMNS);
    for row in &measured.rows {
        table.add(row.cells());
    }
    let mut lines = vec![table.to_string(), String::new(), LEGEND.to_owned()];
    lines.extend(files.iter().map(|path| path.display().to_string()));
    lines.join("\n")
}
