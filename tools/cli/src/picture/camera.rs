use glam::DVec3;
use restpose_formats::geom::Aabb;
use restpose_runtime::Ray;

/// Empty border around a model that the camera frames by itself, as a share of the picture's half side.
const BORDER: f64 = 0.12;

/// A pinhole camera. Set up in `f64`, so that framing survives any coordinates a mesh can have.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    origin: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    /// Half the picture at distance 1 spans this much, vertically.
    half_height: f64,
    width: f64,
    height: f64,
}

/// A point as the camera sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projected {
    /// In pixels from the left edge.
    pub x: f64,
    /// In pixels from the upper edge.
    pub y: f64,
    /// Along the view direction, scene units.
    pub depth: f64,
}

/// Lens and picture.
#[derive(Clone, Copy, Debug)]
pub struct Lens {
    /// Vertical angle of view.
    pub fov_deg: f64,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
}

impl Camera {
    /// A camera at `origin` that looks at `target` with y up; where both are the same point it looks along -z.
    pub fn looking_at(origin: DVec3, target: DVec3, lens: Lens) -> Self {
        Self::facing(origin, (target - origin).try_normalize().unwrap_or(DVec3::NEG_Z), lens)
    }

    /// A camera at `origin` that looks along the unit vector `forward` with y up.
    fn facing(origin: DVec3, forward: DVec3, lens: Lens) -> Self {
        // Straight up or down there is no upright picture: x is then to the right.
        let right = forward.cross(DVec3::Y).try_normalize().unwrap_or(DVec3::X);
        let half_height = libm::tan(lens.fov_deg.to_radians() / 2.0);
        let (width, height) = (lens.width.into(), lens.height.into());
        Self {
            origin,
            forward,
            right,
            up: right.cross(forward),
            half_height,
            width,
            height,
        }
    }

    /// A camera that sees the whole of `bounds` from the direction given by two angles, as near as it can.
    ///
    /// Yaw 0 looks along -z; yaw turns the camera's place about the y axis towards +x; pitch lifts it. With a `target`
    /// the camera looks at that point, else wherever the box comes to lie in the middle of the picture.
    pub fn framing(bounds: &Aabb, yaw_deg: f64, pitch_deg: f64, target: Option<DVec3>, lens: Lens) -> Self {
        let (yaw, pitch) = (yaw_deg.to_radians(), pitch_deg.to_radians());
        let backward = DVec3::new(
            libm::sin(yaw) * libm::cos(pitch),
            libm::sin(pitch),
            libm::cos(yaw) * libm::cos(pitch),
        );
        let corners = corners(bounds);
        let middle = target.unwrap_or((corners[0] + corners[7]) / 2.0);
        let mut camera = Self::facing(middle, -backward, lens);
        let tan = [camera.half_height * camera.aspect(), camera.half_height].map(|tan| tan * (1.0 - BORDER));
        let fit = |axis: DVec3, tan: f64| {
            // A corner at `across` along the axis and `ahead` of the middle is seen by a camera that stands `away` from
            // the middle and `aside` along the axis if |across − aside| ≤ tan · (away + ahead).
            let seen = corners.map(|corner| ((corner - middle).dot(axis), (corner - middle).dot(camera.forward) * tan));
            let least = seen
                .iter()
                .map(|(across, ahead)| across - ahead)
                .fold(f64::NEG_INFINITY, f64::max);
            let most = seen
                .iter()
                .map(|(across, ahead)| across + ahead)
                .fold(f64::INFINITY, f64::min);
            match target {
                Some(_) => (0.0, least.max(-most) / tan),
                None => ((least + most) / 2.0, (least - most) / 2.0 / tan),
            }
        };
        let ((right, away_x), (up, away_y)) = (fit(camera.right, tan[0]), fit(camera.up, tan[1]));
        let away = away_x.max(away_y);
        // A single point has no size to go by; any distance shows it.
        let away = if away > 0.0 { away } else { 1.0 };
        camera.origin = middle + camera.right * right + camera.up * up + backward * away;
        camera
    }

