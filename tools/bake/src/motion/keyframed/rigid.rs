//! Components that one map per key explains: static and rigid ones.

use super::{
    KeyFrames,
    components::{Component, Components},
    fit::{FitModel, Map, Moments},
    settings::DecomposeSettings,
};
use glam::{DAffine3, DMat3, DVec3};
use rayon::prelude::*;
use restpose_formats::geom::{Affine, round::UNIT_ROUNDOFF};
use restpose_runtime::invert_frame;

/// Roundings of a coordinate to `f32`, relative to the largest coordinate in sight, that a rigid component may be off
/// by without any tolerance: three products and sums in the source that moved it (γ₄ per axis, over up to √3 of the
/// coordinate), the stored point, the source's own rest point, and the twelve entries of the map, each rounded once.
const SOURCE_ROUNDINGS: f64 = 16.0;

/// A rigid cluster: the components that share its motion.
pub(super) struct RigidCluster {
    /// Part space from local space, per key.
    pub from_local: Vec<Affine>,
    /// Key in which its map was taken to be a translation.
    reference: usize,
    /// Indices of components.
    pub components: Vec<u32>,
}

/// Which components need no clustering.
#[derive(Default)]
pub(super) struct Rigidity {
    /// Components that do not move at all.
    pub still: Vec<u32>,
    /// Largest first.
    pub rigid: Vec<RigidCluster>,
    /// The others.
    pub coherent: Vec<u32>,
}

/// Sorts the components. At most `max_clusters` are used, one of them left for what remains to be clustered; rigid ones
/// take at most half of those while anything remains, the components with the largest surface first.
pub(super) fn sort_components(keys: &KeyFrames, mesh: &Components, settings: &DecomposeSettings) -> Rigidity {
    let mut out = Rigidity::default();
    let moves: Vec<bool> = mesh
        .components
        .par_iter()
        .map(|component| moves(keys, component))
        .collect();
    let moving: Vec<u32> = (0..moves.len() as u32).filter(|index| moves[*index as usize]).collect();
    if moving.is_empty() || settings.max_clusters > 1 {
        out.still = (0..moves.len() as u32)
            .filter(|index| !moves[*index as usize])
            .collect();
    } else {
        out.coherent = (0..moves.len() as u32)
            .filter(|index| !moves[*index as usize])
            .collect();
    }
    let tracks: Vec<Option<(usize, Vec<Affine>)>> = moving
        .par_iter()
        .map(|index| simplest_track(keys, &mesh.components[*index as usize], settings))
        .collect();
    let mut own: Vec<(f64, u32, usize, Vec<Affine>)> = Vec::new();
    for (index, track) in moving.iter().zip(tracks) {
        match track {
            Some((reference, track)) => {
                let area = area(keys, mesh, *index, reference);
                own.push((area, *index, reference, track));
            }
            None => out.coherent.push(*index),
        }
    }
    own.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let free = settings.max_clusters.max(1) - usize::from(!out.still.is_empty());
    for (_, index, reference, from_local) in own {
        let component = &mesh.components[index as usize];
        let shared = out
            .rigid
            .iter()
            .position(|cluster| explains(keys, component, cluster.reference, &cluster.from_local, settings));
        match shared {
            Some(cluster) => out.rigid[cluster].components.push(index),
            None if out.rigid.len() < free => out.rigid.push(RigidCluster {
                from_local,
                reference,
                components: vec![index],
            }),
            None => out.coherent.push(index),
        }
    }
    if !out.coherent.is_empty() {
        for cluster in out.rigid.drain(out.rigid.len().min(free / 2)..) {
            out.coherent.extend(cluster.components);
        }
        out.coherent.sort_unstable();
    }
    out
}

fn moves(keys: &KeyFrames, component: &Component) -> bool {
    keys.frames.split_first().is_some_and(|(first, others)| {
        let still = |frame: &&[[f32; 3]]| {
            component
                .points
                .iter()
                .all(|point| frame[*point as usize] == first[*point as usize])
        };
        !others.iter().all(still)
    })
}

fn area(keys: &KeyFrames, mesh: &Components, component: u32, key: usize) -> f64 {
    let area = |triangle: &u32| {
        let [a, b, c] = mesh.triangles[*triangle as usize].map(|point| position(keys, key, point));
        (b - a).cross(c - a).length()
    };
    mesh.components[component as usize].triangles.iter().map(area).sum()
}

fn position(keys: &KeyFrames, key: usize, point: u32) -> DVec3 {
    DVec3::from_array(keys.frames[key][point as usize].map(f64::from))
}

