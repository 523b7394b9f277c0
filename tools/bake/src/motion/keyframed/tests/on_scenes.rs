use super::super::{DecomposeSettings, decompose_keys, scenes::SceneKeys};
use crate::NoProgress;

/// Prints what `measure` will plot, on the scenes beside the workspace.
#[test]
#[ignore = "measures; run with --release --nocapture"]
#[expect(clippy::print_stdout, reason = "a measurement's output")]
fn measure() {
    for name in ["chicken", "cow", "horse", "elephant"] {
        let Some(scene) = SceneKeys::load(name) else { continue };
        let keys = scene.keys();
        let begin = std::time::Instant::now();
        let out = decompose_keys(&keys, &DecomposeSettings::default(), &NoProgress);
        let total = begin.elapsed();
        let r = &out.report;
        println!(
            "{name}: {} clusters in {total:?}, {:?}, rest {} of {}, ideal {:.4}, 1 cluster {:.2}, least squares {:.3}, final {:.3}; static {}/{} rigid {}/{}/{} turned {} {:?}",
            out.clusters.len(),
            r.stop,
            r.rest_key,
            r.rest_candidates,
            r.ideal_cost,
            r.steps[0].cost / r.ideal_cost,
            r.least_squares_cost / r.ideal_cost,
            r.cost / r.ideal_cost,
            r.static_components,
            r.static_triangles,
            r.rigid_components,
            r.rigid_triangles,
            r.rigid_clusters,
            r.turned_clusters,
            r.tiers,
        );
        println!("   {:?}", r.seconds);
    }
}
