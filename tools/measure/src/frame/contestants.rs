//! Everybody who takes part.

use super::{
    contestant::Contestant,
    crowd::Crowd,
    ours::{Ours, STRATEGIES},
    scene::FrameScene,
    settings::FrameSettings,
};
use crate::MeasureError;
use std::sync::Arc;

/// A contestant with its name, `who-strategy`.
pub(super) struct Named {
    pub name: &'static str,
    pub contestant: Box<dyn Contestant>,
}

/// Names of all strategies, of ours first.
#[must_use]
pub fn strategy_names() -> Vec<&'static str> {
    let ours = STRATEGIES.iter().map(|strategy| strategy.name);
    #[cfg(feature = "peers")]
    let ours = ours.chain(super::peers::PEERS.iter().map(|peer| peer.name));
    ours.collect()
}

/// Those that are chosen, for so many threads.
pub(super) fn contestants(
    scene: &FrameScene,
    crowd: &Arc<Crowd>,
    settings: &FrameSettings,
    #[cfg_attr(
        not(feature = "peers"),
        expect(unused_variables, reason = "the runtime takes those of its pool")
    )]
    threads: usize,
) -> Result<Vec<Named>, MeasureError> {
    let mut out: Vec<Named> = Vec::new();
    for strategy in STRATEGIES.iter().filter(|strategy| settings.chosen(strategy.name)) {
        if let Some(file) = scene.file(strategy.tree) {
            out.push(Named {
                name: strategy.name,
                contestant: Box::new(Ours::new(crowd, &file, strategy)?),
            });
        }
    }
    #[cfg(feature = "peers")]
    out.extend(super::peers::contestants(crowd, settings, threads)?);
    Ok(out)
}
