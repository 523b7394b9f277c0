use super::clip::{ClipRow, STRETCHES};
use crate::geom::Aabb;
use bytemuck::{Pod, Zeroable};

/// Where the triangles of an asset are during a stretch of a clip, or in the pose without any clip.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ClipBoundsRow {
    /// Contains, in exact arithmetic, every mix `Σ w·(X·p)` of every vertex of every triangle with area, in asset space: at
    /// every time of the stretch, with the palette and the morph weights of that time as rounded to `f32`.
    /// [`Aabb::EMPTY`] where nothing is known.
    pub bounds: Aabb,
    /// Bounds, per axis, the magnitudes `|X|·|p| + |t|` that enter these mixes, for every bone and every vertex that it
    /// moves: rounding at run time is relative to them. Zero where nothing is known.
    pub reach: [f32; 3],
    /// Bounds `|p₀| + |p₁| + |p₂|` of every `p`, a rest position as morphed, term by term. Zero where nothing is known.
    pub rest_reach: f32,
    /// 1 where `bounds` holds, 0 where nothing is known.
    pub known: u32,
}

impl ClipBoundsRow {
    /// The row of a stretch that nothing bounds.
    pub const UNKNOWN: Self = Self {
        bounds: Aabb::EMPTY,
        reach: [0.0; 3],
        rest_reach: 0.0,
        known: 0,
    };

    /// The row of a stretch that stays within `bounds`; fields as they are named.
    #[must_use]
    pub fn within(bounds: Aabb, reach: [f32; 3], rest_reach: f32) -> Self {
        Self {
            bounds,
            reach,
            rest_reach,
            known: 1,
        }
    }

    /// True where the bounds hold.
    #[must_use]
    pub fn is_known(&self) -> bool {
        self.known != 0
    }

    /// The number of the row that bounds a clip at a time, where the section has rows: that of the time's stretch. Of no
    /// clip, and of a time that is a NaN, at which a clip has the pose without any clip, it is the last row.
    ///
    /// # Panics
    /// When there is no such clip.
    #[inline]
    #[must_use]
    pub fn row_at(clips: &[ClipRow], clip: Option<usize>, seconds: f32) -> usize {
        match clip {
            Some(clip) if !seconds.is_nan() => clip * STRETCHES + clips[clip].stretch(seconds),
            _ => clips.len() * STRETCHES,
        }
    }

    /// The box around a clip at all times, of the rows of a file; `None` where any of its stretches is not known.
    #[must_use]
    pub fn around_clip(rows: &[Self], clip: usize) -> Option<Aabb> {
        let stretches = rows.get(clip * STRETCHES..(clip + 1) * STRETCHES)?;
        stretches
            .iter()
            .all(Self::is_known)
            .then(|| stretches.iter().fold(Aabb::EMPTY, |all, row| all.union(row.bounds)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clip(end_seconds: f32) -> ClipRow {
        ClipRow {
            start_seconds: 0.0,
            end_seconds,
            channel_first: 0,
            channel_count: 1,
        }
    }

    #[test]
    fn rows_are_those_of_clips_in_order_and_the_last_is_that_of_no_clip() {
        let clips = [clip(1.0), clip(2.0)];
        let row = |clip, seconds| ClipBoundsRow::row_at(&clips, clip, seconds);
        assert_eq!(row(Some(0), 0.5), STRETCHES / 2);
        assert_eq!(row(Some(1), 0.5), STRETCHES + STRETCHES / 4);
        assert_eq!(row(None, 0.5), 2 * STRETCHES);
        assert_eq!(row(Some(0), f32::NAN), 2 * STRETCHES);
    }

    #[test]
    fn a_clip_is_bounded_where_all_of_its_stretches_are() {
        let at = |x| {
            let bounds = Aabb::around([[x, 0.0, 0.0]]);
            ClipBoundsRow::within(bounds, [x, 0.0, 0.0], x)
        };
        let mut rows = vec![at(9.0); 2 * STRETCHES + 1];
        for (stretch, row) in rows[STRETCHES..2 * STRETCHES].iter_mut().enumerate() {
            *row = at(stretch as f32);
        }
        let all = Aabb::around([[0.0; 3], [STRETCHES as f32 - 1.0, 0.0, 0.0]]);
        assert_eq!(ClipBoundsRow::around_clip(&rows, 1), Some(all));
        rows[2 * STRETCHES - 1] = ClipBoundsRow::UNKNOWN;
        assert_eq!(ClipBoundsRow::around_clip(&rows, 1), None);
        assert_eq!(ClipBoundsRow::around_clip(&[], 0), None);
    }
}
