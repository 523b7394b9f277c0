use crate::{Hit, InstanceId, Ray, triangle::PreparedRay};
use restpose_formats::geom::round::{f32_above, f32_below};

/// A ray on its way through the scene.
#[derive(Clone)]
pub(super) struct Traveller {
    prepared: PreparedRay,
    pub(super) origin: [f32; 3],
    /// Scaled.
    pub(super) direction: [f32; 3],
    /// Scaled `t` is `t` times this.
    scale: f64,
    pub(super) best: Option<Hit>,
    /// Scaled `t` beyond which no box matters.
    pub(super) limit: f32,
    /// Triangles tested so far.
    pub(super) tests: u32,
}

impl Traveller {
    /// The ray, and the scaled `t` at which it begins; `None` for one that hits nothing.
    #[inline]
    pub(super) fn new(ray: &Ray) -> Option<(Self, f32)> {
        let prepared = PreparedRay::new(ray)?;
        let longest = ray.direction.iter().fold(0.0f32, |longest, d| longest.max(d.abs()));
        // Every nonzero f32 is a normal f64, so its exponent bits are its magnitude.
        let exponent = i64::try_from(f64::from(longest).to_bits() >> 52).ok()? - 1023;
        let power = |e: i64| f64::from_bits(((1023 + e) as u64) << 52);
        let direction = ray.direction.map(|d| (f64::from(d) * power(-exponent)) as f32);
        let scale = power(exponent);
        let start = f32_below(f64::from(ray.t_min.next_down()) * scale);
        let mut out = Self {
            prepared,
            origin: ray.origin,
            direction,
            scale,
            best: None,
            limit: f32::INFINITY,
            tests: 0,
        };
        out.limit = out.limit_behind(ray.t_max);
        Some((out, start))
    }

    fn limit_behind(&self, t: f32) -> f32 {
        f32_above(f64::from(t.next_up()) * self.scale)
    }

    /// Goes on from a hit that was found elsewhere.
    #[inline]
    pub(super) fn resume(&mut self, best: Hit) {
        self.best = Some(best);
        self.limit = self.limit_behind(best.t);
    }

    /// Tests one posed triangle; true when it is the best hit so far.
    #[inline(always)]
    pub(super) fn test(&mut self, corners: &[[f32; 3]; 3], instance: InstanceId, triangle: u32) -> bool {
        self.tests = self.tests.wrapping_add(1);
        let Some(found) = self.prepared.intersect(corners) else {
            return false;
        };
        let hit = Hit {
            t: found.t,
            u: found.u,
            v: found.v,
            instance,
            triangle,
        };
        if self.best.as_ref().is_some_and(|best| !hit.is_before(best)) {
            return false;
        }
        self.best = Some(hit);
        self.limit = self.limit_behind(hit.t);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_scaled_exactly() {
        for longest in [
            f32::from_bits(1),
            f32::MIN_POSITIVE,
            1e-30,
            0.75,
            1.0,
            3.0,
            1e30,
            f32::MAX,
        ] {
            let (traveller, start) = Traveller::new(&Ray::new([0.0; 3], [longest, -longest / 2.0, 0.0])).unwrap();
            let d = traveller.direction[0];
            assert!((1.0..2.0).contains(&d), "{longest}: {d}");
            assert_eq!(f64::from(d) * traveller.scale, f64::from(longest));
            assert!(start < 0.0 && traveller.limit == f32::INFINITY);
        }
    }

    #[test]
    fn limit_lies_behind_the_hit() {
        let (traveller, _) = Traveller::new(&Ray::new([0.0; 3], [1e38, 0.0, 0.0])).unwrap();
        for t in [0.0, f32::from_bits(1), 1e-40, 1.0] {
            assert!(
                f64::from(traveller.limit_behind(t)) > f64::from(t) * traveller.scale,
                "{t}"
            );
        }
    }
}
