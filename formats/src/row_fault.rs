use crate::rows::MotionClass;

/// The rule that a row breaks. Indices and counts are in rows of the section that the field points into.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RowFault {
    /// An index points past the end of its section, or of the range that it belongs to.
    #[error("`{field}` is {found}, expected less than {limit}")]
    IndexOutOfRange {
        /// Field.
        field: &'static str,
        /// Index.
        found: u64,
        /// First index that is too large.
        limit: u64,
    },
    /// An index lies outside the range that it belongs to.
    #[error("`{field}` is {found}, expected {first} or more and less than {limit}")]
    IndexOutsideRange {
        /// Field.
        field: &'static str,
        /// Index.
        found: u64,
        /// First index that is allowed.
        first: u64,
        /// First index that is too large.
        limit: u64,
    },
    /// A value that must rise from row to row does not.
    #[error("`{field}` is {found}, expected above {previous}, that of the row before it")]
    NotAscending {
        /// Field.
        field: &'static str,
        /// Value.
        found: u32,
        /// Value in the row before.
        previous: u32,
    },
    /// A value that must not fall from row to row does.
    #[error("`{field}` is {found}, expected at least {previous}, that of the row before it")]
    Descending {
        /// Field.
        field: &'static str,
        /// Value.
        found: u32,
        /// Value in the row before.
        previous: u32,
    },
    /// A range reaches past the end of its section.
    #[error("`{field}` ranges over {count} rows from row {first}, expected to end by row {limit}")]
    RangeOutOfBounds {
        /// Field.
        field: &'static str,
        /// First row.
        first: u64,
        /// Rows.
        count: u64,
        /// Rows that there are.
        limit: u64,
    },
    /// A range does not begin where the one before it ends.
    #[error("`{field}` is {found}, expected {expected}, where the range before it ends")]
    RangeNotContiguous {
        /// Field.
        field: &'static str,
        /// First row, or bit.
        found: u64,
        /// First one that is allowed.
        expected: u64,
    },
    /// A range has the wrong number of rows.
    #[error("`{field}` is {found}, expected {expected}")]
    Count {
        /// Field.
        field: &'static str,
        /// Count.
        found: u64,
        /// Count that the other sections give.
        expected: u64,
    },
    /// A range must not be empty.
    #[error("`{field}` counts no rows, expected at least one")]
    EmptyRange {
        /// Field.
        field: &'static str,
    },
    /// A count is too small.
    #[error("`{field}` is {found}, expected at least {least}")]
    TooFew {
        /// Field.
        field: &'static str,
        /// Count.
        found: u32,
        /// Least count that is allowed.
        least: u32,
    },
    /// A reserved or unused place is in use.
    #[error("`{field}` is in use, expected zero")]
    ReservedNotZero {
        /// Field.
        field: &'static str,
    },
    /// NaN or infinity.
    #[error("`{field}` is {found}, expected a finite number")]
    NotFinite {
        /// Field.
        field: &'static str,
        /// Its value.
        found: f32,
    },
    /// A length below zero.
    #[error("`{field}` is {found}, expected zero or more")]
    Negative {
        /// Field.
        field: &'static str,
        /// Its value.
        found: f32,
    },
    /// A length that must not be zero.
    #[error("`{field}` is {found}, expected above zero")]
    NotAboveZero {
        /// Field.
        field: &'static str,
        /// Its value.
        found: f32,
    },
    /// A number that must not exceed one.
    #[error("`{field}` is {found}, expected at most one")]
    AboveOne {
        /// Field.
        field: &'static str,
        /// Its value.
        found: f32,
    },
    /// A number that must reach what a vertex of the cluster asks for.
    #[error("`{field}` is {found}, expected at least {least} for vertex {vertex} of the cluster")]
    TooSmall {
        /// Field.
        field: &'static str,
        /// Its value.
        found: f32,
        /// Least value for the vertex.
        least: f64,
        /// Vertex row.
        vertex: u32,
    },
    /// A number that stands for nothing.
    #[error("`{field}` is {found}, expected less than {limit}")]
    UnknownNumber {
        /// Field.
        field: &'static str,
        /// Number.
        found: u32,
        /// First number that stands for nothing.
        limit: u32,
    },
    /// A weight outside (0, 1] or not a multiple of the step.
    #[error("`weight` is {found}, expected above 0, at most 1, and a multiple of 2^-24")]
    Weight {
        /// Weight.
        found: f32,
    },
    /// The weights of a vertex do not sum to one.
    #[error("its weights sum to {found_steps} steps of 2^-24, expected 16777216")]
    WeightSum {
        /// Sum in units of 2⁻²⁴.
        found_steps: u64,
    },
    /// A bone moves a vertex twice.
    #[error("bone {bone} influences it more than once")]
    RepeatedInfluence {
        /// Bone row.
        bone: u32,
    },
    /// A parent does not stand before its child.
    #[error("`parent` is {found}, expected NONE or a row before this one")]
    ParentNotBefore {
        /// Parent.
        found: u32,
    },
    /// Bone 0 is not the root bone.
    #[error("it is bone 0, expected `node` NONE and the identity as `inverse_bind`")]
    NotRootBone,
    /// A bone other than 0 has no node.
    #[error("`node` is NONE, which only bone 0 may have")]
    SecondRootBone,
    /// A channel moves a node whose local map is a matrix.
    #[error("it moves node {node}, whose local map is a matrix")]
    MatrixNodeAnimated {
        /// Node row.
        node: u32,
    },
    /// Two channels of a clip move the same thing.
    #[error("an earlier channel of the clip has the same `target` and `path`")]
    RepeatedChannel,
    /// Key times do not increase.
    #[error("its key times do not increase strictly between keys {key} and {}", key + 1)]
    TimesNotIncreasing {
        /// The earlier of the two keys, from the channel's first.
        key: u64,
    },
    /// A clip's time is not that of its keys.
    #[error("`{field}` is {found}, expected {expected} as its key times say")]
    ClipTime {
        /// Field.
        field: &'static str,
        /// Time, seconds.
        found: f32,
        /// Time by the keys, seconds.
        expected: f32,
    },
    /// A vertex of a part without morph set has deltas.
    #[error("it belongs to vertex {vertex}, whose part has no morph set")]
    DeltaWithoutMorphSet {
        /// Vertex row.
        vertex: u64,
    },
    /// A value is larger than the extent that stands for it.
    #[error("`{field}` is {found} on axis {axis}, expected at most {extent} in size, the extent of row {extent_row}")]
    BeyondExtent {
        /// Field.
        field: &'static str,
        /// 0, 1 or 2.
        axis: usize,
        /// Value.
        found: f32,
        /// Extent.
        extent: f32,
        /// Row that holds the extent.
        extent_row: u64,
    },
    /// A value lies outside of the box that stands for it.
    #[error("`{field}` is {found} on axis {axis}, expected {min} to {max}, the box of row {box_row}")]
    OutsideBox {
        /// Field.
        field: &'static str,
        /// 0, 1 or 2.
        axis: usize,
        /// Value.
        found: f32,
        /// Lower end of the box.
        min: f32,
        /// Upper end of the box.
        max: f32,
        /// Row that holds the box.
        box_row: u64,
    },
    /// A box holds no point.
    #[error("`{field}` is empty on axis {axis}: it reaches from {min} to {max}")]
    EmptyBox {
        /// Field.
        field: &'static str,
        /// 0, 1 or 2.
        axis: usize,
        /// Lower end.
        min: f32,
        /// Upper end.
        max: f32,
    },
    /// A box that is not known to hold is not empty, or has magnitudes.
    #[error("`known` is 0, expected `bounds` empty, from inf to -inf on every axis, and `reach` and `rest_reach` 0")]
    UnknownBounds,
    /// An interval holds no weight.
    #[error("it is empty: it reaches from {min} to {max}")]
    EmptyInterval {
        /// Lower end.
        min: f32,
        /// Upper end.
        max: f32,
    },
    /// A bone moves vertices of a cluster and is not listed there.
    #[error("bone {bone} moves vertex {vertex} of the cluster, but is not among its cluster bones")]
    ClusterBoneMissing {
        /// Bone row.
        bone: u32,
        /// Vertex row.
        vertex: u32,
    },
    /// A bone is listed in a cluster and moves none of its vertices.
    #[error("bone {bone} moves no vertex of the cluster")]
    ClusterBoneUnused {
        /// Bone row.
        bone: u32,
    },
    /// A morph target displaces vertices of a cluster and is not listed there.
    #[error("morph target {target} displaces vertex {vertex} of the cluster, but is not among its cluster morphs")]
    ClusterMorphMissing {
        /// Morph target row.
        target: u32,
        /// Vertex row.
        vertex: u32,
    },
    /// A morph target is listed in a cluster and displaces none of its vertices.
    #[error("morph target {target} displaces no vertex of the cluster")]
    ClusterMorphUnused {
        /// Morph target row.
        target: u32,
    },
    /// A track has vertices of a cluster and is not listed there.
    #[error("track {track} has vertex {vertex} of the cluster, but is not among its cluster bones")]
    ClusterTrackMissing {
        /// Track row.
        track: u32,
        /// Vertex row.
        vertex: u32,
    },
    /// A track is listed in a cluster and has none of its vertices.
    #[error("track {track} has no vertex of the cluster")]
    ClusterTrackUnused {
        /// Track row.
        track: u32,
    },
    /// A part moves by a cache and has none.
    #[error("`cache` is NONE, expected a cache, for its class is {}", class.name())]
    CacheMissing {
        /// The part's class.
        class: MotionClass,
    },
    /// A part has a cache and does not move by one.
    #[error("`cache` is {found}, expected NONE, for its class is {}", class.name())]
    CacheNotAllowed {
        /// The part's class.
        class: MotionClass,
        /// Cache row.
        found: u32,
    },
    /// A part with a cache is moved by something else too.
    #[error("`{field}` is {found}, expected NONE, for the part has a cache")]
    NotNoneWithCache {
        /// Field.
        field: &'static str,
        /// Its value.
        found: u32,
    },
    /// Two rows that must name each other do not.
    #[error("`{field}` is {found}, a row whose `{back}` does not name this one")]
    NotPaired {
        /// Field.
        field: &'static str,
        /// Row that it names.
        found: u32,
        /// Field of that row.
        back: &'static str,
    },
    /// A vertex of a cache is not carried by the cache's bone alone.
    #[error("its part has a cache, expected a single influence, of bone {bone}")]
    CachedInfluence {
        /// The cache's bone.
        bone: u32,
    },
    /// A cluster of a cache hangs on another bone.
    #[error("`bone` is {found}, expected {expected}, that of its cache")]
    NotTheCachesBone {
        /// Bone row.
        found: u32,
        /// The cache's bone.
        expected: u32,
    },
    /// Without keys there is no lattice.
    #[error("it has no keys, expected `origin` zero and `step` one")]
    LatticeWithoutKeys,
    /// After the last key there is nothing to cut.
    #[error("`flags` cuts what follows the segment's last key, expected zero")]
    CutAfterLastKey,
    /// Two clusters have the same keys.
    #[error("track {track} has keys and also moves cluster {other}")]
    TrackShared {
        /// Track row.
        track: u32,
        /// Cluster row.
        other: u32,
    },
    /// A track with keys moves no cluster.
    #[error("it has keys and moves no cluster")]
    TrackUnused,
    /// Raw positions are in the cache's own space.
    #[error("`raw` is 1, but track {track} has keys")]
    RawOnTrackWithKeys {
        /// Track row.
        track: u32,
    },
    /// A lattice number has too many bits.
    #[error("`widths` is {found} on axis {axis}, expected at most {limit} bits")]
    TooWide {
        /// 0, 1 or 2.
        axis: usize,
        /// Bits.
        found: u8,
        /// Most bits.
        limit: u8,
    },
    /// A lattice coordinate may not be an `f32`.
    #[error("`base` and `widths` reach {found} on axis {axis}, expected at most {limit} in size")]
    BeyondLattice {
        /// 0, 1 or 2.
        axis: usize,
        /// Lattice coordinate.
        found: i64,
        /// Greatest magnitude.
        limit: i32,
    },
    /// A child does not stand behind its parent.
    #[error("its child is node {found}, expected above {own}, its own index")]
    ChildNotBehind {
        /// Child, the left one in a kd-tree, from the tree's first node.
        found: u32,
        /// The node, from the tree's first node.
        own: u32,
    },
    /// A node is the child of two nodes.
    #[error("its child {child} has another parent")]
    TwoParents {
        /// Child, from the tree's first node.
        child: u32,
    },
    /// A node other than the root is nobody's child.
    #[error("no node has it as a child")]
    NoParent,
    /// A path is too long for traversal stacks.
    #[error("{found} inner nodes lie on the path to it and with it, expected at most {limit}")]
    TooDeep {
        /// Inner nodes.
        found: usize,
        /// Inner nodes that are allowed.
        limit: usize,
    },
    /// A wide node without children.
    #[error("all of its places are empty, expected a child")]
    NoChildren,
    /// A child stands behind an empty place.
    #[error("place {place} is in use and stands behind an empty one, expected all empty places last")]
    PlaceBehindEmpty {
        /// Place, 0 to 7.
        place: usize,
    },
    /// An empty place has a box.
    #[error("place {place} is empty and has a box, expected 65535 as each of its coordinates")]
    BoxOfEmptyPlace {
        /// Place, 0 to 7.
        place: usize,
    },
    /// A bone moves an empty place.
    #[error("place {place} of its node is empty and has a weight, expected zero as `weight` and `spread`")]
    WeightOfEmptyPlace {
        /// Place, 0 to 7.
        place: usize,
    },
    /// A box at a key has its corners exchanged, or stands in an empty place.
    #[error("at place {place} `min` is {min} and `max` {max} on axis {axis}, expected {expected}")]
    KeyBox {
        /// Place, 0 to 7.
        place: usize,
        /// 0 for x.
        axis: usize,
        /// Its least coordinate.
        min: u8,
        /// Its greatest coordinate.
        max: u8,
        /// What would be right.
        expected: &'static str,
    },
    /// A child's box lies outside of the box that its parent gives for it.
    #[error(
        "the box of place {place} reaches from {min} to {max} on axis {axis}, expected {least} or more and {greatest} or \
         less, as the node's parent says"
    )]
    OutsideParentsBox {
        /// Place, 0 to 7.
        place: usize,
        /// 0, 1 or 2.
        axis: usize,
        /// Lower end.
        min: u16,
        /// Upper end.
        max: u16,
        /// Lower end of the node's own box.
        least: u16,
        /// Upper end of the node's own box.
        greatest: u16,
    },
    /// A leaf is not of the triangle that the references say.
    #[error("place {place} is a leaf of triangle {found}, expected {expected}, the next of the cluster's references")]
    LeafNotReferenced {
        /// Place, 0 to 7.
        place: usize,
        /// Triangle row.
        found: u32,
        /// Triangle row that the references name.
        expected: u32,
    },
    /// A tree has more leaves than its cluster has references.
    #[error("place {place} is a leaf, but all of the cluster's references are named before")]
    LeafWithoutReference {
        /// Place, 0 to 7.
        place: usize,
    },
    /// A reference belongs to two leaves.
    #[error("another leaf holds reference {reference} too")]
    ReferenceShared {
        /// Reference, from the tree's first.
        reference: u32,
    },
    /// A reference belongs to no leaf.
    #[error("no leaf holds it")]
    ReferenceUnused,
    /// A triangle belongs to two clusters.
    #[error("triangle {triangle} also belongs to cluster {other}")]
    TriangleInTwoClusters {
        /// Triangle row.
        triangle: u32,
        /// Cluster row.
        other: u32,
    },
    /// A triangle belongs to no cluster.
    #[error("it belongs to no cluster, and its corners are not all equal")]
    TriangleInNoCluster,
    /// A triangle of a cache belongs to no cluster of a segment.
    #[error("it belongs to no cluster of segment {segment}, and its corners are not all equal")]
    TriangleNotInSegment {
        /// Segment row.
        segment: u32,
    },
    /// A triangle of a cache belongs to a cluster outside of its segments.
    #[error("triangle {triangle} belongs to a part with a cache, but the cluster has no track")]
    TriangleNeedsTrack {
        /// Triangle row.
        triangle: u32,
    },
    /// A degenerate triangle is in a tree.
    #[error("triangle {triangle} has three equal corners and must not be in a tree")]
    DegenerateReferenced {
        /// Triangle row.
        triangle: u32,
    },
}
