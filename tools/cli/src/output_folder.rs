use crate::{exit_code::ExitCode, failure::Failure};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A folder into which a set of files is published at once.
///
/// Guarantee: files are collected out of sight, in the same file system, and moved in together by
/// [`OutputFolder::publish`]; without it nothing is left behind, folders made for the purpose included.
pub struct OutputFolder {
    folder: PathBuf,
    staging: Option<TempDir>,
    names: Vec<String>,
    made: Vec<PathBuf>,
}

impl OutputFolder {
    /// Makes the folder if it is missing and sees that files can be written there.
    pub fn prepare(folder: &Path) -> Result<Self, Failure> {
        let mut output = Self {
            folder: folder.to_owned(),
            staging: None,
            names: Vec::new(),
            made: Vec::new(),
        };
        let missing = folder
            .ancestors()
            .take_while(|path| !path.as_os_str().is_empty() && !path.exists());
        for path in missing.collect::<Vec<_>>().into_iter().rev() {
            std::fs::create_dir(path).map_err(|error| Failure::io("make the folder", path, &error))?;
            output.made.push(path.to_owned());
        }
        if !folder.is_dir() {
            let message = format!("{}: is not a folder; name a folder for the output", folder.display());
            return Err(Failure::at(ExitCode::CommandLine, folder, message));
        }
        let staging = tempfile::Builder::new().prefix(".restpose-").tempdir_in(folder);
        output.staging = Some(staging.map_err(|error| Failure::io("write into the folder", folder, &error))?);
        Ok(output)
    }

    /// Adds a file. A name given twice keeps the later contents.
    pub fn add(&mut self, name: &str, bytes: &[u8]) -> Result<(), Failure> {
        let path = self.claim(name);
        std::fs::write(&path, bytes).map_err(|error| Failure::io("write", &path, &error))
    }

    /// Where the caller is to write a file by itself, before publishing. No other user can reach that place.
    pub fn claim(&mut self, name: &str) -> PathBuf {
        if !self.names.iter().any(|known| known == name) {
            self.names.push(name.to_owned());
        }
        self.staged(name)
    }

    /// The bytes of a file added before.
    pub fn read(&self, name: &str) -> Result<Vec<u8>, Failure> {
        let path = self.staged(name);
        std::fs::read(&path).map_err(|error| Failure::io("read", &path, &error))
    }

    /// Moves all files into place, over older ones of the same name, and gives their paths in the order of adding.
    pub fn publish(mut self) -> Result<Vec<PathBuf>, Failure> {
        let mut placed: Vec<PathBuf> = Vec::new();
        for name in &self.names {
            let target = self.folder.join(name);
            if let Err(error) = std::fs::rename(self.staged(name), &target) {
                // All or nothing: what is already in place goes again. The failure to report is the first one.
                placed.iter().for_each(|path| drop(std::fs::remove_file(path)));
                return Err(Failure::io("write", &target, &error));
            }
            placed.push(target);
        }
        self.made.clear();
        Ok(placed)
    }

    fn staged(&self, name: &str) -> PathBuf {
        self.staging
            .as_ref()
            .map_or(self.folder.as_path(), TempDir::path)
            .join(name)
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        // Best effort: `remove_dir` refuses a folder in which somebody has put something meanwhile.
        self.staging.take();
        self.made.iter().rev().for_each(|path| drop(std::fs::remove_dir(path)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_files_are_in_place_and_nothing_else() {
        let root = tempfile::tempdir().expect("a temporary folder");
        let folder = root.path().join("a/b");
        let mut output = OutputFolder::prepare(&folder).expect("a writable folder");
        output.add("one", b"1").expect("room");
        output.add("one", b"2").expect("room");
        assert_eq!(output.read("one").expect("just written"), b"2");
        assert_eq!(output.publish().expect("same file system"), [folder.join("one")]);
        assert_eq!(std::fs::read_dir(&folder).expect("there").count(), 1);
    }

    #[test]
    fn without_publishing_nothing_stays() {
        let root = tempfile::tempdir().expect("a temporary folder");
        let mut output = OutputFolder::prepare(&root.path().join("a/b")).expect("a writable folder");
        output.add("one", b"1").expect("room");
        drop(output);
        assert_eq!(std::fs::read_dir(root.path()).expect("there").count(), 0);
    }

    #[test]
    fn a_file_in_the_way_is_an_error() {
        let root = tempfile::tempdir().expect("a temporary folder");
        let file = root.path().join("file");
        std::fs::write(&file, b"").expect("room");
        for folder in [file.clone(), file.join("below")] {
            assert!(OutputFolder::prepare(&folder).is_err());
        }
    }
}
