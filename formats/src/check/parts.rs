use super::{
    numbers::{index, index_within, reserved},
    row,
    tiling::Tiling,
};
use crate::{
    FormatError, ModelView, RowFault, SectionKind,
    rows::{MotionClass, NONE, PartRow},
};
use std::ops::Range;

/// Parts tile the vertices, triangles and primitives; primitives tile their part's triangles; a triangle's corners
/// are vertices of its part.
pub(super) fn check(view: &ModelView<'_>) -> Result<(), FormatError> {
    if view.triangles.is_empty() {
        return Err(FormatError::NoTriangles);
    }
    let section = SectionKind::Parts;
    let mut vertices = Tiling::with_closing_rows(SectionKind::Vertices, view.vertices.len(), 1);
    let mut triangles = Tiling::new(SectionKind::Triangles, view.triangles.len());
    let mut primitives = Tiling::new(SectionKind::Primitives, view.primitives.len());
    for (at, part) in view.parts.iter().enumerate() {
        check_fields(view, at, part)?;
        vertices.take(section, at, "vertex_first", part.vertex_first, part.vertex_count)?;
        let of_part = triangles.take(section, at, "triangle_first", part.triangle_first, part.triangle_count)?;
        let range = primitives.take(
            section,
            at,
            "primitive_first",
            part.primitive_first,
            part.primitive_count,
        )?;
        check_primitives(view, range, of_part.clone(), at)?;
        check_corners(view, part, of_part)?;
    }
    vertices.finish()?;
    triangles.finish()?;
    primitives.finish()
}

fn check_fields(view: &ModelView<'_>, at: usize, part: &PartRow) -> Result<(), FormatError> {
    let section = SectionKind::Parts;
    if MotionClass::from_number(part.class).is_none() {
        let limit = MotionClass::ALL.len() as u32;
        let fault = RowFault::UnknownNumber {
            field: "class",
            found: part.class,
            limit,
        };
        return Err(row(section, at, fault));
    }
    if part.morph_set != NONE {
        index(section, at, "morph_set", part.morph_set, view.morph_sets.len())?;
    }
    Ok(())
}

/// The primitives of part `part` tile its triangles.
fn check_primitives(
    view: &ModelView<'_>,
    primitives: Range<usize>,
    triangles: Range<usize>,
    part: usize,
) -> Result<(), FormatError> {
    let section = SectionKind::Primitives;
    let mut next = triangles.start as u64;
    for at in primitives {
        let primitive = &view.primitives[at];
        reserved(section, at, "reserved", &[primitive.reserved])?;
        let (first, count) = (u64::from(primitive.triangle_first), u64::from(primitive.triangle_count));
        let field = "triangle_first";
        if first != next {
            let fault = RowFault::RangeNotContiguous {
                field,
                found: first,
                expected: next,
            };
            return Err(row(section, at, fault));
        }
        next = first + count;
        if next > triangles.end as u64 {
            let limit = triangles.end as u64;
            return Err(row(
                section,
                at,
                RowFault::RangeOutOfBounds {
                    field,
                    first,
                    count,
                    limit,
                },
            ));
        }
    }
    if next == triangles.end as u64 {
        return Ok(());
    }
    let fault = RowFault::Count {
        field: "triangle_count",
        found: triangles.len() as u64,
        expected: next - triangles.start as u64,
    };
    Err(row(SectionKind::Parts, part, fault))
}

fn check_corners(view: &ModelView<'_>, part: &PartRow, triangles: Range<usize>) -> Result<(), FormatError> {
    let first = part.vertex_first as usize;
    let vertices = first..first + part.vertex_count as usize;
    for at in triangles {
        for corner in view.triangles[at].corners {
            index_within(SectionKind::Triangles, at, "corners", corner, &vertices)?;
        }
    }
    Ok(())
}
