#![expect(unsafe_code, reason = "passes the promise of `map` on to its caller")]

use crate::{
    OpenError,
    cache::CACHE_ROUNDINGS,
    cluster_frame::{BundleFrame, LatticeRay, SlabRay, vertex_error as vertex_error_of},
    envelope_hints::EnvelopeHints,
    map::StoredModel,
    mover_maps::MOST_STEPS,
    pose_space::PoseSpaces,
    posing::PosingLimits,
    prepared::TRIANGLES_PER_RAY,
    rest_boxes::RestBoxes,
    top_level::TopLevel,
    vertex::rounding_count,
    wide::LocalLattice,
};
use restpose_formats::{
    FormatError, ModelView, TreeKind, read, read_written,
    rows::{ClusterRow, NONE, RestLattice, WideChild, WideNodeRow, box_steps},
};
use std::{io, path::Path};

/// A baked file, checked once, then only read. Any number of instances and threads share it.
pub struct Asset {
    model: StoredModel,
    vertex_error: f64,
    cache_vertex_error: f64,
    /// Per cluster row: steps of the lattice of its triangles' boxes.
    box_steps: Vec<[f32; 3]>,
    /// Per cluster row.
    rest_lattices: Vec<RestLattice>,
    /// Per cluster row: [`Asset::rays_of_followers`].
    rays_of_followers: Vec<u32>,
    pose_spaces: PoseSpaces,
    /// Per reference row of kd-trees: whether it is the first of its triangle in its cluster.
    first_references: Vec<bool>,
    rest_boxes: RestBoxes,
    envelope_hints: EnvelopeHints,
    /// Over the clusters of an asset without vertex caches, in the rest pose.
    top_level: TopLevel,
    posing_limits: PosingLimits,
    /// Nodes of trees that a pose goes by, about, as wide ones.
    nodes_per_pose: usize,
}

/// Linear in the references.
fn first_references(model: &ModelView) -> Vec<bool> {
    let mut met_in = vec![NONE; model.triangles.len()];
    let mut out = Vec::with_capacity(model.references.len());
    for (row, cluster) in (0..).zip(model.clusters) {
        let references = &model.references[cluster.reference_first as usize..][..cluster.reference_count as usize];
        out.extend(
            references
                .iter()
                .map(|triangle| std::mem::replace(&mut met_in[*triangle as usize], row) != row),
        );
    }
    out
}

impl Asset {
    /// Reads a file into memory of this process. From 4 MiB on the system is asked for large pages (Linux), which makes rays
    /// through large files some 5 % faster than through a mapping.
    ///
    /// # Errors
    /// [`OpenError::Read`] or, for a damaged or foreign file, [`OpenError::Format`].
    pub fn open(path: &Path) -> Result<Self, OpenError> {
        Self::opened(path, StoredModel::open(path))
    }

    /// Maps a file: pages are read when they are first touched, and shared between processes. The checks that run now
    /// touch all of them once.
    ///
    /// # Safety
    /// Nobody may change or shorten the file while the asset lives. (Bakes replace a file by renaming a new one over
    /// it, which leaves the mapped one as it was.)
    ///
    /// # Errors
    /// As [`Asset::open`].
    pub unsafe fn map(path: &Path) -> Result<Self, OpenError> {
        // SAFETY: the caller's promise is the one that is asked for.
        Self::opened(path, unsafe { StoredModel::map(path, read) })
    }

    /// Maps a file that this library has written, at the speed of memory: its checksums are checked, and so any damage is
    /// found, its rows are not, since [`restpose_formats::write`] did that.
    ///
    /// 1 GiB takes about a tenth of the time of [`Asset::map`].
    ///
    /// # Safety
    /// As of [`Asset::map`]; and the file comes from where nobody would forge it: what [`restpose_formats::write`] has not
    /// written may panic, never end or lose hits.
    ///
    /// # Errors
    /// As [`Asset::open`], but for faults of rows.
    pub unsafe fn map_written(path: &Path) -> Result<Self, OpenError> {
        // SAFETY: the caller's promise is the one that is asked for.
        Self::opened(path, unsafe { StoredModel::map(path, read_written) })
    }

