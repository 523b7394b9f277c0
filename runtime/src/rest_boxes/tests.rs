use super::*;
use crate::posed_bounds::EVERYWHERE;

fn boxes(random: &mut fastrand::Rng, bones: u32, size: f32) -> RestBoxes {
    let mut out = RestBoxes::default();
    for bone in 0..bones {
        let first = out.rows.len();
        for _ in 0..random.usize(1..4) {
            let mut corner = || std::array::from_fn(|_| (random.f32() - 0.5) * size);
            out.rows.push((RestBox::new(&Aabb::around([corner(), corner()])), bone));
        }
        // A cluster of the bone's rows, and in the next one they are not alone.
        out.of_clusters.push(first..out.rows.len());
        out.of_clusters.push(first / 2..out.rows.len());
        let rows = &out.rows[first..];
        let mut reach = [0.0f32; 3];
        for (row, _) in rows {
            let own = row.reach().map(f32_above);
            reach = std::array::from_fn(|k| reach[k].max(own[k]));
        }
        out.bones.push(RestBone {
            bone,
            bounds: rows[0].0,
            reach,
        });
    }
    out
}

fn bits(bounds: &Aabb) -> [u32; 6] {
    let [a, b, c] = bounds.min.map(f32::to_bits);
    let [d, e, f] = bounds.max.map(f32::to_bits);
    [a, b, c, d, e, f]
}

/// Boxes hold the images of corners, at every scale of map and rest pose; everything where numbers overflow. All levels
/// compute the same.
#[test]
fn boxes_hold_images_of_corners() {
    let mut random = fastrand::Rng::with_seed(77);
    let mut everywhere = 0;
    for round in 0..600 {
        let bones = random.u32(1..6);
        let size = 10f32.powi(random.i32(-30..30));
        let boxes = boxes(&mut random, bones, size);
        let scale = 10f32.powi(random.i32(-12..12));
        let posed: Vec<Affine> = (0..bones)
            .map(|_| Affine {
                columns: std::array::from_fn(|j| {
                    std::array::from_fn(|_| {
                        let entry = (random.f32() - 0.5) * scale;
                        if j == 3 { entry * size } else { entry }
                    })
                }),
            })
            .collect();
        let grown = [[0.0; 3], [0.0, 0.5 * size, size]][round % 2];
        let error = f32_above(IMAGE_ERROR);
        let mut memory = BoneImages::default();
        let mut found = Vec::new();
        cluster_bounds_with(Portable, &boxes, &posed, grown, error, &mut memory, &mut found);
        let all = images(SimdLevel::Portable, &boxes, &posed, grown.map(f64::from));
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = Avx2::new() {
            let mut other = Vec::new();
            cluster_bounds_with(simd, &boxes, &posed, grown, error, &mut memory, &mut other);
            let both = found.iter().zip(&other);
            assert!(both.clone().all(|(a, b)| bits(a) == bits(b)), "round {round}");
            let other = images(SimdLevel::Avx2, &boxes, &posed, grown.map(f64::from));
            assert_eq!(bits(&all.bounds), bits(&other.bounds));
            assert_eq!((all.reach, all.rest_reach), (other.reach, other.rest_reach));
        }
        for (rows, bounds) in boxes.of_clusters.iter().zip(&found) {
            everywhere += u32::from(*bounds == EVERYWHERE);
            for (rest, place) in &boxes.rows[rows.clone()] {
                let x = posed[*place as usize].columns.map(|column| column.map(f64::from));
                for corner in 0..8 {
                    let p: [f64; 3] = std::array::from_fn(|k| {
                        let side = if corner >> k & 1 == 0 { -1.0 } else { 1.0 };
                        f64::from(rest.0[k][0]) + side * (f64::from(rest.0[k][4]) + f64::from(grown[k]))
                    });
                    for k in 0..3 {
                        let image = x[0][k] * p[0] + x[1][k] * p[1] + x[2][k] * p[2] + x[3][k];
                        // Beyond the greatest number no vertex is.
                        let image = image.clamp(f32::MIN.into(), f32::MAX.into());
                        let inside = (bounds.min[k].into()..=bounds.max[k].into()).contains(&image);
                        assert!(inside, "round {round}: {image} {bounds:?}");
                    }
                }
            }
        }
    }
    assert!((10..1000).contains(&everywhere), "{everywhere}");
}
