use super::Prepared;
use crate::Asset;
use std::sync::{Arc, Mutex, PoisonError};

/// An asset, and what was prepared of its instances and is needed no longer: memory for the next.
#[derive(Debug)]
pub(crate) struct PreparedPool {
    asset: Arc<Asset>,
    #[expect(clippy::vec_box, reason = "large, and they are moved in and out as they are")]
    spare: Mutex<Vec<Box<Prepared>>>,
}

impl PreparedPool {
    pub(crate) fn new(asset: &Arc<Asset>) -> Self {
        Self {
            asset: Arc::clone(asset),
            spare: Mutex::default(),
        }
    }

    pub(crate) fn asset(&self) -> &Arc<Asset> {
        &self.asset
    }

    pub(crate) fn take(&self) -> Box<Prepared> {
        let spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner).pop();
        spare.unwrap_or_default()
    }

    pub(crate) fn put(&self, prepared: Box<Prepared>) {
        self.spare.lock().unwrap_or_else(PoisonError::into_inner).push(prepared);
    }
}
