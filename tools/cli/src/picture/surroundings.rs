use super::colour::{Colour, decode};
use glam::{DVec3, Vec3};
use restpose_formats::geom::Aabb;
use restpose_runtime::Ray;

/// The floor lies below the lowest point of the clip by this share of the clip's size: far enough not to flicker
/// through a floor that the model brings along, near enough that feet seem to stand on it.
const FLOOR_GAP: f32 = 1e-3;

/// The floor begins to fade into the sky at this many times the clip's radius from its middle, and is gone at the
/// second number.
const FLOOR_FADE: [f32; 2] = [1.5, 6.0];

/// The sky has its full colour where the sine of the height above the horizon is one by this.
const SKY_STEEPNESS: f32 = 1.6;

/// Everything around the model: light, sky, floor.
#[derive(Clone, Copy, Debug)]
pub struct Surroundings {
    /// Unit vector towards the light.
    light: Vec3,
    floor: Option<Floor>,
    colours: Colours,
}

#[derive(Clone, Copy, Debug)]
struct Floor {
    height: f32,
    middle: Vec3,
    radius: f32,
}

/// Linear light.
#[derive(Clone, Copy, Debug)]
struct Colours {
    horizon: Colour,
    zenith: Colour,
    floor: Colour,
    sun: Colour,
    /// What reaches a surface that faces up, and one that faces down, without any light.
    ambient: [Colour; 2],
}

/// Where a ray meets the floor. The model is never behind it: the floor lies below all of it.
#[derive(Clone, Copy, Debug)]
pub struct FloorPoint {
    /// World space.
    pub point: Vec3,
    /// 1 under the model, 0 where the floor has faded away.
    solid: f32,
}

impl Surroundings {
    /// A light in direction `light`, and a floor under `bounds` if wanted.
    pub fn new(light: DVec3, bounds: &Aabb, floor: bool) -> Self {
        let extent = Vec3::from(bounds.max) - Vec3::from(bounds.min);
        let radius = extent.length() / 2.0;
        let height = bounds.min[1] - radius * FLOOR_GAP;
        let visible = floor && radius > 0.0 && radius.is_finite();
        let colours = Colours {
            horizon: decode([222, 230, 238]),
            zenith: decode([122, 164, 214]),
            floor: decode([196, 192, 186]),
            sun: Colour::new(1.0, 0.95, 0.86) * 1.3,
            ambient: [Colour::new(0.34, 0.41, 0.52), Colour::new(0.17, 0.15, 0.14)],
        };
        Self {
            light: light.normalize_or(DVec3::Y).as_vec3(),
            floor: visible.then(|| Floor {
                height,
                middle: bounds.center().into(),
                radius,
            }),
            colours,
        }
    }

    /// Unit vector towards the light.
    pub fn light(&self) -> Vec3 {
        self.light
    }

    /// What a ray sees that meets nothing.
    pub fn sky(&self, direction: Vec3) -> Colour {
        self.colours
            .horizon
            .lerp(self.colours.zenith, smooth(direction.y * SKY_STEEPNESS))
    }

    /// Light that a surface with this unit normal sends back; `sunlit` is false in a shadow.
    pub fn reflected(&self, own_colour: Colour, normal: Vec3, sunlit: bool) -> Colour {
        let [up, down] = self.colours.ambient;
        let ambient = down.lerp(up, normal.y * 0.5 + 0.5);
        let sun = if sunlit {
            self.colours.sun * normal.dot(self.light).max(0.0)
        } else {
            Colour::ZERO
        };
        own_colour * (ambient + sun)
    }

    /// Where a ray meets the floor from above. The floor cannot be seen from below.
    pub fn meet_floor(&self, ray: &Ray) -> Option<FloorPoint> {
        let floor = self.floor?;
        let (origin, direction) = (Vec3::from(ray.origin), Vec3::from(ray.direction));
        if origin.y <= floor.height || direction.y >= 0.0 {
            return None;
        }
        let t = (floor.height - origin.y) / direction.y;
        let point = (origin + direction * t).with_y(floor.height);
        let away = ((point - floor.middle).with_y(0.0).length() / floor.radius - FLOOR_FADE[0])
            / (FLOOR_FADE[1] - FLOOR_FADE[0]);
        let solid = 1.0 - smooth(away);
        (solid > 0.0).then_some(FloorPoint { point, solid })
    }

    /// What a ray sees at the floor.
    pub fn floor_colour(&self, at: &FloorPoint, direction: Vec3, sunlit: bool) -> Colour {
        self.sky(direction)
            .lerp(self.reflected(self.colours.floor, Vec3::Y, sunlit), at.solid)
    }
}

/// From 0 to 1 without a kink, where `x` goes from 0 to 1; clamped.
fn smooth(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn box_at_height_two() -> Aabb {
        Aabb {
            min: [-1.0, 2.0, -1.0],
            max: [1.0, 4.0, 1.0],
        }
    }

    #[test]
    fn the_floor_lies_just_below_the_model_and_ends() {
        let around = Surroundings::new(DVec3::Y, &box_at_height_two(), true);
        let down = |x: f32| around.meet_floor(&Ray::new([x, 10.0, 0.0], [0.0, -1.0, 0.0]));
        let under = down(0.0).expect("floor under the model");
        assert!(under.point.y < 2.0 && under.point.y > 1.99 && under.solid == 1.0);
        assert!(down(5.0).is_some_and(|at| at.solid > 0.0 && at.solid < 1.0));
        assert!(down(100.0).is_none());
        assert!(
            around
                .meet_floor(&Ray::new([0.0, -10.0, 0.0], [0.0, 1.0, 0.0]))
                .is_none()
        );
        assert!(
            Surroundings::new(DVec3::Y, &box_at_height_two(), false)
                .meet_floor(&Ray::new([0.0, 9.0, 0.0], [0.0, -1.0, 0.0]))
                .is_none()
        );
    }

    #[test]
    fn a_shadow_is_darker_and_a_surface_away_from_the_light_is_in_its_own() {
        let around = Surroundings::new(DVec3::Y, &box_at_height_two(), true);
        let light = |normal, sunlit| around.reflected(Colour::ONE, normal, sunlit).length();
        assert!(light(Vec3::Y, true) > 1.5 * light(Vec3::Y, false));
        assert_eq!(light(Vec3::NEG_Y, true), light(Vec3::NEG_Y, false));
    }
}