    /// Copies a file's bytes, which need no alignment, into such memory as [`Asset::open`] does.
    ///
    /// # Errors
    /// Whatever is wrong with them.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        StoredModel::copy(bytes).map(Self::new)
    }

    fn opened(path: &Path, stored: io::Result<Result<StoredModel, FormatError>>) -> Result<Self, OpenError> {
        match stored {
            Ok(Ok(model)) => Ok(Self::new(model)),
            Ok(Err(source)) => Err(OpenError::Format {
                path: path.into(),
                source,
            }),
            Err(source) => Err(OpenError::Read {
                path: path.into(),
                source,
            }),
        }
    }

    fn new(model: StoredModel) -> Self {
        let vertex_error = vertex_error_of(rounding_count(model.view()));
        let cache_vertex_error = vertex_error_of(CACHE_ROUNDINGS);
        let pose_spaces = PoseSpaces::new(model.view());
        let view = model.view();
        let first_references = match view.meta.tree {
            TreeKind::Kd => first_references(view),
            TreeKind::Wide => Vec::new(),
        };
        let clusters = view.clusters.iter();
        let box_steps = clusters.map(|cluster| box_steps(&cluster.bounds_local)).collect();
        let bones = |cluster: &ClusterRow| {
            &view.cluster_bones[cluster.cluster_bone_first as usize..][..cluster.cluster_bone_count as usize]
        };
        let clusters = view.clusters.iter();
        let rest_lattices = clusters.map(|cluster| RestLattice::new(bones(cluster))).collect();
        let rays_of_followers = view.clusters.iter().map(|cluster| {
            let nodes = view.wide_nodes.get(cluster.node_first as usize..).unwrap_or_default();
            let nodes = nodes.iter().take(cluster.node_count as usize);
            let leaves = |node: &WideNodeRow| {
                node.children()
                    .filter(|child| matches!(child, WideChild::Leaf(_)))
                    .count()
            };
            let following: usize = nodes.filter(|node| node.mover_count != 0).map(leaves).sum();
            // Where much does not follow, wider boxes cost a ray its triangles.
            let is_most = 8 * following as u64 >= 7 * u64::from(cluster.triangle_count);
            if is_most {
                cluster.triangle_count / TRIANGLES_PER_RAY
            } else {
                0
            }
        });
        let rays_of_followers = rays_of_followers.collect();
        let mut top_level = TopLevel::default();
        if view.caches.is_empty() {
            let bounds = |cluster: u32| view.clusters[cluster as usize].bounds_local;
            top_level.rebuild(0..view.clusters.len() as u32, bounds);
        }
        let rest_boxes = RestBoxes::new(view);
        let envelope_hints = EnvelopeHints::new(view);
        let posing_limits = PosingLimits::new(view.vertices.len(), view.triangles.len());
        // Of a part with time segments, one of them is in use. Of a kd-tree, seven nodes are as much as one with eight children.
        let in_segments: u64 = view
            .clusters
            .iter()
            .map(|cluster| u64::from(cluster.triangle_count))
            .sum();
        let nodes_per_pose = ((view.wide_nodes.len() + view.kd_nodes.len() / 7) as u64 * view.triangles.len() as u64)
            .div_ceil(in_segments.max(1)) as usize;
        Self {
            model,
            nodes_per_pose,
            vertex_error,
            cache_vertex_error,
            box_steps,
            rest_lattices,
            rays_of_followers,
            pose_spaces,
            first_references,
            rest_boxes,
            envelope_hints,
            top_level,
            posing_limits,
        }
    }

    /// Everything in the file.
    #[must_use]
    pub fn model(&self) -> &ModelView<'_> {
        self.model.view()
    }

    /// The first clip with this name, as a row of [`ModelView::clips`].
    #[must_use]
    pub fn clip(&self, name: &str) -> Option<usize> {
        self.model().meta.clip_names.iter().position(|clip| clip == name)
    }

    /// The first bone with this name, as a row of [`ModelView::bones`] and an entry of the palette. Joints are called as
    /// their nodes.
    #[must_use]
    pub fn bone(&self, name: &str) -> Option<usize> {
        self.model().meta.bone_names.iter().position(|bone| bone == name)
    }

    /// Bound of a posed vertex's rounding error, relative to `|X|·|p| + |t|`.
    pub(crate) fn vertex_error(&self) -> f64 {
        self.vertex_error
    }

    /// The same for a vertex of a cache.
    pub(crate) fn cache_vertex_error(&self) -> f64 {
        self.cache_vertex_error
    }

    /// Per reference row of a kd-tree: whether it is the first of its triangle in its cluster.
    pub(crate) fn first_references(&self) -> &[bool] {
        &self.first_references
    }

    /// The triangles of a cluster, each once.
    pub(crate) fn cluster_triangles(&self, cluster: &ClusterRow) -> impl Iterator<Item = u32> {
        let rows = cluster.reference_first as usize..(cluster.reference_first + cluster.reference_count) as usize;
        let first = self.first_references.get(rows.clone());
        let references = self.model().references[rows].iter().enumerate();
        references
            .filter(move |(at, _)| first.is_none_or(|first| first[*at]))
            .map(|(_, triangle)| *triangle)
    }

    /// The nodes of a cluster's wide tree.
    pub(crate) fn wide_nodes(&self, cluster: u32) -> &[WideNodeRow] {
        let model = self.model();
        let cluster = &model.clusters[cluster as usize];
        &model.wide_nodes[cluster.node_first as usize..][..cluster.node_count as usize]
    }

    /// What bones move in the rest pose.
    pub(crate) fn rest_boxes(&self) -> &RestBoxes {
        &self.rest_boxes
    }

    /// Where poses of clips are looked for first.
    pub(crate) fn envelope_hints(&self) -> &EnvelopeHints {
        &self.envelope_hints
    }

    /// The topology over its clusters, where it has no vertex caches.
    pub(crate) fn top_level(&self) -> &TopLevel {
        &self.top_level
    }

    /// Nodes of trees that a pose goes by, about, as wide ones.
    pub(crate) fn nodes_per_pose(&self) -> usize {
        self.nodes_per_pose
    }

    /// Rays that are worth posing more than they reach.
    pub(crate) fn posing_limits(&self) -> &PosingLimits {
        &self.posing_limits
    }

    /// The cache that moves a part's vertices, by the part's triangle row; `NONE` without one.
    pub(crate) fn cache_of_triangle(&self, triangle: u32) -> u32 {
        let parts = self.model().parts;
        let after = parts.partition_point(|part| part.triangle_first <= triangle);
        after.checked_sub(1).map_or(NONE, |part| parts[part].cache)
    }

    /// As [`Asset::cache_of_triangle`], by the part's vertex row.
    pub(crate) fn cache_of_vertex(&self, vertex: u32) -> u32 {
        let parts = self.model().parts;
        let after = parts.partition_point(|part| part.vertex_first <= vertex);
        after.checked_sub(1).map_or(NONE, |part| parts[part].cache)
    }

    /// What poses of its clusters are measured against.
    pub(crate) fn pose_spaces(&self) -> &PoseSpaces {
        &self.pose_spaces
    }

    /// The lattice of a cluster's boxes that follow the pose.
    pub(crate) fn rest_lattice(&self, cluster: u32) -> &RestLattice {
        &self.rest_lattices[cluster as usize]
    }

    /// Rays that may enter a cluster through wider boxes before it is refitted, because boxes of its nodes follow the pose.
    pub(crate) fn rays_of_followers(&self, cluster: u32) -> u32 {
        self.rays_of_followers[cluster as usize]
    }

    /// A ray that has [entered](crate::cluster_frame::LocalFrame::enter) a cluster, on the lattice of its fuzzy boxes, and on that of
    /// its rest positions.
    #[inline(always)]
    pub(crate) fn lattice_rays(&self, cluster: u32, (slab, margin_posed): &(SlabRay, [f32; 3])) -> [LatticeRay; 2] {
        let (bounds, rest) = (
            &self.model().clusters[cluster as usize].bounds_local,
            self.rest_lattice(cluster),
        );
        let follows = SlabRay {
            margin: *margin_posed,
            ..*slab
        };
        [
            LatticeRay::new(slab, bounds, self.box_steps(cluster)),
            LatticeRay::within(&follows, rest.origin, [rest.step; 3], MOST_STEPS),
        ]
    }

    /// The lattices of a cluster's fuzzy boxes, and of its rest positions, as a bundle takes them to local space.
    pub(crate) fn local_lattices(&self, cluster: u32, frame: &BundleFrame) -> [LocalLattice; 2] {
        let (bounds, rest) = (
            &self.model().clusters[cluster as usize].bounds_local,
            self.rest_lattice(cluster),
        );
        [
            LocalLattice::new(bounds.min, *self.box_steps(cluster), frame.margin),
            LocalLattice::new(rest.origin, [rest.step; 3], frame.margin_posed),
        ]
    }

    /// Steps of the lattice on which the boxes of a cluster's triangles are.
    pub(crate) fn box_steps(&self, cluster: u32) -> &[f32; 3] {
        &self.box_steps[cluster as usize]
    }
}

impl std::fmt::Debug for Asset {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let model = self.model();
        f.debug_struct("Asset")
            .field("source", &model.meta.source_name)
            .field("triangles", &model.triangles.len())
            .field("bones", &model.bones.len())
            .finish_non_exhaustive()
    }
}
