use crate::{
    Bounds, Model, ModelView, check,
    error::FormatError,
    header::{FEATURE_SAMPLED_BOUNDS, Header, MAGIC},
    meta_codec,
    section::{SectionEntry, SectionKind, align_up},
    version::FormatVersion,
};
use bytemuck::cast_slice;

/// The bytes of a file.
///
/// Guarantee: [`read`](crate::read) accepts them and gives the same model back; the same model always gives the same
/// bytes.
///
/// # Errors
/// What [`read`](crate::read) would say of the file: the first rule that the model breaks.
pub fn write(model: &Model) -> Result<Vec<u8>, FormatError> {
    let view = model.view();
    check::model(&view)?;
    let meta = meta_codec::encode(&view.meta)?;
    let sections = section_bytes(&view, &meta);

    let table_len = sections.len() * size_of::<SectionEntry>();
    let mut end = (Header::LEN + table_len) as u64;
    let mut table = Vec::with_capacity(sections.len());
    for (kind, bytes) in &sections {
        let byte_len = bytes.len() as u64;
        let entry = place(*kind, bytes, end);
        let entry = entry.ok_or(FormatError::SectionOutOfBounds {
            code: crate::SectionCode(kind.code()),
            offset: end,
            byte_len,
            file_len: u64::MAX,
        })?;
        end = entry.offset + byte_len;
        table.push(entry);
    }

    let mut header = Header {
        magic: MAGIC,
        major: FormatVersion::LATEST.numbers().0,
        minor: FormatVersion::LATEST.numbers().1,
        reserved_a: 0,
        header_len: Header::LEN as u32,
        crc32: 0,
        file_len: end,
        required_features: 0,
        optional_features: optional_features(view.meta.bounds),
        section_count: table.len() as u32,
        reserved_b: 0,
        source_hash: view.hashes.source,
        options_hash: view.hashes.options,
        reserved_c: 0,
    };
    header.crc32 = header.checksum(cast_slice(&table));

    let mut out = Vec::with_capacity(end as usize);
    out.extend_from_slice(bytemuck::bytes_of(&header));
    out.extend_from_slice(cast_slice(&table));
    for (entry, (_, bytes)) in table.iter().zip(&sections) {
        out.resize(entry.offset as usize, 0);
        out.extend_from_slice(bytes);
    }
    Ok(out)
}

/// The optional-feature bits of a file with these bounds.
pub(crate) fn optional_features(bounds: Bounds) -> u64 {
    match bounds {
        Bounds::Sampled => FEATURE_SAMPLED_BOUNDS,
        Bounds::Envelope => 0,
    }
}

/// The table's line for a section that follows byte `end`, unless it ends beyond 2⁶⁴.
fn place(kind: SectionKind, bytes: &[u8], end: u64) -> Option<SectionEntry> {
    let offset = align_up(end)?;
    let byte_len = bytes.len() as u64;
    offset.checked_add(byte_len)?;
    Some(SectionEntry {
        code: kind.code(),
        version: SectionKind::VERSION,
        flags: 0,
        row_size: kind.row_size(),
        crc32: crc32fast::hash(bytes),
        offset,
        byte_len,
        row_count: byte_len / u64::from(kind.row_size()),
    })
}

/// The sections in file order. A new field of the model that is not written here does not compile.
fn section_bytes<'a>(view: &ModelView<'a>, meta_bytes: &'a [u8]) -> [(SectionKind, &'a [u8]); 37] {
    let ModelView {
        hashes: _,
        meta: _,
        parts,
        primitives,
        vertices,
        influences,
        triangles,
        morph_sets,
        morph_targets,
        morph_first,
        morph_deltas,
        nodes,
        bones,
        clips,
        channels,
        key_times,
        key_values,
        samples,
        clip_bounds,
        caches,
        segments,
        tracks,
        keys,
        key_vertices,
        key_words,
        clusters,
        cluster_bones,
        kd_nodes,
        wide_nodes,
        node_movers,
        key_boxes,
        references,
        reference_boxes,
        pose_spaces,
        levers,
        cluster_morphs,
        bone_envelopes,
        morph_envelopes,
    } = *view;
    [
        (SectionKind::Meta, meta_bytes),
        (SectionKind::Parts, cast_slice(parts)),
        (SectionKind::Primitives, cast_slice(primitives)),
        (SectionKind::Vertices, cast_slice(vertices)),
        (SectionKind::Influences, cast_slice(influences)),
        (SectionKind::Triangles, cast_slice(triangles)),
        (SectionKind::MorphSets, cast_slice(morph_sets)),
        (SectionKind::MorphTargets, cast_slice(morph_targets)),
        (SectionKind::MorphFirst, cast_slice(morph_first)),
        (SectionKind::MorphDeltas, cast_slice(morph_deltas)),
        (SectionKind::Nodes, cast_slice(nodes)),
        (SectionKind::Bones, cast_slice(bones)),
        (SectionKind::Clips, cast_slice(clips)),
        (SectionKind::Channels, cast_slice(channels)),
        (SectionKind::KeyTimes, cast_slice(key_times)),
        (SectionKind::KeyValues, cast_slice(key_values)),
        (SectionKind::Samples, cast_slice(samples)),
        (SectionKind::ClipBounds, cast_slice(clip_bounds)),
        (SectionKind::Caches, cast_slice(caches)),
        (SectionKind::Segments, cast_slice(segments)),
        (SectionKind::Tracks, cast_slice(tracks)),
        (SectionKind::Keys, cast_slice(keys)),
        (SectionKind::KeyVertices, cast_slice(key_vertices)),
        (SectionKind::KeyWords, cast_slice(key_words)),
        (SectionKind::Clusters, cast_slice(clusters)),
        (SectionKind::ClusterBones, cast_slice(cluster_bones)),
        (SectionKind::KdNodes, cast_slice(kd_nodes)),
        (SectionKind::WideNodes, cast_slice(wide_nodes)),
        (SectionKind::NodeMovers, cast_slice(node_movers)),
        (SectionKind::KeyBoxes, cast_slice(key_boxes)),
        (SectionKind::References, cast_slice(references)),
        (SectionKind::ReferenceBoxes, cast_slice(reference_boxes)),
        (SectionKind::PoseSpaces, cast_slice(pose_spaces)),
        (SectionKind::Levers, cast_slice(levers)),
        (SectionKind::ClusterMorphs, cast_slice(cluster_morphs)),
        (SectionKind::BoneEnvelopes, cast_slice(bone_envelopes)),
        (SectionKind::MorphEnvelopes, cast_slice(morph_envelopes)),
    ]
}
