use super::{Context, bake::bake_to, render::shoot, verify};
use crate::{
    args::{DemoArgs, SamplesPerPixel, Size, Vector, View},
    clip_choice::ClipChoice,
    exit_code::ExitCode,
    failure::Failure,
    mapped_asset::map_own_file,
    output::Answer,
    output_folder::OutputFolder,
    picture::{CameraPlace, Film, Look, Movement, encode_png},
    progress::StageSeconds,
    source_files,
    table::Table,
};
use restpose_bake::{
    BakeSettings,
    import::ImportSettings,
    verify::{VerifyReport, VerifySettings},
};
use restpose_runtime::Asset;
use serde::Serialize;
use std::{
    collections::BTreeMap,
    ffi::OsStr,
    path::{Path, PathBuf},
    sync::Arc,
};

/// What a sample's files are called.
const EXTENSIONS: [&str; 5] = ["gltf", "glb", "obj", "pc2", "mdd"];
/// Frames of each animation.
const FRAMES: u32 = 24;
/// Sides of the animation's frames and of the single pictures, pixels.
const SIZES: [u32; 2] = [384, 640];
/// Rays that verify each sample.
const VERIFY_RAYS: u64 = 20_000;
/// The single pictures show the moment at this share of the clip.
const STILL_SHARE: f32 = 0.35;

#[derive(Serialize)]
struct Report {
    passed: bool,
    scenes: Vec<Scene>,
    seconds: StageSeconds,
}

#[derive(Serialize)]
struct Scene {
    name: String,
    /// The first of `sources`.
    source: String,
    sources: Vec<String>,
    file: String,
    file_bytes: u64,
    triangles: u64,
    clusters: u64,
    clip: Option<String>,
    animation: String,
    pictures: Vec<String>,
    verify: VerifyReport,
}

/// Bakes, maps, renders and verifies every sample.
pub fn run(args: &DemoArgs, context: &Context) -> Result<Answer, Failure> {
    let mut scenes = Vec::new();
    for (name, files) in &sources(&args.scenes)? {
        scenes.push(show(name, files, &args.output, context)?);
    }
    let failure = scenes
        .iter()
        .find_map(|scene| verify::failure(&scene.verify, Path::new(&scene.file)));
    let text = text(&scenes, &args.output);
    let report = Report {
        passed: failure.is_none(),
        scenes,
        seconds: context.reporter.finish(),
    };
    Answer::with_failure(&report, text, failure)
}

/// The scenes in a folder, by name: a mesh and a vertex cache of one name are one scene.
fn sources(folder: &Path) -> Result<BTreeMap<String, Vec<PathBuf>>, Failure> {
    let entries = std::fs::read_dir(folder).map_err(|error| {
        let message = format!(
            "{}: cannot read the sample scenes: {error}; run in the project's folder, or name theirs with --scenes",
            folder.display()
        );
        Failure::at(ExitCode::Io, folder, message)
    })?;
    let mut sources: BTreeMap<String, Vec<PathBuf>> = BTreeMap::new();
    for entry in entries {
        let path = entry.map_err(|error| Failure::io("read", folder, &error))?.path();
        let known = |extension: &OsStr| EXTENSIONS.iter().any(|known| extension == *known);
        if path.extension().is_some_and(known) {
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            sources.entry(name).or_default().push(path);
        }
    }
    if sources.is_empty() {
        let message = format!(
            "{}: holds no sample scenes (.{}); name their folder with --scenes",
            folder.display(),
            EXTENSIONS.join(", .")
        );
        return Err(Failure::at(ExitCode::Io, folder, message));
    }
    sources.values_mut().for_each(|files| files.sort());
    Ok(sources)
}

