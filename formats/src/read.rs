use crate::{
    Hashes, ModelView, check,
    error::FormatError,
    header::{FEATURE_SAMPLED_BOUNDS, Header, read_header},
    meta_codec,
    section::{SECTION_ALIGN, SectionKind},
    section_table::Sections,
    write::optional_features,
};
use bytemuck::Pod;

/// Checks a whole file and borrows its contents; nothing is copied but the metadata.
///
/// `bytes` is the file, no more and no less, and begins on a 64-byte boundary: mapped memory does,
/// [`AlignedBytes`](crate::AlignedBytes) does.
///
/// Guarantee: every index, count and range in the view is valid and every number that must be finite is, as
/// `FORMAT.md` lists them; whoever uses the view may rely on it. [`write`](crate::write) gives the same bytes back,
/// except for optional sections and feature bits that this library does not know.
///
/// Complexity: linear in the file, plus the influences and morph deltas of each vertex, and its row in a segment, once
/// per cluster that uses it.
///
/// # Errors
/// The first fault, in the order of [`FormatError`]. Bytes that are wrong in any way are refused, not repaired.
pub fn read(bytes: &[u8]) -> Result<ModelView<'_>, FormatError> {
    let view = read_written(bytes)?;
    check::model(&view)?;
    Ok(view)
}

/// As [`read`], without a look at the rows: for files that [`write`](crate::write) is known to have written, which has checked
/// them.
///
/// Header, sizes and checksums are checked, so a file that was cut, damaged or mixed up on the way is refused; one that was made
/// to deceive is not. What [`read`] guarantees of rows holds only if they are as they were written.
///
/// Complexity: one pass over the file, for the checksums.
///
/// # Errors
/// As [`read`], but for those of rows.
pub fn read_written(bytes: &[u8]) -> Result<ModelView<'_>, FormatError> {
    let (header, table) = read_header(bytes)?;
    let remainder = bytes.as_ptr().addr() % SECTION_ALIGN;
    if remainder != 0 {
        return Err(FormatError::Misaligned { remainder });
    }
    let sections = Sections::open(bytes, table)?;
    let view = borrow(&header, &sections)?;
    check_features(&header, &view)?;
    check::clip_bounds::check_count(&view)?;
    Ok(view)
}

fn borrow<'a>(header: &Header, sections: &Sections<'a>) -> Result<ModelView<'a>, FormatError> {
    Ok(ModelView {
        hashes: Hashes {
            source: header.source_hash,
            options: header.options_hash,
        },
        meta: meta_codec::decode(sections.bytes(SectionKind::Meta)?)?,
        parts: rows(sections, SectionKind::Parts)?,
        primitives: rows(sections, SectionKind::Primitives)?,
        vertices: rows(sections, SectionKind::Vertices)?,
        influences: rows(sections, SectionKind::Influences)?,
        triangles: rows(sections, SectionKind::Triangles)?,
        morph_sets: rows(sections, SectionKind::MorphSets)?,
        morph_targets: rows(sections, SectionKind::MorphTargets)?,
        morph_first: rows(sections, SectionKind::MorphFirst)?,
        morph_deltas: rows(sections, SectionKind::MorphDeltas)?,
        nodes: rows(sections, SectionKind::Nodes)?,
        bones: rows(sections, SectionKind::Bones)?,
        clips: rows(sections, SectionKind::Clips)?,
        channels: rows(sections, SectionKind::Channels)?,
        key_times: rows(sections, SectionKind::KeyTimes)?,
        key_values: rows(sections, SectionKind::KeyValues)?,
        samples: rows(sections, SectionKind::Samples)?,
        clip_bounds: rows(sections, SectionKind::ClipBounds)?,
        caches: rows(sections, SectionKind::Caches)?,
        segments: rows(sections, SectionKind::Segments)?,
        tracks: rows(sections, SectionKind::Tracks)?,
        keys: rows(sections, SectionKind::Keys)?,
        key_vertices: rows(sections, SectionKind::KeyVertices)?,
        key_words: rows(sections, SectionKind::KeyWords)?,
        clusters: rows(sections, SectionKind::Clusters)?,
        cluster_bones: rows(sections, SectionKind::ClusterBones)?,
        kd_nodes: rows(sections, SectionKind::KdNodes)?,
        wide_nodes: rows(sections, SectionKind::WideNodes)?,
        node_movers: rows(sections, SectionKind::NodeMovers)?,
        key_boxes: rows(sections, SectionKind::KeyBoxes)?,
        references: rows(sections, SectionKind::References)?,
        reference_boxes: rows(sections, SectionKind::ReferenceBoxes)?,
        pose_spaces: rows(sections, SectionKind::PoseSpaces)?,
        levers: rows(sections, SectionKind::Levers)?,
        cluster_morphs: rows(sections, SectionKind::ClusterMorphs)?,
        bone_envelopes: rows(sections, SectionKind::BoneEnvelopes)?,
        morph_envelopes: rows(sections, SectionKind::MorphEnvelopes)?,
    })
}

fn rows<'a, R: Pod>(sections: &Sections<'a>, kind: SectionKind) -> Result<&'a [R], FormatError> {
    let bytes = sections.bytes(kind)?;
    // Length and alignment have been checked, so a cast that fails would be a row type that the table of sections
    // does not name.
    bytemuck::try_cast_slice(bytes).map_err(|_| FormatError::RowSize {
        section: kind,
        expected: size_of::<R>() as u32,
        found: kind.row_size(),
    })
}

fn check_features(header: &Header, view: &ModelView<'_>) -> Result<(), FormatError> {
    let bit = FEATURE_SAMPLED_BOUNDS;
    let expected = optional_features(view.meta.bounds) & bit != 0;
    let found = header.optional_features & bit != 0;
    if expected == found {
        Ok(())
    } else {
        Err(FormatError::FeatureMismatch { bit, expected, found })
    }
}
