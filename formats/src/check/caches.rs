use super::{
    numbers::{extent, index, reserved},
    row,
    tiling::Tiling,
};
use crate::{
    FormatError, ModelView, RowFault, SectionKind,
    rows::{CacheRow, MotionClass, NONE, PartRow},
};
use std::ops::Range;

/// Parts and caches name each other one to one, as the parts' classes ask; a cache's vertices hang on its bone; segments
/// tile their section and cover their cache's keys. Skeleton, parts and vertices have been checked.
pub(super) fn check(view: &ModelView<'_>) -> Result<(), FormatError> {
    for (at, part) in view.parts.iter().enumerate() {
        check_part(view, at, part)?;
    }
    let section = SectionKind::Caches;
    let mut segments = Tiling::new(SectionKind::Segments, view.segments.len());
    for (at, cache) in view.caches.iter().enumerate() {
        let part = check_fields(view, at, cache)?;
        let range = segments.take(section, at, "segment_first", cache.segment_first, cache.segment_count)?;
        check_keys(view, at, cache, range)?;
        check_influences(view, part, cache.bone)?;
    }
    segments.finish()
}

fn check_part(view: &ModelView<'_>, at: usize, part: &PartRow) -> Result<(), FormatError> {
    let fail = |fault| Err(row(SectionKind::Parts, at, fault));
    let found = part.cache;
    match (MotionClass::from_number(part.class), found) {
        (Some(class @ (MotionClass::Keyframed | MotionClass::Free)), NONE) => {
            return fail(RowFault::CacheMissing { class });
        }
        (_, NONE) => return Ok(()),
        (Some(class @ (MotionClass::Static | MotionClass::Skinned)), _) => {
            return fail(RowFault::CacheNotAllowed { class, found });
        }
        _ => {}
    }
    let cache = index(SectionKind::Parts, at, "cache", found, view.caches.len())?;
    if view.caches[cache].part as usize != at {
        let (field, back) = ("cache", "part");
        return fail(RowFault::NotPaired { field, found, back });
    }
    for (field, found) in [("source_skin", part.source_skin), ("morph_set", part.morph_set)] {
        if found != NONE {
            return fail(RowFault::NotNoneWithCache { field, found });
        }
    }
    Ok(())
}

/// Checks everything but ranges and returns the part.
fn check_fields<'a>(view: &ModelView<'a>, at: usize, cache: &CacheRow) -> Result<&'a PartRow, FormatError> {
    let section = SectionKind::Caches;
    reserved(section, at, "reserved", &cache.reserved)?;
    let part = index(section, at, "part", cache.part, view.parts.len())?;
    let part = &view.parts[part];
    if part.cache as usize != at {
        let (field, found, back) = ("part", cache.part, "cache");
        return Err(row(section, at, RowFault::NotPaired { field, found, back }));
    }
    index(section, at, "bone", cache.bone, view.bones.len())?;
    extent(section, at, "position_error", &[cache.position_error])?;
    for (field, count) in [("key_count", cache.key_count), ("segment_count", cache.segment_count)] {
        if count == 0 {
            return Err(row(section, at, RowFault::EmptyRange { field }));
        }
    }
    Ok(part)
}

/// Each segment begins with the key with which the one before it ends, from the first key to the last.
fn check_keys(view: &ModelView<'_>, at: usize, cache: &CacheRow, segments: Range<usize>) -> Result<(), FormatError> {
    let section = SectionKind::Segments;
    let (field, limit) = ("key_first", u64::from(cache.key_count));
    let least = cache.key_count.min(2);
    if cache.key_count == 1 && cache.segment_count != 1 {
        let (field, found, expected) = ("segment_count", u64::from(cache.segment_count), 1);
        return Err(row(SectionKind::Caches, at, RowFault::Count { field, found, expected }));
    }
    let mut last = 0;
    for at in segments {
        let segment = &view.segments[at];
        let (first, count) = (u64::from(segment.key_first), u64::from(segment.key_count));
        if first != last {
            let (found, expected) = (first, last);
            return Err(row(
                section,
                at,
                RowFault::RangeNotContiguous { field, found, expected },
            ));
        }
        if segment.key_count < least {
            let (field, found) = ("key_count", segment.key_count);
            return Err(row(section, at, RowFault::TooFew { field, found, least }));
        }
        if first + count > limit {
            let fault = RowFault::RangeOutOfBounds {
                field,
                first,
                count,
                limit,
            };
            return Err(row(section, at, fault));
        }
        last = first + count - 1;
    }
    if last + 1 == limit {
        return Ok(());
    }
    let (field, found, expected) = ("key_count", limit, last + 1);
    Err(row(SectionKind::Caches, at, RowFault::Count { field, found, expected }))
}

/// Every vertex of the part has a single influence, that of the cache's bone.
fn check_influences(view: &ModelView<'_>, part: &PartRow, bone: u32) -> Result<(), FormatError> {
    let first = part.vertex_first as usize;
    for vertex in first..first + part.vertex_count as usize {
        match view.influences_of(vertex) {
            [only] if only.bone == bone => {}
            _ => return Err(row(SectionKind::Vertices, vertex, RowFault::CachedInfluence { bone })),
        }
    }
    Ok(())
}
