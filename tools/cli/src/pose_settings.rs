use crate::{
    args::{BoundsKind, PoseArgs, PoseSpaceKind},
    exit_code::ExitCode,
    failure::Failure,
};
use restpose_bake::{BakeSettings, ClipSelection, JointLimits, LimitSettings, PoseSpace};
use restpose_formats::Bounds;

/// `settings` with what the options say about poses; reads the joint limits.
///
/// # Errors
/// Options that do not go together, or a joint-limit file that is refused.
pub fn with_poses(settings: BakeSettings, args: &PoseArgs) -> Result<BakeSettings, Failure> {
    check(args)?;
    let pose_space = match &args.pose_space {
        PoseSpaceKind::Arbitrary => PoseSpace::Arbitrary,
        PoseSpaceKind::Limits => PoseSpace::Limits(limits(args)?),
        PoseSpaceKind::Clips => PoseSpace::Clips,
        PoseSpaceKind::Clip(name) => PoseSpace::Clip(name.clone()),
    };
    Ok(BakeSettings {
        clips: if args.clips.is_empty() {
            ClipSelection::All
        } else {
            ClipSelection::Named(args.clips.clone())
        },
        pose_space,
        pose_samples: args.pose_samples,
        seed: args.seed.unwrap_or(settings.seed),
        sample_step_seconds: args.sample_step.unwrap_or(settings.sample_step_seconds),
        bounds: match args.bounds {
            BoundsKind::Sampled => Bounds::Sampled,
            BoundsKind::Envelope => Bounds::Envelope,
        },
        envelopes: args.envelopes.unwrap_or(settings.envelopes),
        ..settings
    })
}

/// Refuses options that would do nothing beside the others.
fn check(args: &PoseArgs) -> Result<(), Failure> {
    let limits = args.pose_space == PoseSpaceKind::Limits;
    let random = limits || args.pose_space == PoseSpaceKind::Arbitrary;
    let envelope = args.bounds == BoundsKind::Envelope;
    for (given, fits, option, needs) in [
        (
            args.joint_limits.is_some(),
            limits,
            "--joint-limits",
            "--pose-space limits",
        ),
        (
            args.limit_slack.is_some(),
            limits,
            "--limit-slack",
            "--pose-space limits",
        ),
        (
            args.pose_samples.is_some(),
            random,
            "--pose-samples",
            "--pose-space limits or --pose-space arbitrary",
        ),
        (
            args.seed.is_some(),
            random,
            "--seed",
            "--pose-space limits or --pose-space arbitrary",
        ),
        (args.envelopes.is_some(), envelope, "--envelopes", "--bounds envelope"),
    ] {
        if given && !fits {
            return Err(Failure::new(
                ExitCode::CommandLine,
                format!("{option} does nothing without {needs}: give both or neither"),
            ));
        }
    }
    Ok(())
}

fn limits(args: &PoseArgs) -> Result<LimitSettings, Failure> {
    let default = LimitSettings::default();
    let joints = match &args.joint_limits {
        Some(path) => JointLimits::read(path).map_err(|error| Failure::joint_limits(&error))?,
        None => JointLimits::default(),
    };
    Ok(LimitSettings {
        joints,
        slack_deg: args.limit_slack.unwrap_or(default.slack_deg),
    })
}
