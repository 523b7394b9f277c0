use super::Context;
use crate::{
    args::{RenderArgs, Size},
    clip_choice::ClipChoice,
    exit_code::ExitCode,
    failure::Failure,
    input_file,
    output::Answer,
    output_folder::OutputFolder,
    picture::{AnimationFile, CameraPlace, ColourCount, Film, Look, Movement, decode_png, delays, encode_png},
    progress::{Reporter, StageSeconds},
};
use restpose_runtime::Asset;
use serde::Serialize;
use std::sync::Arc;

/// Name of the animated file.
pub const ANIMATION: &str = "animation.gif";

#[derive(Serialize)]
struct Report {
    file: String,
    view: &'static str,
    clip: Option<String>,
    width: u32,
    height: u32,
    frames: Vec<String>,
    animation: String,
    seconds: StageSeconds,
}

/// Renders a clip to pictures and an animation.
pub fn run(args: &RenderArgs, context: &Context) -> Result<Answer, Failure> {
    let choice = ClipChoice {
        clip: args.clip.as_deref(),
        from: args.from,
        to: args.to,
        frames: args.frames,
    };
    let look = look(args);
    input_file::check(&args.file)?;
    let mut folder = OutputFolder::prepare(&args.output)?;
    context.reporter.stage("open", 0);
    let asset = input_file::open_asset(&args.file)?;
    let movement = choice.movement(&asset)?;
    shoot(&asset, &movement, &look, &context.reporter, &mut folder)?;
    context.reporter.stage("publish", 0);
    let placed = folder.publish()?;
    let mut frames: Vec<String> = placed.iter().map(|path| path.display().to_string()).collect();
    let animation = frames.pop().unwrap_or_default();
    let clip = movement
        .clip
        .and_then(|clip| asset.model().meta.clip_names.get(clip).cloned());
    let plural = if frames.len() == 1 { "" } else { "s" };
    let text = format!(
        "{} frame{plural} and {ANIMATION} in {}",
        frames.len(),
        args.output.display()
    );
    let report = Report {
        file: args.file.display().to_string(),
        view: look.view.name(),
        clip,
        width: look.size.width,
        height: look.size.height,
        frames,
        animation,
        seconds: context.reporter.finish(),
    };
    Answer::new(&report, text)
}

fn look(args: &RenderArgs) -> Look {
    let camera = match args.camera {
        Some(place) => CameraPlace::At {
            place,
            target: args.target,
        },
        None => CameraPlace::Framing {
            yaw_deg: args.yaw,
            pitch_deg: args.pitch,
            target: args.target,
        },
    };
    Look {
        view: args.view,
        size: args.size,
        samples: args.samples,
        light: args.light,
        floor: !args.no_floor,
        camera,
        fov_deg: args.fov,
    }
}

/// Adds `frame_0000.png`, `frame_0001.png`, ... and, last, `animation.gif`.
pub fn shoot(
    asset: &Arc<Asset>,
    movement: &Movement,
    look: &Look,
    reporter: &Reporter,
    folder: &mut OutputFolder,
) -> Result<(), Failure> {
    reporter.stage("frame_clip", 0);
    let mut film = Film::new(asset, movement, look).map_err(internal)?;
    let Size { width, height } = look.size;
    let count = film.frame_count();
    let name = |frame: usize| format!("frame_{frame:04}.png");
    let mut colours = ColourCount::new();
    reporter.stage("trace", count as u64);
    for frame in 0..count {
        let rgb = film.picture(frame).map_err(internal)?;
        colours.add(&rgb);
        folder.add(&name(frame), &encode_png(&rgb, width, height).map_err(internal)?)?;
        reporter.advance(1);
    }
    // Frames are read back rather than kept: a long clip in a large size would not fit into memory.
    reporter.stage("animate", count as u64);
    let palette = colours.palette();
    let mut bytes = Vec::new();
    // The option's range ends far below the 65535 that a GIF can hold.
    let mut file = AnimationFile::new(&mut bytes, width as u16, height as u16, &palette).map_err(internal)?;
    for (frame, delay) in delays(count as u32, movement.duration).into_iter().enumerate() {
        file.add(&decode_png(&folder.read(&name(frame))?).map_err(internal)?, delay)
            .map_err(internal)?;
        reporter.advance(1);
    }
    file.finish().map_err(internal)?;
    folder.add(ANIMATION, &bytes)
}

/// A picture that could not be made: nothing that the user did.
pub fn internal(error: impl std::error::Error) -> Failure {
    Failure::new(ExitCode::Internal, format!("the pictures cannot be made: {error}"))
}
