//! Round limbs that melt into one another, as a distance-like field.

use glam::DVec3;

/// A round cone between two points that follows one bone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limb {
    /// Bone that it follows, by number.
    pub bone: usize,
    /// One end.
    pub from: DVec3,
    /// Other end.
    pub to: DVec3,
    /// Radius at `from`.
    pub from_radius: f64,
    /// Radius at `to`.
    pub to_radius: f64,
}

impl Limb {
    /// Distance from the limb's surface, negative inside; exact where both radii are equal.
    pub fn distance(&self, point: DVec3) -> f64 {
        let axis = self.to - self.from;
        let along = (point - self.from).dot(axis) / axis.length_squared();
        let along = along.clamp(0.0, 1.0);
        let radius = self.from_radius + (self.to_radius - self.from_radius) * along;
        point.distance(self.from + axis * along) - radius
    }
}

/// Limbs joined into one body.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// The limbs; their order matters in the last bits only.
    pub limbs: Vec<Limb>,
    /// Width of the zone in which two limbs melt together, scene units.
    pub blend: f64,
}

impl Body {
    /// The field: negative inside the body, about the distance near its surface.
    pub fn field(&self, point: DVec3) -> f64 {
        self.limbs.iter().fold(f64::INFINITY, |joined, limb| {
            smooth_minimum(joined, limb.distance(point), self.blend)
        })
    }

    /// Direction in which the field grows, by central differences; of unit length.
    pub fn outward(&self, point: DVec3) -> DVec3 {
        // A ten-thousandth of a unit: far below the size of a triangle, far above the rounding of f64.
        let step = 1e-4;
        let slope = |axis: DVec3| self.field(point + axis * step) - self.field(point - axis * step);
        DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z)).normalize_or(DVec3::Y)
    }

    /// The point moved onto the surface along the field.
    pub fn settled(&self, mut point: DVec3) -> DVec3 {
        for _ in 0..4 {
            point -= self.outward(point) * self.field(point);
        }
        point
    }
}

/// The minimum of two distances, rounded off by a parabola where they differ by less than `width`.
fn smooth_minimum(a: f64, b: f64, width: f64) -> f64 {
    let overlap = (width - (a - b).abs()).max(0.0);
    a.min(b) - overlap * overlap / (4.0 * width)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_to_a_round_cone() {
        let limb = Limb {
            bone: 0,
            from: DVec3::ZERO,
            to: DVec3::new(2.0, 0.0, 0.0),
            from_radius: 1.0,
            to_radius: 0.5,
        };
        assert_eq!(limb.distance(DVec3::new(-3.0, 0.0, 0.0)), 2.0);
        assert_eq!(limb.distance(DVec3::new(1.0, 2.0, 0.0)), 1.25);
        assert_eq!(limb.distance(DVec3::new(4.0, 0.0, 0.0)), 1.5);
    }

    #[test]
    fn smooth_minimum_is_the_minimum_outside_its_zone() {
        assert_eq!(smooth_minimum(1.0, 3.0, 0.5), 1.0);
        assert_eq!(smooth_minimum(1.0, 1.0, 0.5), 0.875);
        assert_eq!(smooth_minimum(f64::INFINITY, 1.0, 0.5), 1.0);
    }
}
