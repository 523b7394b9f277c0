use restpose_samples::{
    rotation::{cos_turn, sin_turn},
    solids::{GearShape, cuboid, gear, lathe, sphere},
    surface::Surface,
};

/// Closed surfaces about one unit large, with their names: round, flat-sided, with a hole, with notches, long.
#[must_use]
pub fn closed_surfaces() -> Vec<(&'static str, Surface)> {
    let half = |surface: Surface| surface.map(|p| p * 0.5);
    let gear = gear(GearShape {
        teeth: 9,
        pitch_radius: 0.4,
        bore_radius: 0.12,
        half_thickness: 0.1,
    });
    vec![
        ("sphere", half(sphere(2))),
        ("cube", cuboid([-0.5; 3].into(), [0.5; 3].into())),
        ("gear", gear),
        ("torus", torus(16, 9)),
        ("tube", tube()),
    ]
}

/// A capped tube about y from -0.5 to 0.5, which joints can bend.
#[must_use]
pub fn tube() -> Surface {
    let profile: Vec<(f64, f64)> = (0..=12).map(|ring| (0.15, f64::from(ring) / 12.0 - 0.5)).collect();
    lathe(&profile, 10)
}

/// Four spheres along y, one between each two of four joints: of each triangle all vertices follow one joint where the
/// mesh is stiff, so its boxes hold for any palette.
#[must_use]
pub fn beads() -> Surface {
    let mut surface = Surface::default();
    for y in [-0.375, -0.125, 0.125, 0.375] {
        surface.append(&sphere(1).map(|p| p * 0.1).translated([0.0, y, 0.0].into()));
    }
    surface
}

/// A ring of `sides` tubes of `around` corners about y.
fn torus(sides: u32, around: u32) -> Surface {
    let mut surface = Surface::default();
    for side in 0..sides {
        let turn = f64::from(side) / f64::from(sides);
        for corner in 0..around {
            let tilt = f64::from(corner) / f64::from(around);
            let radius = 0.35 + 0.13 * cos_turn(tilt);
            let point = [radius * sin_turn(turn), 0.13 * sin_turn(tilt), radius * cos_turn(turn)];
            surface.push(point.into());
        }
    }
    let at = |side: u32, corner: u32| side % sides * around + corner % around;
    for side in 0..sides {
        for corner in 0..around {
            surface.push_quad([
                at(side, corner),
                at(side + 1, corner),
                at(side + 1, corner + 1),
                at(side, corner + 1),
            ]);
        }
    }
    surface
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_closed_and_wound_outwards() {
        for (name, surface) in closed_surfaces() {
            assert!(surface.is_closed_manifold(), "{name} is open");
            assert!(surface.volume() > 0.0, "{name} is inside out");
        }
    }
}
