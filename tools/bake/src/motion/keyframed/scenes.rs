//! Real animations, where they are beside the workspace.

use super::KeyFrames;
use std::path::PathBuf;

pub(super) struct SceneKeys {
    positions: Vec<Vec<[f32; 3]>>,
    triangles: Vec<[u32; 3]>,
}

impl SceneKeys {
    /// None where the scene is not there.
    pub(super) fn load(name: &str) -> Option<Self> {
        let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
            .join("../../../shared/scenes")
            .join(name);
        let bytes = std::fs::read(folder.join(format!("{name}.pc2"))).ok()?;
        let text = std::fs::read_to_string(folder.join(format!("{name}.obj"))).ok()?;
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        let points = word(16) as usize;
        let floats: Vec<f32> = bytes[32..]
            .chunks_exact(4)
            .map(|x| f32::from_le_bytes(x.try_into().unwrap()))
            .collect();
        let positions = floats
            .as_chunks::<3>()
            .0
            .chunks_exact(points)
            .map(<[_]>::to_vec)
            .collect();
        let mut triangles = Vec::new();
        for line in text.lines().filter_map(|line| line.strip_prefix("f ")) {
            let corners: Vec<u32> = line
                .split_whitespace()
                .map(|corner| corner.split('/').next().unwrap().parse::<u32>().unwrap() - 1)
                .collect();
            triangles.extend((2..corners.len()).map(|k| [corners[0], corners[k - 1], corners[k]]));
        }
        Some(Self { positions, triangles })
    }

    pub(super) fn keys(&self) -> KeyFrames<'_> {
        KeyFrames {
            frames: self.positions.iter().map(Vec::as_slice).collect(),
            triangles: &self.triangles,
        }
    }
}
