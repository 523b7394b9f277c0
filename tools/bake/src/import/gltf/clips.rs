use super::{
    accessor::{Accessors, Numbers},
    document::Document,
    keys, nodes, schema,
};
use crate::import::{Channel, ChannelTarget, Clip, Fault, fault_list::FaultList};
use restpose_formats::rows::Interpolation;
use std::collections::BTreeSet;

/// Reads all animations. `target_counts` has the morph targets of each mesh.
pub(super) fn read(
    document: &Document,
    accessors: &Accessors,
    target_counts: &[usize],
    faults: &mut FaultList,
) -> Vec<Clip> {
    let animations = document.animations.iter().enumerate();
    animations
        .map(|(number, row)| {
            let reader = ClipReader {
                document,
                accessors,
                target_counts,
                row,
                path: format!("/animations/{number}"),
            };
            Clip {
                name: row.name.clone().unwrap_or_default(),
                channels: reader.channels(faults),
            }
        })
        .collect()
}

struct ClipReader<'a> {
    document: &'a Document,
    accessors: &'a Accessors<'a>,
    target_counts: &'a [usize],
    row: &'a schema::Animation,
    path: String,
}

impl ClipReader<'_> {
    fn channels(&self, faults: &mut FaultList) -> Vec<Channel> {
        let mut out = Vec::new();
        let mut moved = BTreeSet::new();
        for (number, row) in self.row.channels.iter().enumerate() {
            let at = format!("{}/channels/{number}", self.path);
            let channel = self.channel(row, &at, faults);
            let Some(Some(channel)) = faults.keep(channel) else {
                continue;
            };
            if moved.insert((channel.node, channel.target)) {
                out.push(channel);
            } else {
                faults.warn(
                    format!("{at}/target"),
                    "an earlier channel moves the same property; this one is ignored",
                );
            }
        }
        out
    }

    /// The channel, or nothing where it moves nothing that an import keeps.
    fn channel(&self, row: &schema::Channel, at: &str, faults: &mut FaultList) -> Result<Option<Channel>, Fault> {
        let Some(node) = row.target.node else {
            faults.warn(format!("{at}/target"), "names no node; the channel is ignored");
            return Ok(None);
        };
        let Some(node_row) = self.document.nodes.get(node.0) else {
            let message = format!(
                "node {} does not exist; the file has {}",
                node.0,
                self.document.nodes.len()
            );
            return Err(Fault::error(format!("{at}/target/node"), message));
        };
        let target = match row.target.path.as_str() {
            "translation" => ChannelTarget::Translation,
            "rotation" => ChannelTarget::Rotation,
            "scale" => ChannelTarget::Scale,
            "weights" => ChannelTarget::Weights,
            other => {
                faults.warn(
                    format!("{at}/target/path"),
                    format!("{other:?} is not known; the channel is ignored"),
                );
                return Ok(None);
            }
        };
        let width = match target {
            ChannelTarget::Translation | ChannelTarget::Scale => 3,
            ChannelTarget::Rotation => 4,
            ChannelTarget::Weights => node_row
                .mesh
                .and_then(|mesh| self.target_counts.get(mesh.0))
                .copied()
                .unwrap_or(0),
            ChannelTarget::Frame => 1,
        };
        if width == 0 {
            faults.warn(
                format!("{at}/target"),
                "the node has no morph targets to weigh; the channel is ignored",
            );
            return Ok(None);
        }
        let Some(sampler) = self.row.samplers.get(row.sampler.0) else {
            let message = format!(
                "sampler {} does not exist; the animation has {}",
                row.sampler.0,
                self.row.samplers.len()
            );
            return Err(Fault::error(format!("{at}/sampler"), message));
        };
        let path = format!("{}/samplers/{}", self.path, row.sampler.0);
        let interpolation = match sampler.interpolation.as_deref() {
            None | Some("LINEAR") => Interpolation::Linear,
            Some("STEP") => Interpolation::Step,
            Some("CUBICSPLINE") => Interpolation::CubicSpline,
            Some(other) => {
                let message = format!("is {other:?}; expected LINEAR, STEP or CUBICSPLINE");
                return Err(Fault::error(format!("{path}/interpolation"), message));
            }
        };
        let input = format!("{path}/input");
        let times: Vec<f32> = self
            .accessors
            .floats::<1>(sampler.input, Numbers::Float, &input)?
            .into_iter()
            .map(|[time]| time)
            .collect();
        let values = self.values(sampler, target, &format!("{path}/output"), faults)?;
        let per_key = width.saturating_mul(interpolation.values_per_key() as usize);
        if Some(values.len()) != times.len().checked_mul(per_key) {
            return Err(Fault::error(
                format!("{path}/output"),
                format!(
                    "{} numbers for {} keys; expected {per_key} per key for {} of node {}",
                    values.len(),
                    times.len(),
                    row.target.path,
                    node.0
                ),
            ));
        }
        if times.is_empty() {
            faults.warn(at, "has no keys; the channel is ignored");
            return Ok(None);
        }
        if target == ChannelTarget::Rotation {
            check_rotations(&values, interpolation, &format!("{path}/output"), faults)?;
        }
        let keys = keys::clean(times, values, per_key, &input, faults)?;
        Ok(Some(Channel {
            node: node.0,
            target,
            interpolation,
            times: keys.times,
            values: keys.values,
        }))
    }

    fn values(
        &self,
        sampler: &schema::Sampler,
        target: ChannelTarget,
        at: &str,
        faults: &mut FaultList,
    ) -> Result<Vec<f32>, Fault> {
        let accessor = self.accessors.get(sampler.output, at)?;
        let is_integer = self.accessors.component(sampler.output, at)? != super::accessor::Component::F32;
        if is_integer && !accessor.normalized {
            faults.warn(
                at,
                "integer values should be marked as normalized; they are taken to be",
            );
        }
        Ok(match target {
            ChannelTarget::Translation | ChannelTarget::Scale => self
                .accessors
                .floats::<3>(sampler.output, Numbers::Normalized, at)?
                .into_flattened(),
            ChannelTarget::Rotation => self
                .accessors
                .floats::<4>(sampler.output, Numbers::Normalized, at)?
                .into_flattened(),
            ChannelTarget::Weights | ChannelTarget::Frame => self
                .accessors
                .floats::<1>(sampler.output, Numbers::Normalized, at)?
                .into_flattened(),
        })
    }
}

