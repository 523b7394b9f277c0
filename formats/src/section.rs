use crate::rows::{
    BoneEnvelopeRow, BoneRow, CacheRow, ChannelRow, ClipBoundsRow, ClipRow, ClusterBoneRow, ClusterMorphRow,
    ClusterRow, InfluenceRow, KdNodeRow, KeyBoxRow, KeyRow, KeyVertexRow, LeverRow, MorphDeltaRow, MorphEnvelopeRow,
    MorphSetRow, MorphTargetRow, NodeMoverRow, NodeRow, PartRow, PoseSpaceRow, PrimitiveRow, ReferenceBoxRow,
    SampleRow, SegmentRow, TrackRow, TriangleRow, VertexRow, WideNodeRow,
};
use bytemuck::{Pod, Zeroable};
use std::fmt;

/// Sections begin on multiples of this many bytes, and so must a buffer that is read in place.
pub const SECTION_ALIGN: usize = 64;

/// Declares the sections once, in file order: name, four-character code, type of its rows.
macro_rules! section_kinds {
    ($($kind:ident $code:literal $row:ty: $doc:literal,)+) => {
        /// The sections of a file, in the order in which they stand.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum SectionKind {
            $(#[doc = $doc] $kind,)+
        }

        impl SectionKind {
            /// All sections, in file order.
            pub const ALL: &'static [Self] = &[$(Self::$kind,)+];

            /// The four characters that name the section in the section table.
            #[must_use]
            pub fn code(self) -> [u8; 4] {
                match self {
                    $(Self::$kind => *$code,)+
                }
            }

            /// Bytes of one row; one for the metadata, whose rows are bytes.
            #[must_use]
            pub fn row_size(self) -> u32 {
                match self {
                    $(Self::$kind => size_of::<$row>() as u32,)+
                }
            }
        }
    };
}

section_kinds! {
    Meta b"META" u8: "Names, options and statistics.",
    Parts b"PART" PartRow: "Parts.",
    Primitives b"PRIM" PrimitiveRow: "Primitives.",
    Vertices b"VERT" VertexRow: "Vertices and a closing row.",
    Influences b"INFL" InfluenceRow: "Influences.",
    Triangles b"TRIS" TriangleRow: "Triangles.",
    MorphSets b"MSET" MorphSetRow: "Morph sets.",
    MorphTargets b"MTGT" MorphTargetRow: "Morph targets.",
    MorphFirst b"MFST" u32: "First morph delta of each vertex.",
    MorphDeltas b"MDEL" MorphDeltaRow: "Morph deltas.",
    Nodes b"NODE" NodeRow: "Nodes.",
    Bones b"BONE" BoneRow: "Bones.",
    Clips b"CLIP" ClipRow: "Clips.",
    Channels b"CHAN" ChannelRow: "Channels.",
    KeyTimes b"KTIM" f32: "Key times.",
    KeyValues b"KVAL" f32: "Key values.",
    Samples b"SAMP" SampleRow: "Sampled poses.",
    ClipBounds b"CBND" ClipBoundsRow: "Bounds of the stretches of clips.",
    Caches b"CACH" CacheRow: "Vertex caches.",
    Segments b"SEGM" SegmentRow: "Time segments of the caches.",
    Tracks b"TRAK" TrackRow: "Tracks.",
    Keys b"KEYF" KeyRow: "Tracks in key frames.",
    KeyVertices b"KVRT" KeyVertexRow: "Vertices of the caches, per segment.",
    KeyWords b"KWRD" u32: "Positions of the caches' vertices.",
    Clusters b"CLUS" ClusterRow: "Clusters.",
    ClusterBones b"CBON" ClusterBoneRow: "Cluster bones.",
    KdNodes b"KDND" KdNodeRow: "Nodes of the fuzzy kd-trees.",
    WideNodes b"WDND" WideNodeRow: "Nodes of the wide fuzzy trees.",
    NodeMovers b"NMOV" NodeMoverRow: "Bones that the boxes of wide nodes follow.",
    KeyBoxes b"KBOX" KeyBoxRow: "Boxes of wide nodes at key frames.",
    References b"REFS" u32: "Triangle ids in the leaves.",
    ReferenceBoxes b"RBOX" ReferenceBoxRow: "Fuzzy boxes of the triangles in the leaves.",
    PoseSpaces b"PSPC" PoseSpaceRow: "Pose spaces of the clusters.",
    Levers b"LEVR" LeverRow: "Levers of the bones that move a cluster's vertices.",
    ClusterMorphs b"CMOR" ClusterMorphRow: "Morph targets that displace a cluster's vertices.",
    BoneEnvelopes b"BENV" BoneEnvelopeRow: "Relative motion of bones in the envelopes.",
    MorphEnvelopes b"MENV" MorphEnvelopeRow: "Morph weights in the envelopes.",
}

impl SectionKind {
    /// The row layout that this library writes and reads.
    pub const VERSION: u16 = 1;

    /// The section with these four characters.
    #[must_use]
    pub fn from_code(code: [u8; 4]) -> Option<Self> {
        Self::ALL.iter().copied().find(|kind| kind.code() == code)
    }
}

impl fmt::Display for SectionKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        SectionCode(self.code()).fmt(f)
    }
}

/// The four characters that name a section, known or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SectionCode(pub [u8; 4]);

impl fmt::Display for SectionCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0.escape_ascii())
    }
}

/// A line of the section table.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct SectionEntry {
    /// [`SectionKind::code`].
    pub code: [u8; 4],
    /// Version of the row layout.
    pub version: u16,
    /// [`SectionEntry::OPTIONAL`] or zero.
    pub flags: u16,
    /// Bytes of one row.
    pub row_size: u32,
    /// CRC-32 of the section's bytes.
    pub crc32: u32,
    /// First byte, from the start of the file; a multiple of [`SECTION_ALIGN`].
    pub offset: u64,
    /// Bytes; `row_size · row_count`.
    pub byte_len: u64,
    /// Rows.
    pub row_count: u64,
}

impl SectionEntry {
    /// Flag: a reader that does not know the section may skip it.
    pub const OPTIONAL: u16 = 1;
}

/// The least multiple of [`SECTION_ALIGN`] that is not below `offset`, if it fits.
pub(crate) fn align_up(offset: u64) -> Option<u64> {
    offset.checked_next_multiple_of(SECTION_ALIGN as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_distinct_and_found_again() {
        for kind in SectionKind::ALL {
            assert_eq!(SectionKind::from_code(kind.code()), Some(*kind));
        }
        assert_eq!(SectionKind::from_code(*b"NOPE"), None);
    }

    #[test]
    fn an_entry_has_no_padding_and_forty_bytes() {
        assert_eq!(size_of::<SectionEntry>(), 40);
    }
}
