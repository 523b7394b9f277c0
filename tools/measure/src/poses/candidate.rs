use super::report::FileFigures;
use crate::MeasureError;
use restpose_bake::{BakeReport, BakeSettings, Baked, NoProgress, PoseSpace, StageSeconds, bake, import::Animation};
use restpose_formats::{
    Bounds, Model, ModelView, TreeKind,
    rows::{KdNode, NONE},
    write,
};
use restpose_runtime::Asset;
use std::{sync::Arc, time::Instant};

/// A file to measure beside others of the same scene.
pub(super) struct Candidate {
    pub asset: Arc<Asset>,
    pub file: FileFigures,
    pub seconds: StageSeconds,
    /// Pairs of a cluster and a bone beside its own that moves its vertices.
    pub bone_pairs: u64,
}

impl Candidate {
    /// Bakes it on all threads.
    pub fn new(animation: &Animation, subdivisions: u32, settings: &BakeSettings) -> Result<Self, MeasureError> {
        Self::with_changes(animation, subdivisions, settings, |_| {})
    }

    /// Bakes it, and changes the contents of the file.
    pub fn with_changes(
        animation: &Animation,
        subdivisions: u32,
        settings: &BakeSettings,
        change: impl FnOnce(&mut Model),
    ) -> Result<Self, MeasureError> {
        let start = Instant::now();
        let Baked { mut model, report } = bake(animation, settings, &NoProgress)?;
        let bake_seconds = start.elapsed().as_secs_f64();
        change(&mut model);
        let bytes = write(&model)?;
        let asset = Arc::new(Asset::from_bytes(&bytes)?);
        let BakeReport {
            triangles,
            samples,
            fuzzy_box_area,
            seconds,
            ..
        } = report;
        let (bounds, envelopes) = match settings.bounds {
            Bounds::Sampled => ("sampled", None),
            Bounds::Envelope => ("envelope", Some(settings.envelopes)),
        };
        let pose_space = match settings.pose_space {
            PoseSpace::Arbitrary => "arbitrary",
            PoseSpace::Limits(_) => "limits",
            PoseSpace::Clips => "clips",
            PoseSpace::Clip(_) => "one clip",
        };
        Ok(Self {
            file: FileFigures {
                scene: animation.source_name.clone(),
                subdivisions,
                triangles,
                pose_space,
                samples,
                bounds,
                envelopes,
                fuzzy_box_area,
                area_ratio: 1.0,
                triangles_per_leaf: triangles_per_leaf(asset.model()),
                bytes: bytes.len() as u64,
                bake_seconds,
            },
            bone_pairs: bone_pairs(asset.model()),
            asset,
            seconds,
        })
    }

    /// Whether no pose may miss a hit.
    pub fn is_guaranteed(&self) -> bool {
        self.file.envelopes.is_some()
    }
}

/// Relates the areas of all to the first's.
pub(super) fn relate_areas(candidates: &mut [Candidate]) {
    let Some(first) = candidates.first().map(|candidate| candidate.file.fuzzy_box_area) else {
        return;
    };
    for candidate in candidates {
        candidate.file.area_ratio = candidate.file.fuzzy_box_area / first;
    }
}

fn triangles_per_leaf(model: &ModelView) -> f64 {
    if model.meta.tree == TreeKind::Wide {
        return 1.0;
    }
    let counts = model.kd_nodes.iter().filter_map(|node| match node.unpack() {
        KdNode::Leaf { count, .. } if count > 0 => Some(u64::from(count)),
        _ => None,
    });
    let (leaves, references) = counts.fold((0u64, 0), |(leaves, sum), count| (leaves + 1, sum + count));
    references as f64 / leaves as f64
}

fn bone_pairs(model: &ModelView) -> u64 {
    let own = model.clusters.iter().filter(|cluster| cluster.track == NONE);
    own.flat_map(|cluster| {
        let movers = &model.cluster_bones[cluster.cluster_bone_first as usize..][..cluster.cluster_bone_count as usize];
        movers.iter().filter(|mover| mover.bone != cluster.bone)
    })
    .count() as u64
}
