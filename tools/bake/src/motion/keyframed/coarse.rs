//! A mesh of fewer points that moves like a fine one.

use super::{components::labels, patch::Neighbours, states::States};
use std::collections::HashSet;

/// Triangles up to which a mesh is clustered as it is.
const MOST_TRIANGLES: usize = 1 << 17;

/// Triangles that are enough to look for clusters where there are more than [`MOST_TRIANGLES`].
///
/// The search takes as long as there are points, times clusters, times some hundred tries. Whole bakes of ELEPHANT in one
/// batch, by triangles searched, with the expected cost of a ray: all 84,638 86 s and 51.6, 43,918 46 s and 51.9, 22,603 36 s
/// and 51.9, 11,679 10 s and 58.0, 6,029 11 s and 55.3. HORSE: all 16,843 32.0, 8,707 32.2, 4,524 34.1, 2,382 37.9.
const ENOUGH_TRIANGLES: usize = 1 << 15;

/// Points that a component keeps, so that its motion is seen however small it is; but for one all of whose triangles meet in
/// a point, and collapse.
const FEWEST_POINTS: u32 = 4;

/// A round that leaves more than this part of the points is the last.
const LEAST_MERGED: f64 = 0.9;

/// The mesh with neighbouring points merged until few enough triangles are left; `None` where it has few enough, or none
/// that can be merged.
///
/// In each round every point that is still alone takes in its nearest neighbour, in the first key, that is alone, too: the one
/// with the lower number stays, and moves as it did. Only points of one triangle are merged, so what merely touches stays
/// apart. Scale and centres are kept: maps of one mesh are maps of the other.
pub(super) fn coarse(states: &States) -> Option<States> {
    (states.triangles.len() > MOST_TRIANGLES)
        .then(|| merged(states, ENOUGH_TRIANGLES))
        .flatten()
}

fn merged(states: &States, enough: usize) -> Option<States> {
    let component_of = labels(states.points, &states.triangles);
    let mut points: Vec<u32> = (0..states.points as u32).collect();
    let mut triangles = states.triangles.clone();
    while triangles.len() > enough {
        let (fewer, left) = merge_once(states, &component_of, &points, &triangles);
        if left.is_empty() {
            break;
        }
        let is_last = fewer.len() as f64 > points.len() as f64 * LEAST_MERGED;
        (points, triangles) = (fewer, left);
        if is_last {
            break;
        }
    }
    (points.len() < states.points).then(|| states.part(&points, triangles))
}

/// One round. `triangles` are numbered among `points`, which are numbered among those of `states`, as `component_of` is.
fn merge_once(
    states: &States,
    component_of: &[u32],
    points: &[u32],
    triangles: &[[u32; 3]],
) -> (Vec<u32>, Vec<[u32; 3]>) {
    const ALONE: u32 = u32::MAX;
    let neighbours = Neighbours::new(points.len(), triangles);
    let mut counts = vec![0u32; states.points];
    for point in points {
        counts[component_of[*point as usize] as usize] += 1;
    }
    let position = |point: u32| states.position(0, points[point as usize] as usize);
    let mut stays_as = vec![ALONE; points.len()];
    for point in 0..points.len() as u32 {
        if stays_as[point as usize] != ALONE {
            continue;
        }
        stays_as[point as usize] = point;
        let count = &mut counts[component_of[points[point as usize] as usize] as usize];
        if *count <= FEWEST_POINTS {
            continue;
        }
        let around = neighbours.around(point).iter();
        let corners = around.flat_map(|triangle| triangles[*triangle as usize]);
        let distance = |other: u32| (position(other) - position(point)).length_squared();
        let nearest = corners
            .filter(|corner| stays_as[*corner as usize] == ALONE)
            .min_by(|a, b| distance(*a).total_cmp(&distance(*b)).then(a.cmp(b)));
        if let Some(nearest) = nearest {
            stays_as[nearest as usize] = point;
            *count -= 1;
        }
    }
    let mut number = vec![0u32; points.len()];
    let mut left = Vec::new();
    for point in 0..points.len() {
        if stays_as[point] == point as u32 {
            number[point] = left.len() as u32;
            left.push(points[point]);
        }
    }
    let mut known = HashSet::with_capacity(triangles.len() / 2);
    let moved = triangles
        .iter()
        .map(|corners| corners.map(|corner| number[stays_as[corner as usize] as usize]));
    let kept = moved.filter(|[a, b, c]| {
        let mut corners = [*a, *b, *c];
        corners.sort_unstable();
        a != b && b != c && c != a && known.insert(corners)
    });
    (left, kept.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: u32 = 40;

    /// Two waving sheets in one place, and one triangle by itself. A sheet has the points `SIDE² · sheet` and on.
    fn sheets() -> States {
        let frame = |key: usize| {
            let point = |place: u32| {
                let (x, y) = ((place % SIDE) as f32, (place / SIDE % SIDE) as f32);
                [x, y, (x * 0.3 + key as f32).sin()]
            };
            let island = [[90.0, key as f32, 0.0], [91.0, 0.0, 0.0], [90.0, 1.0, 0.0]];
            (0..2 * SIDE * SIDE).map(point).chain(island).collect::<Vec<[f32; 3]>>()
        };
        let frames: Vec<Vec<[f32; 3]>> = (0..3).map(frame).collect();
        let mut triangles = Vec::new();
        for corner in (0..2 * SIDE * SIDE).filter(|corner| corner % SIDE != SIDE - 1) {
            if corner / SIDE % SIDE != SIDE - 1 {
                triangles.push([corner, corner + 1, corner + SIDE]);
                triangles.push([corner + 1, corner + SIDE + 1, corner + SIDE]);
            }
        }
        let island = 2 * SIDE * SIDE;
        triangles.push([island, island + 1, island + 2]);
        let frames: Vec<&[[f32; 3]]> = frames.iter().map(Vec::as_slice).collect();
        let points: Vec<u32> = (0..island + 3).collect();
        States::new(&frames, &points, triangles)
    }

    #[test]
    fn merged_points_move_as_they_did_and_what_touches_stays_apart() {
        let fine = sheets();
        let enough = fine.triangles.len() / 8;
        let coarse = merged(&fine, enough).unwrap();
        assert!(
            (enough / 4..=enough).contains(&coarse.triangles.len()),
            "{} triangles",
            coarse.triangles.len()
        );
        let trajectory = |states: &States, point: u32| -> Vec<[u64; 3]> {
            (0..states.keys)
                .map(|key| states.position(key, point as usize).to_array().map(f64::to_bits))
                .collect()
        };
        // Both sheets have the same points: the first of them in turn takes the lower number.
        let known: HashSet<_> = (0..fine.points as u32).map(|point| trajectory(&fine, point)).collect();
        assert!((0..coarse.points as u32).all(|point| known.contains(&trajectory(&coarse, point))));
        let components: HashSet<u32> = labels(coarse.points, &coarse.triangles).into_iter().collect();
        assert_eq!(components.len(), 3, "two sheets and the triangle");
        assert_eq!((coarse.unit, &coarse.centres), (fine.unit, &fine.centres));
        assert!(
            (coarse.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12,
            "rounding of a sum in f64"
        );
    }

    #[test]
    fn what_does_not_hang_together_stays_as_it_is() {
        let frame: Vec<[f32; 3]> = (0..300).map(|k| [k as f32, (k % 7) as f32, (k % 5) as f32]).collect();
        let triangles: Vec<[u32; 3]> = (0..100).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let points: Vec<u32> = (0..300).collect();
        let soup = States::new(&[&frame], &points, triangles);
        assert!(merged(&soup, 10).is_none());
    }
}
