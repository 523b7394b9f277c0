use super::Context;
use crate::{
    args::VerifyArgs, exit_code::ExitCode, failure::Failure, import_options::import_settings, input_file,
    output::Answer, progress::StageSeconds, source_files, table::Table,
};
use restpose_bake::{
    import::Animation,
    verify::{PoseSource, VerifyReport, VerifySettings, verify},
};
use restpose_runtime::{Asset, formats::Bounds};
use serde::Serialize;
use std::{path::Path, sync::Arc};

#[derive(Serialize)]
struct Report<'a> {
    file: String,
    /// The first of `sources`.
    source: String,
    sources: Vec<String>,
    passed: bool,
    #[serde(flatten)]
    verified: &'a VerifyReport,
    seconds: StageSeconds,
}

/// Compares a file with brute force on its source.
pub fn run(args: &VerifyArgs, context: &Context) -> Result<Answer, Failure> {
    source_files::check(&args.sources)?;
    context.reporter.stage("open", 0);
    let asset = input_file::open_asset(&args.file)?;
    context.reporter.stage("import", 0);
    let import_settings = import_settings(&args.file, &asset.model().meta.options)?;
    let source = source_files::import(&args.sources, &import_settings)?.animation;
    let settings = VerifySettings {
        rays: args.rays,
        poses: args.poses,
        pose_source: args.pose_source.map(PoseSource::from),
        seed: args.seed,
    };
    let verified = check(&asset, &source, &args.file, &settings, context)?;
    let failure = failure(&verified, &args.file);
    let report = Report {
        file: args.file.display().to_string(),
        source: source_files::first(&args.sources).display().to_string(),
        sources: source_files::listed(&args.sources),
        passed: failure.is_none(),
        verified: &verified,
        seconds: context.reporter.finish(),
    };
    Answer::with_failure(&report, text(&verified, asset.model().caches.len()), failure)
}

/// Verifies an asset, once it is sure that it was baked from this source.
pub fn check(
    asset: &Arc<Asset>,
    source: &Animation,
    file: &Path,
    settings: &VerifySettings,
    context: &Context,
) -> Result<VerifyReport, Failure> {
    if asset.model().hashes.source != source.source_hash {
        let message = format!(
            "{}: was not baked from this source as it is now ({}); name all files that it was baked from, or bake it again",
            file.display(),
            source.source_name
        );
        return Err(Failure::at(ExitCode::InvalidInput, file, message));
    }
    verify(asset, source, settings, &context.reporter)
        .map_err(|error| Failure::at(ExitCode::Internal, file, format!("{}: {error}", file.display())))
}

/// What makes a verification fail: any hit that is missed or wrong.
pub fn failure(verified: &VerifyReport, file: &Path) -> Option<Failure> {
    (verified.missed > 0 || verified.wrong > 0).then(|| {
        let lossy = verified.bounds == Bounds::Sampled && verified.pose_source != PoseSource::Samples;
        let reason = if lossy {
            "; its boxes were bounded around samples and hold in no other pose: bake it with --bounds envelope"
        } else {
            ""
        };
        let message = format!(
            "{}: verification failed: {} hits missed, {} wrong{reason}",
            file.display(),
            verified.missed,
            verified.wrong
        );
        Failure::at(ExitCode::VerificationFailed, file, message)
    })
}

fn text(verified: &VerifyReport, cache_count: usize) -> String {
    let bones = match verified.pose_source {
        PoseSource::Samples => format!("samples of {}", verified.samples),
        PoseSource::Clips => "clips at random times and keys".to_owned(),
        PoseSource::Random => format!("random, of {} families", verified.families.len()),
    };
    let caches = match cache_count {
        0 => "",
        _ => "; vertex caches at keys and at random times between",
    };
    let mut lines = vec![
        format!("rays              {}", verified.rays),
        format!("poses             {} ({bones}{caches})", verified.poses),
        format!("hits              {}", verified.hits),
        format!("missed            {}", verified.missed),
        format!("wrong             {}", verified.wrong),
        format!(
            "max vertex error  {:.2e} of the model's size",
            verified.max_vertex_error
        ),
    ];
    if !verified.families.is_empty() {
        lines.extend([String::new(), families(verified).to_string()]);
    }
    lines.join("\n")
}

fn families(verified: &VerifyReport) -> Table<10> {
    let mut table = Table::new([
        "family",
        "poses",
        "rays",
        "hits",
        "missed",
        "wrong",
        "clusters",
        "without inverse",
        "outside",
        "largest excess",
    ]);
    for found in &verified.families {
        let numbers = [
            found.poses,
            found.rays,
            found.hits,
            found.missed,
            found.wrong,
            found.clusters,
            found.clusters_without_inverse,
            found.clusters_outside,
        ];
        let mut row = std::array::from_fn(|_| found.family.name().to_owned());
        row[1..]
            .iter_mut()
            .zip(numbers)
            .for_each(|(cell, number)| *cell = number.to_string());
        row[9] = format!("{:.2e}", found.largest_excess);
        table.add(row);
    }
    table
}
