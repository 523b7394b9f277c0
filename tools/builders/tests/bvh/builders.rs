use restpose_builders::bvh::{BinnedBvh, BvhBuilder, GridBvh, HybridBvh, MedianBvh, SweepBvh};

/// A builder under test.
pub(crate) struct Entry {
    pub(crate) name: &'static str,
    pub(crate) make: fn() -> Box<dyn BvhBuilder + Send>,
    /// No node is parted unless that is cheaper by Eq. 4.3.
    pub(crate) by_cost: bool,
    /// Nodes do not depend on the order of the boxes.
    pub(crate) order_free: bool,
}

fn entry<B: BvhBuilder + Default + Send + 'static>(name: &'static str, by_cost: bool, order_free: bool) -> Entry {
    Entry {
        name,
        make: || Box::<B>::default(),
        by_cost,
        order_free,
    }
}

/// All builders. A new one is added here and is then tested by all that holds of every builder.
pub(crate) fn all_bvh_builders() -> Vec<Entry> {
    vec![
        entry::<SweepBvh>("sweep", true, true),
        entry::<BinnedBvh>("binned", true, true),
        entry::<HybridBvh>("hybrid", true, true),
        entry::<GridBvh>("grid", false, true),
        entry::<MedianBvh>("median", false, true),
    ]
}