fn show(name: &str, files: &[PathBuf], output: &Path, context: &Context) -> Result<Scene, Failure> {
    let source = source_files::first(files);
    let file_name = format!("{name}.rpose");
    let target = output.join(name);
    context.reporter.set_label(name);
    let mut folder = OutputFolder::prepare(&target)?;

    context.reporter.stage("import", 0);
    let imported = source_files::import(files, &ImportSettings::default())?;
    let file = folder.claim(&file_name);
    let written = bake_to(&imported, &BakeSettings::default(), source, &file, context)?;
    let asset = Arc::new(map_own_file(&file).map_err(|error| Failure::open(&file, &error))?);

    let settings = VerifySettings {
        rays: VERIFY_RAYS,
        ..VerifySettings::default()
    };
    let verified = verify::check(
        &asset,
        &imported.animation,
        &target.join(&file_name),
        &settings,
        context,
    )?;

    let movement = ClipChoice {
        clip: None,
        from: None,
        to: None,
        frames: FRAMES,
    }
    .movement(&asset)?;
    shoot(
        &asset,
        &movement,
        &look(View::Shaded, SIZES[0]),
        &context.reporter,
        &mut folder,
    )?;
    let still = still(&movement);
    context.reporter.stage("pictures", View::ALL.len() as u64);
    for view in View::ALL {
        folder.add(&format!("{}.png", view.name()), &picture(&asset, &still, view)?)?;
        context.reporter.advance(1);
    }
    let clip = movement
        .clip
        .and_then(|clip| asset.model().meta.clip_names.get(clip).cloned());
    // The file is let go before it gets its final name: not every system renames a mapped file.
    drop(asset);
    folder.publish()?;
    let shown = |name: &str| target.join(name).display().to_string();
    Ok(Scene {
        source: source.display().to_string(),
        sources: source_files::listed(files),
        file: shown(&file_name),
        file_bytes: written.file_bytes,
        triangles: written.report.triangles,
        clusters: written.report.clusters,
        clip,
        animation: shown(super::render::ANIMATION),
        pictures: View::ALL
            .iter()
            .map(|view| shown(&format!("{}.png", view.name())))
            .collect(),
        verify: verified,
        name: name.to_owned(),
    })
}

fn look(view: View, side: u32) -> Look {
    Look {
        view,
        size: Size {
            width: side,
            height: side,
        },
        samples: SamplesPerPixel::Four,
        light: Vector::DEFAULT_LIGHT,
        floor: true,
        camera: CameraPlace::DEFAULT,
        fov_deg: CameraPlace::DEFAULT_FOV_DEG,
    }
}

/// A single moment of a movement.
fn still(movement: &Movement) -> Movement {
    let index = (movement.times.len() as f32 * STILL_SHARE) as usize;
    Movement {
        times: movement.times.get(index).copied().into_iter().collect(),
        duration: 0.0,
        ..movement.clone()
    }
}

fn picture(asset: &Arc<Asset>, still: &Movement, view: View) -> Result<Vec<u8>, Failure> {
    let look = look(view, SIZES[1]);
    let mut film = Film::new(asset, still, &look).map_err(super::render::internal)?;
    let rgb = film.picture(0).map_err(super::render::internal)?;
    encode_png(&rgb, look.size.width, look.size.height).map_err(super::render::internal)
}

fn text(scenes: &[Scene], output: &Path) -> String {
    let mut table = Table::new([
        "sample",
        "triangles",
        "clusters",
        "bytes",
        "rays",
        "hits",
        "missed",
        "wrong",
    ]);
    for scene in scenes {
        table.add([
            scene.name.clone(),
            scene.triangles.to_string(),
            scene.clusters.to_string(),
            scene.file_bytes.to_string(),
            scene.verify.rays.to_string(),
            scene.verify.hits.to_string(),
            scene.verify.missed.to_string(),
            scene.verify.wrong.to_string(),
        ]);
    }
    let mut lines = vec![
        table.to_string(),
        String::new(),
        format!("The pictures are in {}:", output.display()),
    ];
    for scene in scenes {
        lines.push(format!("  {}", scene.animation));
        lines.extend(scene.pictures.iter().map(|path| format!("  {path}")));
    }
    lines.join("\n")
}
