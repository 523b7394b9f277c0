use crate::{JointLimits, JointLimitsError, JointRange};

fn refused(text: &str) -> JointLimitsError {
    JointLimits::parse("limits.toml", text).expect_err("a fault")
}

#[test]
fn a_file_gives_ranges_by_name() {
    let text = "# degrees\n[joints.\"Left.ForeArm\"]\nx = [-5, 140.5]\nz = [-20, -20]\n\n[joints.head]\ny = [0, 1]\n";
    let limits = JointLimits::parse("limits.toml", text).expect("sound limits");
    assert_eq!(limits.joints.len(), 2);
    let arm = JointRange {
        x: [-5.0, 140.5],
        y: [0.0; 2],
        z: [-20.0; 2],
    };
    assert_eq!(limits.joints["Left.ForeArm"], arm);
    assert_eq!(
        limits.listed(),
        "\"Left.ForeArm\" -5..140.5 0..0 -20..-20, \"head\" 0..0 0..1 0..0"
    );
}

#[test]
fn what_a_file_says_wrong_is_told_with_file_line_and_joint() {
    for (text, place, words) in [
        ("", "line 1", "missing field `joints`"),
        ("[joints.arm]\nx = [1, 2]\ny = [", "line 3", ""),
        ("[joints.arm]\nx = [1, 2]\nx = [1, 2]\n", "line 3", "duplicate key"),
        ("[joints.arm]\nw = [1, 2]\n", "line 2, joints.arm", "unknown field `w`"),
        ("[joints.arm]\nx = [1]\n", "line 2, joints.arm.x", "invalid length 1"),
        (
            "[joints.arm]\nx = [1, 2, 3]\n",
            "line 2, joints.arm.x",
            "invalid length 3",
        ),
        ("[joints.arm]\nx = 3\n", "line 2, joints.arm.x", "invalid type"),
        (
            "[joints.arm]\nx = [\"a\", 2]\n",
            "line 2, joints.arm.x[0]",
            "invalid type",
        ),
        ("[joints.arm]\n[limits]\n", "line 2", "unknown field `limits`"),
        ("{\"joints\": {}}", "line 1", ""),
    ] {
        let error = refused(text);
        let JointLimitsError::Syntax {
            file,
            place: found,
            message,
        } = &error
        else {
            panic!("{text:?}: {error}")
        };
        assert_eq!(file, "limits.toml");
        assert!(found.starts_with(place), "{text:?}: {found:?} {message}");
        assert!(message.contains(words) && !message.is_empty(), "{text:?}: {message}");
        assert!(!error.to_string().contains('\n'), "{text:?}: {error}");
    }
}

#[test]
fn angles_that_no_joint_has_are_refused() {
    for (value, found) in [
        ("[nan, 3]", f64::NAN),
        ("[0, inf]", f64::INFINITY),
        ("[-inf, 0]", f64::NEG_INFINITY),
        ("[-180.5, 0]", -180.5),
        ("[0, 181]", 181.0),
    ] {
        let error = refused(&format!("[joints.arm]\nz = {value}\n"));
        let JointLimitsError::Angle {
            joint,
            axis,
            found: angle,
            ..
        } = &error
        else {
            panic!("{value}: {error}")
        };
        assert_eq!(
            (joint.as_str(), *axis, angle.to_bits()),
            ("arm", "z", found.to_bits()),
            "{value}"
        );
    }
    let error = refused("[joints.arm]\nx = [0, 1]\ny = [5, 4.5]\n");
    assert_eq!(
        error.to_string(),
        "limits.toml: joint \"arm\": y = [5, 4.5] is reversed; expected the least angle first"
    );
}

#[test]
fn files_that_are_none_are_told() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("limits.toml");
    assert!(matches!(JointLimits::read(&file), Err(JointLimitsError::Read { .. })));
    assert!(matches!(
        JointLimits::read(folder.path()),
        Err(JointLimitsError::Read { .. })
    ));
    std::fs::write(&file, b"[joints.arm]\n# \xff\n").expect("room");
    let error = JointLimits::read(&file).expect_err("a fault");
    assert!(error.to_string().contains("line 2: not UTF-8"), "{error}");
    std::fs::write(&file, " ".repeat((1 << 20) + 1)).expect("room");
    assert!(matches!(
        JointLimits::read(&file),
        Err(JointLimitsError::TooLong { .. })
    ));
}
