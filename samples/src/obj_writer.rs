//! Writes polygon meshes as Wavefront OBJ text.

use std::fmt::Write;

/// Polygons under one name: an `o` line and the `f` lines after it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FaceGroup {
    /// Name, without line breaks.
    pub name: String,
    /// Corners of each polygon: points, counted from 0.
    pub faces: Vec<Vec<u32>>,
}

/// The text of an OBJ file.
///
/// Guarantee: each coordinate is the shortest decimal that reads back as the same `f32`. Faces are not checked against
/// the points.
pub fn obj_bytes(points: &[[f32; 3]], groups: &[FaceGroup]) -> Vec<u8> {
    let mut text = String::new();
    for [x, y, z] in points {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    for group in groups {
        let _ = writeln!(text, "o {}", group.name);
        for face in &group.faces {
            text.push('f');
            for corner in face {
                let _ = write!(text, " {}", u64::from(*corner) + 1);
            }
            text.push('\n');
        }
    }
    text.into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_then_groups_with_numbers_from_one() {
        let group = |name: &str, faces| FaceGroup {
            name: name.to_owned(),
            faces,
        };
        let groups = [
            group("floor", vec![vec![0, 1, 2, 3]]),
            group("lid", vec![vec![2, 1, 0], vec![0, 2, 3]]),
        ];
        let points = [[0.0, -1.5, 0.1], [1e-7, 0.0, 2.0], [1.0, 1.0, 16_777_216.0], [0.0; 3]];
        let text = String::from_utf8(obj_bytes(&points, &groups)).expect("text");
        assert_eq!(
            text,
            "v 0 -1.5 0.1\nv 0.0000001 0 2\nv 1 1 16777216\nv 0 0 0\n\
             o floor\nf 1 2 3 4\no lid\nf 3 2 1\nf 1 3 4\n"
        );
    }
}
