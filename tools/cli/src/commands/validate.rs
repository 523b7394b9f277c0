use crate::{args::ValidateArgs, failure::Failure, input_file, output::Answer};
use serde::Serialize;

#[derive(Serialize)]
struct Report {
    file: String,
    valid: bool,
    file_bytes: u64,
    triangles: usize,
    clusters: usize,
    clips: usize,
}

/// Opens a file, which checks all of it.
pub fn run(args: &ValidateArgs) -> Result<Answer, Failure> {
    let file_bytes = input_file::check(&args.file)?;
    let asset = input_file::open_asset(&args.file)?;
    let model = asset.model();
    let report = Report {
        file: args.file.display().to_string(),
        valid: true,
        file_bytes,
        triangles: model.triangles.len(),
        clusters: model.clusters.len(),
        clips: model.clips.len(),
    };
    let text = format!(
        "{}: valid ({} bytes, {} triangles, {} clusters, {} clips)",
        report.file, report.file_bytes, report.triangles, report.clusters, report.clips
    );
    Answer::new(&report, text)
}
