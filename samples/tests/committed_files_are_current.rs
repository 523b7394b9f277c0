//! The files in `samples/scenes` are those that the generator writes, byte for byte.

use restpose_samples::scene_files;
use std::path::Path;

#[test]
fn committed_files_are_current() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let files = scene_files().expect("the scenes are written");
    for file in &files {
        let path = folder.join(file.name);
        let committed =
            std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}; run generate", path.display()));
        assert!(
            committed == file.bytes,
            "{} differs from what the generator writes; run generate and look at the change",
            file.name
        );
        let limit = match file.name.rsplit_once('.') {
            Some((_, "pc2")) => 1_500_000,
            Some((_, "obj")) => 500_000,
            _ => 150_000,
        };
        assert!(file.bytes.len() < limit, "{} has grown large", file.name);
    }
    let listed = std::fs::read_dir(&folder).expect("the folder is there");
    assert_eq!(listed.count(), files.len(), "a file that no generator writes");
}
