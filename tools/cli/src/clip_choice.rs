use crate::{exit_code::ExitCode, failure::Failure, picture::Movement};
use restpose_runtime::Asset;

/// The part of the command line that says what is played.
#[derive(Clone, Copy, Debug)]
pub struct ClipChoice<'a> {
    /// Name or number; the first clip if absent.
    pub clip: Option<&'a str>,
    /// Seconds; the clip's first key if absent.
    pub from: Option<f32>,
    /// Seconds; the clip's last key if absent.
    pub to: Option<f32>,
    /// Frames.
    pub frames: u32,
}

impl ClipChoice<'_> {
    /// What an asset shows for this choice.
    pub fn movement(&self, asset: &Asset) -> Result<Movement, Failure> {
        let clips = asset.model().clips;
        if clips.is_empty() && self.clip.is_none() && self.from.is_none() && self.to.is_none() {
            return Ok(Movement::rest());
        }
        let clip = self.index(asset)?;
        let row = clips.get(clip).ok_or_else(|| no_such_clip(asset, &clip.to_string()))?;
        let (from, to) = (
            self.from.unwrap_or(row.start_seconds),
            self.to.unwrap_or(row.end_seconds),
        );
        if from > to {
            let message = format!(
                "--from {from} lies after --to {to}; the clip runs from {} to {} s",
                row.start_seconds, row.end_seconds
            );
            return Err(Failure::new(ExitCode::CommandLine, message));
        }
        Ok(Movement::new(clip, from, to, self.frames))
    }

    fn index(&self, asset: &Asset) -> Result<usize, Failure> {
        match self.clip {
            None if asset.model().clips.is_empty() => Err(no_such_clip(asset, "0")),
            None => Ok(0),
            // A name comes first: clips may be named by numbers.
            Some(word) => asset
                .clip(word)
                .or_else(|| word.parse().ok().filter(|index| *index < asset.model().clips.len()))
                .ok_or_else(|| no_such_clip(asset, word)),
        }
    }
}

fn no_such_clip(asset: &Asset, word: &str) -> Failure {
    let names = &asset.model().meta.clip_names;
    let known: Vec<String> = names
        .iter()
        .enumerate()
        .map(|(i, name)| format!("{i} {name:?}"))
        .collect();
    let known = if known.is_empty() {
        "the file has no clips".to_owned()
    } else {
        format!("the file has {}", known.join(", "))
    };
    Failure::new(ExitCode::CommandLine, format!("no clip {word:?}: {known}"))
}
