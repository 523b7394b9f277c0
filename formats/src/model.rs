use crate::{
    Meta,
    rows::{
        BoneEnvelopeRow, BoneRow, CacheRow, ChannelRow, ClipBoundsRow, ClipRow, ClusterBoneRow, ClusterMorphRow,
        ClusterRow, InfluenceRow, KdNodeRow, KeyBoxRow, KeyRow, KeyVertexRow, LeverRow, MorphDeltaRow,
        MorphEnvelopeRow, MorphSetRow, MorphTargetRow, NodeMoverRow, NodeRow, PartRow, PoseSpaceRow, PrimitiveRow,
        ReferenceBoxRow, SampleRow, SegmentRow, TrackRow, TriangleRow, VertexRow, WideNodeRow,
    },
};

/// What a file was made from, to tell whether it is stale.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Hashes {
    /// BLAKE3 of the source file and every buffer it refers to.
    pub source: [u8; 32],
    /// BLAKE3 of the bake options that change the file.
    pub options: [u8; 32],
}

/// The per-vertex lists, for [`Model`] and [`ModelView`] alike.
macro_rules! vertex_lists {
    () => {
        /// Influences of one vertex, which is a vertex row other than the closing one.
        ///
        /// # Panics
        /// When there is no such vertex, or the rows were never checked and their ranges are wrong.
        #[inline]
        #[must_use]
        pub fn influences_of(&self, vertex: usize) -> &[InfluenceRow] {
            let [begin, end] = [vertex, vertex + 1].map(|row| self.vertices[row].influence_first as usize);
            &self.influences[begin..end]
        }

        /// Morph deltas of one vertex, which is a vertex row other than the closing one.
        ///
        /// # Panics
        /// As [`Self::influences_of`].
        #[inline]
        #[must_use]
        pub fn morph_deltas_of(&self, vertex: usize) -> &[MorphDeltaRow] {
            if self.morph_first.is_empty() {
                return &[];
            }
            &self.morph_deltas[self.morph_first[vertex] as usize..self.morph_first[vertex + 1] as usize]
        }
    };
}

/// Declares the bulk sections once: as owned vectors in [`Model`], as borrowed slices in [`ModelView`].
macro_rules! sections {
    ($($(#[doc = $doc:literal])+ $field:ident: $row:ty,)+) => {
        /// The contents of a file, owned and editable.
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct Model {
            /// What it was made from.
            pub hashes: Hashes,
            /// Names, options, statistics.
            pub meta: Meta,
            $($(#[doc = $doc])+ pub $field: Vec<$row>,)+
        }

        /// The contents of a file, borrowed: what [`read`](crate::read) has checked.
        #[derive(Clone, Debug, PartialEq)]
        pub struct ModelView<'a> {
            /// What it was made from.
            pub hashes: Hashes,
            /// Names, options, statistics.
            pub meta: Meta,
            $($(#[doc = $doc])+ pub $field: &'a [$row],)+
        }

        impl Model {
            vertex_lists!();

            /// Borrows everything. The metadata is copied.
            #[must_use]
            pub fn view(&self) -> ModelView<'_> {
                ModelView { hashes: self.hashes, meta: self.meta.clone(), $($field: &self.$field,)+ }
            }
        }

        impl ModelView<'_> {
            vertex_lists!();

            /// Copies everything into a model that can be edited.
            #[must_use]
            pub fn to_model(&self) -> Model {
                Model { hashes: self.hashes, meta: self.meta.clone(), $($field: self.$field.to_vec(),)+ }
            }
        }
    };
}

sections! {
    /// Parts, in source order.
    parts: PartRow,
    /// Primitives, in source order.
    primitives: PrimitiveRow,
    /// Vertices and a closing row.
    vertices: VertexRow,
    /// Influences of all vertices.
    influences: InfluenceRow,
    /// Triangles; a row's index is the triangle's id.
    triangles: TriangleRow,
    /// Morph sets.
    morph_sets: MorphSetRow,
    /// Morph targets of all sets.
    morph_targets: MorphTargetRow,
    /// First delta of each vertex and a closing entry; empty when there are no deltas.
    morph_first: u32,
    /// Morph deltas of all vertices.
    morph_deltas: MorphDeltaRow,
    /// Nodes, parents first.
    nodes: NodeRow,
    /// Bones; the palette has one entry per row.
    bones: BoneRow,
    /// Clips.
    clips: ClipRow,
    /// Channels of all clips.
    channels: ChannelRow,
    /// Key times of all channels, seconds.
    key_times: f32,
    /// Key values of all channels.
    key_values: f32,
    /// Poses from which the fuzzy boxes were made.
    samples: SampleRow,
    /// Bounds of each stretch of each clip and, last, of the pose without any clip; empty where none are known.
    clip_bounds: ClipBoundsRow,
    /// Vertex caches, one per part that has one.
    caches: CacheRow,
    /// Time segments of all caches.
    segments: SegmentRow,
    /// Tracks of all segments.
    tracks: TrackRow,
    /// Key frames of all tracks.
    keys: KeyRow,
    /// Vertices of all segments.
    key_vertices: KeyVertexRow,
    /// Positions of all key vertices, then closing words; empty without caches.
    key_words: u32,
    /// Clusters: those without a track, then those of each segment.
    clusters: ClusterRow,
    /// Bones that move each cluster's vertices.
    cluster_bones: ClusterBoneRow,
    /// Nodes of all fuzzy trees, where these are kd-trees.
    kd_nodes: KdNodeRow,
    /// Nodes of all fuzzy trees, where these are wide.
    wide_nodes: WideNodeRow,
    /// Bones that the boxes of wide nodes follow, those of a node together.
    node_movers: NodeMoverRow,
    /// Boxes of wide nodes at keys, those of a node together.
    key_boxes: KeyBoxRow,
    /// Triangle ids in the leaves of all fuzzy trees, and those in free motion.
    references: u32,
    /// Fuzzy box of each reference's triangle; empty in wide trees, whose nodes have it.
    reference_boxes: ReferenceBoxRow,
    /// Pose space of each cluster without a track; empty, like the four that follow, where the boxes are sampled.
    pose_spaces: PoseSpaceRow,
    /// Lever of each cluster bone of a cluster without a track.
    levers: LeverRow,
    /// Morph targets that displace each cluster's vertices.
    cluster_morphs: ClusterMorphRow,
    /// Relative motion of bones in the envelopes of each cluster.
    bone_envelopes: BoneEnvelopeRow,
    /// Morph weights in the envelopes of each cluster.
    morph_envelopes: MorphEnvelopeRow,
}
