use super::builders::all_bvh_builders;
use super::families::{FAMILIES, scattered};
use super::tree_sets::{bits, built};
use fastrand::Rng;
use restpose_builders::bvh::{BinnedBvh, BvhBuilder, HybridBvh};
use restpose_formats::geom::Aabb;
use restpose_runtime::build::{Bvh, BvhContent, BvhSettings};

/// Sets that every parallel path has work for, of even and of very uneven boxes.
fn large_sets() -> Vec<(&'static str, Vec<Aabb>)> {
    let mut uneven = scattered(150_000, 2, 1.0, 0.1);
    let mut random = Rng::with_seed(3);
    for bounds in &mut uneven {
        let scale = f32::exp2(-20.0 * random.f32());
        for side in bounds.min.iter_mut().chain(&mut bounds.max) {
            *side *= scale;
        }
    }
    vec![("even", scattered(150_000, 1, 100.0, 0.5)), ("uneven", uneven)]
}

fn built_on(threads: usize, builder: &mut (dyn BvhBuilder + Send), boxes: &[Aabb]) -> Bvh {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| built(builder, boxes, &BvhSettings::default()))
}

#[test]
fn trees_do_not_depend_on_threads() {
    let mut sets = large_sets();
    sets.extend(FAMILIES.map(|(name, family)| (name, family(3_000, 3))));
    for entry in all_bvh_builders() {
        for (name, boxes) in &sets {
            let single = bits(&built_on(1, &mut *(entry.make)(), boxes));
            for threads in [2, 7] {
                let many = bits(&built_on(threads, &mut *(entry.make)(), boxes));
                assert!(many == single, "{}, {name}, {threads} threads", entry.name);
            }
        }
    }
}

#[test]
fn a_reused_builder_gives_the_bytes_of_a_fresh_one() {
    let mut sets: Vec<_> = FAMILIES
        .iter()
        .flat_map(|(name, family)| [900, 3, 64, 1].map(|n| (*name, family(n, 6))))
        .collect();
    for (index, set) in large_sets().into_iter().enumerate() {
        sets.insert(17 * (index + 1), set);
    }
    for entry in all_bvh_builders() {
        let mut builder = (entry.make)();
        for (name, boxes) in &sets {
            let [used, fresh] = [&mut builder, &mut (entry.make)()]
                .map(|builder| bits(&built(&mut **builder, boxes, &BvhSettings::default())));
            assert!(used == fresh, "{}, {name}, {} boxes", entry.name, boxes.len());
        }
    }
}

#[test]
fn hybrid_trees_are_binned_trees() {
    let mut sets = large_sets();
    sets.extend(FAMILIES.map(|(name, family)| (name, family(2_000, 3))));
    for (name, boxes) in &sets {
        for settings in [
            BvhSettings::default(),
            BvhSettings {
                traversal_cost: 30.0,
                intersection_cost: 1.0,
            },
        ] {
            let binned = bits(&built(&mut BinnedBvh::default(), boxes, &settings));
            let hybrid = bits(&built(&mut HybridBvh::default(), boxes, &settings));
            assert!(hybrid == binned, "{name}, {settings:?}");
        }
    }
}

#[test]
fn shuffled_boxes_give_the_same_nodes() {
    for entry in all_bvh_builders().iter().filter(|entry| entry.order_free) {
        for (name, family) in FAMILIES {
            for n in [10, 100, 4_000] {
                let boxes = family(n, 11);
                let mut shuffled = boxes.clone();
                Rng::with_seed(12).shuffle(&mut shuffled);
                let [given, other] =
                    [&boxes, &shuffled].map(|boxes| built(&mut *(entry.make)(), boxes, &BvhSettings::default()));
                assert!(given.nodes == other.nodes, "{}, {name}, {n} boxes", entry.name);
            }
        }
    }
}

#[test]
fn leaves_list_references_ascending() {
    for entry in all_bvh_builders().iter().filter(|entry| entry.order_free) {
        for (name, family) in FAMILIES {
            let tree = built(&mut *(entry.make)(), &family(500, 4), &BvhSettings::default());
            for node in &tree.nodes {
                if let BvhContent::Leaf { first, count } = node.content() {
                    let references = &tree.references[first as usize..][..count as usize];
                    assert!(references.is_sorted(), "{}, {name}: {references:?}", entry.name);
                }
            }
        }
    }
}