/// The maps of a component by the simplest model that explains it, with the key they are relative to.
fn simplest_track(
    keys: &KeyFrames,
    component: &Component,
    settings: &DecomposeSettings,
) -> Option<(usize, Vec<Affine>)> {
    let size = |key: usize| {
        let (low, high) = bounds(keys, component, key);
        (high - low).length()
    };
    // Where it is largest its points say most about the map.
    let reference = (0..keys.frames.len()).max_by(|a, b| size(*a).total_cmp(&size(*b)).then(b.cmp(a)))?;
    [FitModel::Rigid, FitModel::Similarity, FitModel::Affine]
        .into_iter()
        .find_map(|model| track(keys, component, reference, model, settings))
        .map(|track| (reference, track))
}

fn bounds(keys: &KeyFrames, component: &Component, key: usize) -> (DVec3, DVec3) {
    component
        .points
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), point| {
            let v = position(keys, key, *point);
            (low.min(v), high.max(v))
        })
}

/// Fits key after key and gives up at the first that is off by more than allowed.
fn track(
    keys: &KeyFrames,
    component: &Component,
    reference: usize,
    model: FitModel,
    settings: &DecomposeSettings,
) -> Option<Vec<Affine>> {
    let (low, high) = bounds(keys, component, reference);
    let unit = (high - low).max_element();
    let unit = if unit > 0.0 { unit } else { 1.0 };
    let origin = (low * 0.5 + high * 0.5).as_vec3().as_dvec3();
    let mut track = Vec::with_capacity(keys.frames.len());
    let mut previous = DMat3::IDENTITY;
    for key in 0..keys.frames.len() {
        let pivot = position(keys, key, *component.points.first()?);
        let mut moments = Moments::about(DVec3::ZERO, DVec3::ZERO);
        for point in &component.points {
            let local = (position(keys, reference, *point) - origin) / unit;
            moments.add(1.0, local, (position(keys, key, *point) - pivot) / unit);
        }
        let (map, _) = moments.fit(model, previous);
        previous = map.linear;
        let from_local = rounded(&Map {
            linear: map.linear,
            offset: pivot + map.offset * unit,
        });
        if !explains_key(keys, component, origin, reference, key, &from_local, settings) {
            return None;
        }
        track.push(from_local);
    }
    Some(track)
}

/// The map's numbers in a file.
pub(super) fn rounded(map: &Map) -> Affine {
    let column = |v: DVec3| v.to_array().map(|x| x as f32);
    Affine {
        columns: [
            column(map.linear.x_axis),
            column(map.linear.y_axis),
            column(map.linear.z_axis),
            column(map.offset),
        ],
    }
}

/// Whether a map takes a component from where it is in the reference key, seen from `origin`, to where it is in a key.
fn explains_key(
    keys: &KeyFrames,
    component: &Component,
    origin: DVec3,
    reference: usize,
    key: usize,
    from_local: &Affine,
    settings: &DecomposeSettings,
) -> bool {
    if invert_frame(from_local).is_none() {
        return false;
    }
    let map = widened(from_local);
    component.points.iter().all(|point| {
        let local = position(keys, reference, *point) - origin;
        off_by(
            &map,
            local,
            position(keys, reference, *point),
            position(keys, key, *point),
        ) <= settings.rigid_tolerance
    })
}

/// Whether another component's maps explain this one as well.
fn explains(
    keys: &KeyFrames,
    component: &Component,
    reference: usize,
    from_local: &[Affine],
    settings: &DecomposeSettings,
) -> bool {
    let to_local = widened(&from_local[reference]).inverse();
    (0..keys.frames.len()).all(|key| {
        let map = widened(&from_local[key]);
        component.points.iter().all(|point| {
            let rest = position(keys, reference, *point);
            off_by(&map, to_local.transform_point3(rest), rest, position(keys, key, *point)) <= settings.rigid_tolerance
        })
    })
}

/// Distance of a mapped point from where it should be, less what rounding explains; scene units.
fn off_by(map: &DAffine3, local: DVec3, rest: DVec3, expected: DVec3) -> f64 {
    let m = map.matrix3;
    let reach = m.x_axis.abs() * local.x.abs() + m.y_axis.abs() * local.y.abs() + m.z_axis.abs() * local.z.abs();
    let stretch = m.x_axis.abs().max(m.y_axis.abs()).max(m.z_axis.abs()).max_element();
    let coordinates =
        (reach + map.translation.abs()).max(expected.abs()).max_element() + stretch * rest.abs().max_element();
    let explained = SOURCE_ROUNDINGS * UNIT_ROUNDOFF * coordinates;
    (map.transform_point3(local) - expected).length() - explained
}

fn widened(map: &Affine) -> DAffine3 {
    let [x, y, z, w] = map.columns.map(|column| DVec3::from_array(column.map(f64::from)));
    DAffine3::from_cols(x, y, z, w)
}
