use super::{
    follower::followers,
    list::{Builder, builders},
};
use crate::{MeasureError, thread_pools::THREAD_LIMIT};
use serde::Serialize;

/// What [`measure_builders`](super::measure_builders) measures.
#[derive(Clone, Debug, Serialize)]
pub struct BuildersSettings {
    /// Names of the builders, out of [`builder_names`]. Default: all.
    pub builders: Vec<String>,
    /// Thread counts of builders that make use of threads, ascending; the others run on one. Default 1, 2, 4 and so on up
    /// to all of the current pool; each at most 1,024.
    pub threads: Vec<usize>,
    /// Whether each scene is measured in random order, too. Default: yes.
    pub shuffled: bool,
    /// Times that each build is timed, in turns with all others; the median counts. Default 5; at least 1.
    pub repeats: u32,
    /// Seconds after which a build is not repeated any more. Default 10; at least 0.
    pub seconds: f64,
    /// Width and height of the picture whose camera rays are traced, pixels. Default 512; 1 to 8,192. Scenes of more than a
    /// million triangles get fewer rays.
    pub picture_side: u32,
    /// Random rays. Default 65,536; at least 1. Scenes of more than a million triangles get fewer.
    pub random_rays: u32,
    /// Most frames of an animation for which trees are built one after the other; 0 leaves that out. Default 50.
    pub frames: usize,
    /// Seed of generated scenes, of random order and of random rays. Default 1.
    pub seed: u64,
}

impl Default for BuildersSettings {
    fn default() -> Self {
        let all = rayon::current_num_threads();
        let mut threads: Vec<usize> = std::iter::successors(Some(1), |threads| Some(threads * 2))
            .take_while(|threads| *threads < all)
            .collect();
        threads.push(all);
        Self {
            builders: builder_names().into_iter().map(str::to_owned).collect(),
            threads,
            shuffled: true,
            repeats: 5,
            seconds: 10.0,
            picture_side: 512,
            random_rays: 1 << 16,
            frames: 50,
            seed: 1,
        }
    }
}

/// Names of all builders, in the order of the tables.
#[must_use]
pub fn builder_names() -> Vec<&'static str> {
    let mut names: Vec<&str> = builders().iter().map(|builder| builder.name).collect();
    for follower in followers() {
        if !names.contains(&follower.name) {
            names.push(follower.name);
        }
    }
    names
}

impl BuildersSettings {
    pub(super) fn check(&self) -> Result<(), MeasureError> {
        let at_least_one = |name, found| MeasureError::check_setting(name, found, 1, u64::MAX, "1 or more");
        let known = builder_names();
        if let Some(name) = self.builders.iter().find(|name| !known.contains(&name.as_str())) {
            return Err(MeasureError::UnknownBuilder {
                name: name.clone(),
                known: known.join(", "),
            });
        }
        let chosen = self.chosen();
        for follower in followers()
            .iter()
            .filter(|one| self.builders.iter().any(|name| name == one.name))
        {
            if !chosen.iter().any(|builder| builder.kind == follower.kind) {
                return Err(MeasureError::NoReference {
                    name: follower.name.to_owned(),
                    kind: follower.kind.name(),
                });
            }
        }
        at_least_one("number of builders", chosen.len() as u64)?;
        at_least_one("number of thread counts", self.threads.len() as u64)?;
        for threads in &self.threads {
            MeasureError::check_setting("threads", *threads as u64, 1, THREAD_LIMIT as u64, "1 to 1024")?;
        }
        at_least_one("repeats", self.repeats.into())?;
        MeasureError::check_setting("picture_side", self.picture_side.into(), 1, 8192, "1 to 8192")?;
        at_least_one("random_rays", self.random_rays.into())
    }

    /// The builders that are measured, in the order of the list.
    pub(super) fn chosen(&self) -> Vec<Builder> {
        let mut all = builders();
        all.retain(|builder| self.builders.iter().any(|name| name == builder.name));
        all
    }
}
