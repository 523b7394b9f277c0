use restpose_bake::{CacheReport, PartReport, SegmentReport};

/// What a bake found of a part's vertex cache, a few lines for people; `None` for a part without one.
pub fn cache_lines(part: &PartReport) -> Option<String> {
    let cache = part.cache.as_ref()?;
    let mut lines = vec![format!(
        "{}: {} keys, {}; {:.2} bytes per vertex and key against 12",
        part.name,
        cache.keys,
        position(cache),
        cache.bytes_per_vertex_key
    )];
    lines.extend(cache.segments.iter().map(segment));
    if cache.segments.len() > 1 {
        lines.push(format!(
            "  {} segments against one: expected steps per ray {:.1} against {:.1}, {} bytes against {}",
            cache.segments.len(),
            cache.expected_cost,
            cache.expected_cost_one_segment,
            cache.bytes,
            cache.bytes_one_segment
        ));
    }
    Some(lines.join("\n"))
}

fn position(cache: &CacheReport) -> String {
    if cache.position_error > 0.0 {
        format!("positions within {:.2e} units", cache.position_error)
    } else {
        "exact positions".to_owned()
    }
}

fn segment(segment: &SegmentReport) -> String {
    let SegmentReport {
        key_first,
        key_last,
        clusters,
        rest_key,
        cut_intervals,
        clusters_with_key_boxes,
        key_box_bytes,
        decomposition,
        ..
    } = segment;
    let mut words = vec![format!("clusters {clusters}"), format!("rest key {rest_key}")];
    for (count, kind) in [
        (decomposition.static_components, "static"),
        (decomposition.rigid_components, "rigid"),
    ] {
        if count > 0 {
            words.push(format!("{kind} components {count}"));
        }
    }
    if let Some(step) = decomposition.steps.last() {
        words.push(format!("residual {:.2e} units", step.residual));
    }
    if decomposition.turned_clusters > 0 {
        words.push(format!("on principal axes {}", decomposition.turned_clusters));
    }
    if *key_box_bytes > 0 {
        words.push(format!(
            "with boxes at keys {clusters_with_key_boxes}, {key_box_bytes} bytes"
        ));
    }
    if *cut_intervals > 0 {
        words.push(format!("intervals without a tree {cut_intervals}"));
    }
    let tiers = &decomposition.tiers;
    let fallbacks = [
        (tiers.flat, "flat"),
        (tiers.limited, "limited"),
        (tiers.similarity, "similarity"),
        (tiers.rigid, "rigid"),
        (tiers.translation, "translation"),
    ];
    let fallbacks: Vec<String> = fallbacks
        .iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, tier)| format!("{count} {tier}"))
        .collect();
    if !fallbacks.is_empty() {
        words.push(format!("fits that are not plainly affine: {}", fallbacks.join(", ")));
    }
    format!("  keys {key_first} to {key_last}: {}", words.join(", "))
}
