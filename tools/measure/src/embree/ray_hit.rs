//! `rtcore_ray.h`: rays with room for their hits, one or several at a time.

use restpose_runtime::Ray;

/// `RTC_INVALID_GEOMETRY_ID`.
const NOTHING: u32 = u32::MAX;

/// `RTCRayHit`.
#[derive(Clone, Copy)]
#[repr(C, align(16))]
pub(crate) struct RayHit {
    origin: [f32; 3],
    near: f32,
    direction: [f32; 3],
    time: f32,
    far: f32,
    mask: u32,
    id: u32,
    flags: u32,
    normal: [f32; 3],
    weights: [f32; 2],
    primitive: u32,
    geometry: u32,
    instance: u32,
}

impl RayHit {
    pub fn new(ray: &Ray) -> Self {
        Self {
            origin: ray.origin,
            near: ray.t_min,
            direction: ray.direction,
            time: 0.0,
            far: ray.t_max,
            mask: u32::MAX,
            id: 0,
            flags: 0,
            normal: [0.0; 3],
            weights: [0.0; 2],
            primitive: NOTHING,
            geometry: NOTHING,
            instance: NOTHING,
        }
    }

    /// Of the hit, in lengths of the direction; infinite without one.
    pub fn distance(&self) -> f32 {
        if self.geometry == NOTHING {
            f32::INFINITY
        } else {
            self.far
        }
    }
}

/// `RTCRayHit8` and `RTCRayHit16`.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct RayHits<const N: usize> {
    origin: [[f32; N]; 3],
    near: [f32; N],
    direction: [[f32; N]; 3],
    time: [f32; N],
    far: [f32; N],
    mask: [u32; N],
    id: [u32; N],
    flags: [u32; N],
    normal: [[f32; N]; 3],
    weights: [[f32; N]; 2],
    primitive: [u32; N],
    geometry: [u32; N],
    instance: [u32; N],
}

impl<const N: usize> RayHits<N> {
    /// Of up to `N` rays; where they are fewer, the last stands for those that lack. There is at least one.
    pub fn new(rays: &[Ray]) -> Self {
        let of = |lane: usize| &rays[lane.min(rays.len() - 1)];
        Self {
            origin: std::array::from_fn(|k| std::array::from_fn(|lane| of(lane).origin[k])),
            near: std::array::from_fn(|lane| of(lane).t_min),
            direction: std::array::from_fn(|k| std::array::from_fn(|lane| of(lane).direction[k])),
            time: [0.0; N],
            far: std::array::from_fn(|lane| of(lane).t_max),
            mask: [u32::MAX; N],
            id: [0; N],
            flags: [0; N],
            normal: [[0.0; N]; 3],
            weights: [[0.0; N]; 2],
            primitive: [NOTHING; N],
            geometry: [NOTHING; N],
            instance: [NOTHING; N],
        }
    }

    /// As [`RayHit::distance`].
    pub fn distances(&self) -> [f32; N] {
        std::array::from_fn(|lane| {
            if self.geometry[lane] == NOTHING {
                f32::INFINITY
            } else {
                self.far[lane]
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layouts_are_those_of_the_header() {
        assert_eq!(size_of::<RayHit>(), 80);
        assert_eq!(std::mem::offset_of!(RayHit, far), 32);
        assert_eq!(std::mem::offset_of!(RayHit, normal), 48);
        assert_eq!(std::mem::offset_of!(RayHit, geometry), 72);
        assert_eq!(size_of::<RayHits<8>>(), 640);
        assert_eq!(size_of::<RayHits<16>>(), 1280);
        assert_eq!(std::mem::offset_of!(RayHits<16>, geometry), 64 * 18);
    }
}
