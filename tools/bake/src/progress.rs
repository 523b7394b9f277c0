/// Where long work says how far it is. Called from any thread.
pub trait Progress: Sync {
    /// A stage begins; it will advance to `total` steps.
    fn stage(&self, name: &'static str, total: u64);
    /// `steps` more of the current stage are done.
    fn advance(&self, steps: u64);
}

/// Tells nobody.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoProgress;

impl Progress for NoProgress {
    fn stage(&self, _: &'static str, _: u64) {}
    fn advance(&self, _: u64) {}
}
