//! The guarantee of [`Animation`], spelt out.

use restpose_bake::import::{
    Animation, Channel, ChannelTarget, ImportError, Imported, Local, MAX_MAGNITUDE, Part, Primitive, Severity,
};

/// Ends with typed errors, at least one of them, or with an animation that keeps its guarantee.
pub fn check(result: Result<Imported, ImportError>, what: &str) {
    match result {
        Ok(imported) => {
            assert!(
                imported.faults.iter().all(|fault| fault.severity == Severity::Warning),
                "{what}"
            );
            keeps_guarantee(&imported.animation).unwrap_or_else(|broken| panic!("{what}: {broken}"));
        }
        Err(ImportError::Faults { faults, .. }) => {
            assert!(faults.iter().any(|fault| fault.severity == Severity::Error), "{what}");
        }
        Err(_) => {}
    }
}

/// The guarantee of [`Animation`], spelt out.
pub fn keeps_guarantee(animation: &Animation) -> Result<(), String> {
    let expect = |holds: bool, what: &str| if holds { Ok(()) } else { Err(what.to_owned()) };
    let usable = |values: &[f32]| values.iter().all(|value| value.abs() <= MAX_MAGNITUDE);
    let (nodes, meshes, skins) = (&animation.nodes, &animation.meshes, &animation.skins);
    for (number, node) in nodes.iter().enumerate() {
        match node.local {
            Local::Trs {
                translation,
                rotation,
                scale,
            } => {
                expect(usable(&translation) && usable(&scale), "translation or scale")?;
                let length: f32 = rotation.iter().map(|x| x * x).sum();
                // Normalised in f64, then rounded: each square is off by 2⁻²³ of itself at most.
                expect((length - 1.0).abs() < 1e-6, "rotation")?;
            }
            Local::Matrix(columns) => expect(usable(columns.as_flattened()), "matrix")?,
        }
        expect(usable(&node.weights), "node weights")?;
        let mut above = node.parent;
        for _ in 0..nodes.len() {
            expect(
                above.is_none_or(|parent| parent < nodes.len() && parent != number),
                "forest",
            )?;
            above = above.and_then(|parent| nodes[parent].parent);
        }
        expect(above.is_none(), "forest")?;
    }
    for primitive in meshes.iter().flat_map(|mesh| &mesh.primitives) {
        let count = primitive.positions.len();
        expect(usable(primitive.positions.as_flattened()), "positions")?;
        expect(!primitive.triangles.is_empty(), "triangles")?;
        expect(
            primitive
                .triangles
                .as_flattened()
                .iter()
                .all(|corner| (*corner as usize) < count),
            "corners",
        )?;
        expect(
            primitive.influences.is_empty() || primitive.influences.len() == count,
            "influences",
        )?;
        for list in &primitive.influences {
            expect(
                !list.is_empty() && list.iter().all(|influence| influence.weight > 0.0),
                "weights",
            )?;
            expect(
                list.windows(2).all(|pair| pair[0].joint < pair[1].joint),
                "joints are distinct",
            )?;
        }
        for target in &primitive.morph_targets {
            expect(target.len() == count && usable(target.as_flattened()), "morph target")?;
        }
        expect(primitive.points.is_empty() || primitive.points.len() == count, "points")?;
    }
    for mesh in meshes {
        let same = mesh
            .primitives
            .iter()
            .all(|primitive| primitive.morph_targets.len() == mesh.morph_target_count);
        expect(same, "morph target count")?;
    }
    for skin in skins {
        expect(
            !skin.joints.is_empty() && skin.joints.iter().all(|joint| *joint < nodes.len()),
            "joints",
        )?;
        expect(skin.inverse_bind.len() == skin.joints.len(), "inverse bind count")?;
        expect(usable(skin.inverse_bind.as_flattened().as_flattened()), "inverse bind")?;
    }
    for channel in animation.clips.iter().flat_map(|clip| &clip.channels) {
        channel_keeps_guarantee(animation, channel)?;
    }
    for cache in &animation.caches {
        let is_whole = cache.point_count > 0 && cache.positions.len() % cache.point_count == 0;
        expect(is_whole && cache.frame_count() > 1, "frames")?;
        expect(usable(cache.positions.as_flattened()), "frame positions")?;
    }
    expect(!animation.parts.is_empty(), "parts")?;
    for part in &animation.parts {
        expect(part.node < nodes.len() && part.mesh < meshes.len(), "part")?;
        expect(
            nodes[part.node].weights.len() == meshes[part.mesh].morph_target_count,
            "default weights",
        )?;
        for primitive in &meshes[part.mesh].primitives {
            follows_cache(animation, part, primitive)?;
        }
        let Some(skin) = part.skin else { continue };
        expect(skin < skins.len(), "skin")?;
        for primitive in &meshes[part.mesh].primitives {
            expect(
                primitive.influences.len() == primitive.positions.len(),
                "influences under a skin",
            )?;
            let joints = primitive.influences.iter().flatten().map(|influence| influence.joint);
            expect(joints.max() < Some(skins[skin].joints.len()), "joint of a skin")?;
        }
    }
    Ok(())
}

/// A part's vertices are the first frame of its cache, and nothing else moves them.
fn follows_cache(animation: &Animation, part: &Part, primitive: &Primitive) -> Result<(), String> {
    let expect = |holds: bool, what: &str| if holds { Ok(()) } else { Err(what.to_owned()) };
    let Some(cache) = part.cache else {
        return expect(primitive.points.is_empty(), "points without a cache");
    };
    let cache = animation.caches.get(cache).ok_or("cache")?;
    expect(
        part.skin.is_none() && primitive.morph_targets.is_empty(),
        "a cache and a skin",
    )?;
    expect(
        primitive.points.windows(2).all(|pair| pair[0] < pair[1]),
        "ascending points",
    )?;
    let points = primitive.points.iter().map(|point| cache.frame(0).get(*point as usize));
    expect(
        points.eq(primitive.positions.iter().map(Some)),
        "vertices are those of the first frame",
    )
}

fn channel_keeps_guarantee(animation: &Animation, channel: &Channel) -> Result<(), String> {
    let expect = |holds: bool, what: &str| if holds { Ok(()) } else { Err(what.to_owned()) };
    let width = if channel.target == ChannelTarget::Frame {
        let cache = animation.caches.get(channel.node).ok_or("channel cache")?;
        let last = (cache.frame_count() - 1) as f32;
        expect(
            channel.values.iter().all(|frame| (0.0..=last).contains(frame)),
            "frame numbers",
        )?;
        1
    } else {
        let node = animation.nodes.get(channel.node).ok_or("channel node")?;
        expect(
            channel.target == ChannelTarget::Weights || matches!(node.local, Local::Trs { .. }),
            "an animated node has no matrix",
        )?;
        match channel.target {
            ChannelTarget::Translation | ChannelTarget::Scale => 3,
            ChannelTarget::Rotation => 4,
            _ => node.weights.len(),
        }
    };
    let count = channel.times.len() * channel.interpolation.values_per_key() as usize * width;
    expect(!channel.times.is_empty() && channel.values.len() == count, "values")?;
    expect(channel.times.windows(2).all(|pair| pair[0] < pair[1]), "key times")?;
    expect(
        channel
            .times
            .iter()
            .chain(&channel.values)
            .all(|value| value.abs() <= MAX_MAGNITUDE),
        "key numbers",
    )
}
