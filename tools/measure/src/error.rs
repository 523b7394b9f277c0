use crate::{
    Place,
    builders::{TreeFault, TreeHit},
};
use restpose_bake::BakeError;
use restpose_formats::FormatError;
use restpose_runtime::{
    Hit, PoseError, Ray,
    build::{BuildError, BvhFault},
};

/// Why nothing was measured.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeasureError {
    /// A setting is out of its range.
    #[error("{name} is {found}; expected {expected}")]
    Setting {
        /// Field of the settings.
        name: &'static str,
        /// Value given.
        found: u64,
        /// Values that can be measured.
        expected: &'static str,
    },
    /// Subdivision makes more triangles than a measurement takes.
    #[error("{triangles} triangles subdivided {subdivisions} times are more than {limit}: ask for fewer subdivisions")]
    TooManyTriangles {
        /// Triangles of the source.
        triangles: u64,
        /// Subdivisions asked for.
        subdivisions: u32,
        /// Most triangles that are measured.
        limit: u64,
    },
    /// Nothing moves.
    #[error("{source_name} has no clip, so no motion can be measured: give an animated source")]
    NoClip {
        /// File name of the source.
        source_name: String,
    },
    /// Threads could not be started.
    #[error("{threads} threads cannot be started: {source}")]
    Threads {
        /// Threads asked for.
        threads: usize,
        /// Why not.
        source: rayon::ThreadPoolBuildError,
    },
    /// The source or one of its posed frames was not baked.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// What was baked was refused by the format; a defect of the bake.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// What was baked could not be posed; a defect of the bake.
    #[error(transparent)]
    Pose(#[from] PoseError),
    /// The bake depends on the number of threads; a defect of the bake.
    #[error("subdivided {subdivisions} times, {threads} threads bake another file than {first} do; please report this")]
    BakeDiffers {
        /// Subdivisions.
        subdivisions: u32,
        /// Threads of the first bake.
        first: usize,
        /// Threads of the bake that differs.
        threads: usize,
    },
    /// Two ways of tracing disagree, so their times mean nothing.
    #[error(transparent)]
    WrongHit(#[from] Box<WrongHit>),
    /// There is no such builder.
    #[error("no builder {name:?}; known: {known}")]
    UnknownBuilder {
        /// Name given.
        name: String,
        /// All there are.
        known: String,
    },
    /// There is no such strategy.
    #[error("no strategy {name:?}; known: {known}")]
    UnknownStrategy {
        /// Name given.
        name: String,
        /// All there are.
        known: String,
    },
    /// There is nothing to compare hits with.
    #[error("no strategy of restpose takes part in {scene}; choose one that its file can be used with")]
    NoStrategy {
        /// Scene.
        scene: String,
    },
    /// A contestant's hits are not those of the reference, so its times mean nothing.
    #[error(
        "{scene}, pose {pose}, {rays} rays: {wrong} of {count} hits of {strategy} are wrong, more than can be rounding; \
         please report this or leave it out"
    )]
    WrongFrame {
        /// Scene.
        scene: String,
        /// Strategy.
        strategy: &'static str,
        /// Number of the pose.
        pose: usize,
        /// Kind of the rays.
        rays: &'static str,
        /// Rays whose hit is wrong.
        wrong: usize,
        /// Rays.
        count: usize,
    },
    /// A file could not be written or mapped to time its opening.
    #[error("the file cannot be opened anew: {fault}")]
    Reopen {
        /// What happened.
        fault: String,
    },
    /// A builder that follows an animation stands alone.
    #[error("builder {name:?} is compared from frame to frame with another of {kind} trees; choose one of these, too")]
    NoReference {
        /// Name given.
        name: String,
        /// `bvh` or `kd`.
        kind: &'static str,
    },
    /// No tree can be built over the triangles' boxes.
    #[error("{scene}: {source}")]
    Boxes {
        /// Scene.
        scene: String,
        /// Why not.
        source: BuildError,
    },
    /// A builder's tree is none; a defect of the builder.
    #[error("{scene}: {builder} on {threads} threads: {source}; please report this")]
    Tree {
        /// Scene.
        scene: String,
        /// Builder.
        builder: String,
        /// Its threads.
        threads: usize,
        /// Why it is none.
        source: TreeFault,
    },
    /// A tree depends on the number of threads; a defect of the builder.
    #[error("{scene}: {builder} builds another tree on {threads} threads than on {first}; please report this")]
    TreeDiffers {
        /// Scene.
        scene: String,
        /// Builder.
        builder: String,
        /// Threads of the first build.
        first: usize,
        /// Threads of the build that differs.
        threads: usize,
    },
    /// A tree could not be refitted; a defect of its builder.
    #[error("{0}; please report this")]
    Refit(#[from] BvhFault),
    /// Somebody else's builder failed.
    #[cfg(feature = "peers")]
    #[error("{peer}: {fault}; leave it out")]
    Peer {
        /// Whose.
        peer: &'static str,
        /// What happened.
        fault: String,
    },
    /// Two trees disagree on what a ray hits, so their times mean nothing.
    #[error(transparent)]
    WrongTreeHit(#[from] Box<WrongTreeHit>),
}

impl MeasureError {
    /// A peer's failure.
    #[cfg(feature = "peers")]
    pub(crate) fn peer(peer: &'static str, fault: impl Into<String>) -> Self {
        Self::Peer {
            peer,
            fault: fault.into(),
        }
    }

    /// Refuses a setting that is not in `from..=to`.
    pub(crate) fn check_setting(
        name: &'static str,
        found: u64,
        from: u64,
        to: u64,
        expected: &'static str,
    ) -> Result<(), Self> {
        if (from..=to).contains(&found) {
            Ok(())
        } else {
            Err(Self::Setting { name, found, expected })
        }
    }
}

/// A ray whose hit is not the same in two ways of tracing it.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{place}: {traced} finds {found:?} and {reference} {expected:?} for {ray:?}; please report this")]
pub struct WrongHit {
    /// Pose that was traced.
    pub place: Place,
    /// Ray.
    pub ray: Ray,
    /// What was traced.
    pub traced: &'static str,
    /// Its hit.
    pub found: Option<Hit>,
    /// What it was compared with.
    pub reference: &'static str,
    /// The hit of that.
    pub expected: Option<Hit>,
}

/// A ray whose hit is not the same in two builders' trees.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{scene}: the tree of {builder} finds {found:?} and {reference} {expected:?} for {ray:?}; please report this")]
pub struct WrongTreeHit {
    /// Scene.
    pub scene: String,
    /// Builder of the tree that was traced.
    pub builder: String,
    /// Ray.
    pub ray: Ray,
    /// Its hit.
    pub found: Option<TreeHit>,
    /// What it was compared with.
    pub reference: &'static str,
    /// The hit of that.
    pub expected: Option<TreeHit>,
}