    /// The ray through a place in the picture, in pixels from the upper left corner. Its direction has length one up
    /// to rounding.
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        let sideways = (2.0 * x / self.width - 1.0) * self.half_height * self.aspect();
        let upwards = (1.0 - 2.0 * y / self.height) * self.half_height;
        let direction = (self.forward + self.right * sideways + self.up * upwards).normalize();
        Ray::new(self.origin.as_vec3().to_array(), direction.as_vec3().to_array())
    }

    /// Where a point appears; `None` at or behind the camera.
    pub fn project(&self, point: DVec3) -> Option<Projected> {
        let p = point - self.origin;
        let depth = self.depth_of(point);
        let scale = 0.5 / (depth * self.half_height);
        (depth > 0.0 && scale.is_finite()).then(|| Projected {
            x: self.width * 0.5 + p.dot(self.right) * scale * self.height,
            y: self.height * 0.5 - p.dot(self.up) * scale * self.height,
            depth,
        })
    }

    /// Depth along the view direction of the point at distance `t` on a ray of this camera.
    pub fn depth_on(&self, ray: &Ray, t: f32) -> f64 {
        glam::Vec3::from(ray.direction).as_dvec3().dot(self.forward) * f64::from(t)
    }

    /// Depth of a point along the view direction, scene units; negative behind the camera.
    pub fn depth_of(&self, point: DVec3) -> f64 {
        (point - self.origin).dot(self.forward)
    }

    fn aspect(&self) -> f64 {
        self.width / self.height
    }
}

/// The eight corners of a box: bit 0, 1, 2 of the index chooses the greater x, y, z.
pub fn corners(bounds: &Aabb) -> [DVec3; 8] {
    std::array::from_fn(|i| {
        DVec3::from_array(std::array::from_fn(|k| {
            f64::from(if i >> k & 1 == 1 { bounds.max[k] } else { bounds.min[k] })
        }))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENS: Lens = Lens {
        fov_deg: 40.0,
        width: 640,
        height: 480,
    };

    #[test]
    fn a_framed_box_fills_the_picture_and_stays_inside() {
        let boxes = [
            Aabb {
                min: [-1.0, 0.0, -2.0],
                max: [3.0, 5.0, 1.0],
            },
            Aabb {
                min: [1e20, 0.0, 0.0],
                max: [3e20, 1e20, 1e20],
            },
            Aabb {
                min: [-1e-20; 3],
                max: [1e-20; 3],
            },
        ];
        for bounds in boxes {
            for (yaw, pitch) in [(0.0, 0.0), (35.0, 14.0), (200.0, -60.0), (0.0, 89.0)] {
                let camera = Camera::framing(&bounds, yaw, pitch, None, LENS);
                let seen = corners(&bounds).map(|corner| camera.project(corner).expect("in front"));
                let reach = |of: fn(&Projected) -> f64, side: f64| {
                    seen.iter()
                        .map(|p| (of(p) / side * 2.0 - 1.0).abs())
                        .fold(0.0, f64::max)
                };
                let widest = reach(|p| p.x, 640.0).max(reach(|p| p.y, 480.0));
                // 1e-6: the box's middle is rounded in f64 against extents as small as its last places.
                assert!(
                    (widest - (1.0 - BORDER)).abs() < 1e-6,
                    "{bounds:?} {yaw} {pitch}: {widest}"
                );
            }
        }
    }

    #[test]
    fn projection_undoes_the_ray() {
        let camera = Camera::looking_at(DVec3::new(3.0, 2.0, 5.0), DVec3::ZERO, LENS);
        for (x, y) in [(0.5, 0.5), (320.0, 240.0), (639.5, 12.25)] {
            let ray = camera.ray(x, y);
            let point = glam::Vec3::from(ray.origin) + glam::Vec3::from(ray.direction) * 7.0;
            let seen = camera.project(point.as_dvec3()).expect("in front");
            // 1e-3 pixels: the ray is rounded to f32, about 1e-7 of its length 7, at 660 pixels per unit of slope.
            assert!(
                (seen.x - x).abs() < 1e-3 && (seen.y - y).abs() < 1e-3,
                "{x} {y}: {seen:?}"
            );
            assert!((camera.depth_on(&ray, 7.0) - seen.depth).abs() < 1e-5);
        }
        assert_eq!(camera.project(DVec3::new(30.0, 20.0, 50.0)), None);
    }

    #[test]
    fn looking_straight_down_still_gives_a_picture() {
        let camera = Camera::looking_at(DVec3::Y * 4.0, DVec3::ZERO, LENS);
        let middle = camera.project(DVec3::ZERO).expect("in front");
        assert_eq!((middle.x, middle.y, middle.depth), (320.0, 240.0, 4.0));
        assert!(camera.project(DVec3::X).is_some_and(|p| p.x > 320.0));
    }
}