/// Every key must be a quaternion that `f32` arithmetic can normalise; tangents may be anything.
fn check_rotations(
    values: &[f32],
    interpolation: Interpolation,
    at: &str,
    faults: &mut FaultList,
) -> Result<(), Fault> {
    let quaternions = values.as_chunks::<4>().0;
    let (first, step) = if interpolation == Interpolation::CubicSpline {
        (1, 3)
    } else {
        (0, 1)
    };
    let mut farthest: Option<[f64; 4]> = None;
    let off_unit = |quaternion: &[f64; 4]| (quaternion.iter().map(|x| x * x).sum::<f64>() - 1.0).abs();
    for (key, quaternion) in quaternions.iter().skip(first).step_by(step).enumerate() {
        let length_squared: f32 = quaternion.iter().map(|x| x * x).sum();
        if !length_squared.is_normal() {
            return Err(Fault::error(
                at,
                format!("the rotation of key {key} is {quaternion:?}; expected a quaternion of length one"),
            ));
        }
        let wide = quaternion.map(f64::from);
        if farthest.is_none_or(|farthest| off_unit(&wide) > off_unit(&farthest)) {
            farthest = Some(wide);
        }
    }
    if let Some(farthest) = farthest {
        nodes::warn_unless_unit(farthest, at, faults);
    }
    Ok(())
}
