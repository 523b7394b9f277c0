//! Where an asset's bytes live, and the one place that lets a view borrow from its owner.
#![expect(
    unsafe_code,
    reason = "mapping a file, and a view that lives beside the bytes it borrows"
)]

use crate::owned_bytes::OwnedBytes;
use memmap2::Mmap;
use restpose_formats::{FormatError, MAGIC, ModelView, read};
use std::{
    fs::File,
    io::{self, Read},
    path::Path,
};

/// Bytes that stay where they are and do not change while this lives.
enum Storage {
    Mapped(Mmap),
    Owned(OwnedBytes),
}

impl Storage {
    fn bytes(&self) -> &[u8] {
        match self {
            Self::Mapped(map) => map,
            Self::Owned(bytes) => bytes.as_slice(),
        }
    }
}

/// What makes a view of a file's bytes.
pub(crate) type ReadModel = for<'a> fn(&'a [u8]) -> Result<ModelView<'a>, FormatError>;

/// A file that was read and the memory that it lies in.
pub(crate) struct StoredModel {
    /// Borrows from `storage`. Never handed out with this lifetime: see [`StoredModel::view`].
    view: ModelView<'static>,
    _storage: Storage,
}

impl StoredModel {
    fn new(storage: Storage, read: ReadModel) -> Result<Self, FormatError> {
        let bytes: *const [u8] = storage.bytes();
        // SAFETY: `bytes` points into `storage`: into mapped pages or a heap block, whose addresses do not change when
        // `storage` moves. `storage` is kept beside the view, is never changed or handed out, and is dropped with it;
        // dropping a view reads nothing through it. `view()` shortens the lifetime to that of `self`, so no borrow
        // outlives the bytes. For a mapping the caller of `map` has promised that nobody changes the file.
        let view = read(unsafe { &*bytes })?;
        Ok(Self {
            view,
            _storage: storage,
        })
    }

    pub(crate) fn view(&self) -> &ModelView<'_> {
        &self.view
    }

    /// Copies `bytes` to aligned memory.
    pub(crate) fn copy(bytes: &[u8]) -> Result<Self, FormatError> {
        Self::new(Storage::Owned(OwnedBytes::copy_of(bytes)), read)
    }

    /// Reads a file into aligned memory.
    pub(crate) fn open(path: &Path) -> io::Result<Result<Self, FormatError>> {
        let mut file = File::open(path)?;
        let len = usize::try_from(file.metadata()?.len()).map_err(|_| io::ErrorKind::FileTooLarge)?;
        // A file of another kind may be of any size: it is told by its first bytes, before memory is asked for.
        let mut magic = OwnedBytes::try_zeroed(len.min(MAGIC.len()))?;
        file.read_exact(magic.as_mut_slice())?;
        if magic.as_slice() != MAGIC {
            return Ok(Self::new(Storage::Owned(magic), read));
        }
        let mut bytes = OwnedBytes::try_zeroed(len)?;
        let (begin, rest) = bytes.as_mut_slice().split_at_mut(MAGIC.len());
        begin.copy_from_slice(&MAGIC);
        file.read_exact(rest)?;
        Ok(Self::new(Storage::Owned(bytes), read))
    }

    /// Maps a file.
    ///
    /// # Safety
    /// Nobody changes or shortens the file while the result lives.
    pub(crate) unsafe fn map(path: &Path, read: ReadModel) -> io::Result<Result<Self, FormatError>> {
        let file = File::open(path)?;
        if file.metadata()?.len() == 0 {
            // An empty mapping is refused by some systems; an empty file is refused by `read` with a better text.
            return Ok(Self::copy(&[]));
        }
        // SAFETY: the caller promises that the file does not change while the mapping lives.
        let map = unsafe { Mmap::map(&file)? };
        Ok(Self::new(Storage::Mapped(map), read))
    }
}
