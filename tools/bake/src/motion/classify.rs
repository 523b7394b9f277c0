use super::Moving;
use crate::{
    BakeError, BakeSettings,
    import::{Animation, Influence, Part},
};
use restpose_formats::rows::MotionClass;

/// A part's class, and why.
pub(crate) struct Classified {
    pub class: MotionClass,
    pub reason: String,
    /// Whether its morph targets are kept; otherwise they are folded into the rest pose at the weights without a clip.
    pub morphs: bool,
    /// What the user wants of a part with a vertex cache, whose own class its clusters decide.
    pub asked: Option<MotionClass>,
}

impl Classified {
    /// Settles the class of a part with a vertex cache; `reason` is told whether it was asked for.
    ///
    /// # Errors
    /// [`BakeError::Class`] where the motion is not what was asked for: every motion can be baked as keyframed or free, only
    /// a rigid one as rigid.
    pub(crate) fn decide(
        &mut self,
        name: &str,
        found: MotionClass,
        reason: impl Fn(bool) -> String,
    ) -> Result<(), BakeError> {
        let asked = self.asked.filter(|asked| *asked != found);
        self.reason = reason(asked.is_some());
        self.class = asked.unwrap_or(found);
        if asked == Some(MotionClass::Rigid) {
            return Err(BakeError::Class {
                name: name.to_owned(),
                asked: MotionClass::Rigid,
                found,
                reason: self.reason.clone(),
            });
        }
        Ok(())
    }
}

/// Classes every part (DESIGN: model only what a scene requires), then applies the user's overrides.
pub(crate) fn classify(
    animation: &Animation,
    moving: &Moving,
    settings: &BakeSettings,
) -> Result<Vec<Classified>, BakeError> {
    let mut classes: Vec<Classified> = animation
        .parts
        .iter()
        .map(|part| class_of(animation, moving, part))
        .collect();
    for (name, asked) in &settings.class_overrides {
        let mut known = false;
        for (part, found) in animation
            .parts
            .iter()
            .zip(&mut classes)
            .filter(|(part, _)| part.name == *name)
        {
            known = true;
            // Judged against what the source says, not against an earlier wish.
            *found = class_of(animation, moving, part);
            apply(part, found, *asked)?;
        }
        if !known {
            let known = animation.parts.iter().map(|part| part.name.clone()).collect();
            return Err(BakeError::UnknownPart {
                name: name.clone(),
                known,
            });
        }
    }
    Ok(classes)
}

fn class_of(animation: &Animation, moving: &Moving, part: &Part) -> Classified {
    let morphs = moving.morphs[part.node];
    if let Some(cache) = part.cache {
        let (class, reason) = if moves_in(animation, part, cache) {
            (MotionClass::Keyframed, "its vertex cache moves it")
        } else {
            (MotionClass::Static, "no vertex moves in its vertex cache")
        };
        return Classified {
            class,
            reason: reason.to_owned(),
            morphs: false,
            asked: None,
        };
    }
    let (class, reason) = if let Some(skin) = part.skin {
        let (several, across) = skinned_counts(animation, part);
        let joints = animation.skins[skin].joints.len();
        if morphs {
            (
                MotionClass::Skinned,
                format!("{joints} joints and animated morph targets"),
            )
        } else if several + across > 0 {
            let reason =
                format!("{joints} joints; {several} vertices blend several, {across} triangles reach across joints");
            (MotionClass::Skinned, reason)
        } else {
            (
                MotionClass::Rigid,
                format!("{joints} joints, each triangle follows one"),
            )
        }
    } else if morphs {
        (MotionClass::Skinned, "animated morph targets on one node".to_owned())
    } else if moving.nodes[part.node] {
        (MotionClass::Rigid, "its node is animated".to_owned())
    } else {
        (MotionClass::Static, "no clip moves its node".to_owned())
    };
    Classified {
        class,
        reason,
        morphs,
        asked: None,
    }
}

/// Whether some vertex of the part is not where it was in the first key.
fn moves_in(animation: &Animation, part: &Part, cache: usize) -> bool {
    let cache = &animation.caches[cache];
    let points: Vec<usize> = animation.meshes[part.mesh]
        .primitives
        .iter()
        .flat_map(|primitive| &primitive.points)
        .map(|point| *point as usize)
        .collect();
    let first = cache.frame(0);
    (1..cache.frame_count()).any(|key| {
        let frame = cache.frame(key);
        points.iter().any(|point| frame[*point] != first[*point])
    })
}

/// Vertices that several joints move, and triangles whose corners follow different single joints.
fn skinned_counts(animation: &Animation, part: &Part) -> (usize, usize) {
    let mut counts = (0, 0);
    for primitive in &animation.meshes[part.mesh].primitives {
        counts.0 += primitive
            .influences
            .iter()
            .filter(|influences| influences.len() > 1)
            .count();
        let joint = |corner: u32| {
            primitive.influences[corner as usize]
                .iter()
                .map(|Influence { joint, .. }| joint)
        };
        counts.1 += primitive
            .triangles
            .iter()
            .filter(|[a, b, c]| !(joint(*a).eq(joint(*b)) && joint(*b).eq(joint(*c))))
            .count();
    }
    counts
}

fn apply(part: &Part, found: &mut Classified, asked: MotionClass) -> Result<(), BakeError> {
    match (found.class, asked) {
        (MotionClass::Keyframed, MotionClass::Keyframed) => found.asked = Some(asked),
        (found, asked) if found == asked => {}
        (_, MotionClass::Static) => {
            *found = Classified {
                class: asked,
                reason: "asked for: frozen without clips".to_owned(),
                morphs: false,
                asked: None,
            };
        }
        (MotionClass::Keyframed, MotionClass::Rigid | MotionClass::Free) => found.asked = Some(asked),
        (MotionClass::Static, MotionClass::Rigid) => {
            found.class = asked;
            found.reason = "asked for: keeps a bone".to_owned();
        }
        _ => {
            let (name, reason) = (part.name.clone(), found.reason.clone());
            return Err(BakeError::Class {
                name,
                asked,
                found: found.class,
                reason,
            });
        }
    }
    Ok(())
}
