use restpose_builders::bvh::{BinnedBvh, BvhBuilder, FusedBvh, GridBvh, HybridBvh, MedianBvh, SweepBvh};
use restpose_runtime::{
    build::{BinCount, StreamedBvh},
    simd::SimdLevel,
};

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
        entry::<FusedBvh>("fused", true, true),
        Entry {
            make: || Box::new(fast_fused()),
            ..entry::<FusedBvh>("fused, fast", true, true)
        },
        entry::<StreamedBvh>("streamed", true, false),
        Entry {
            make: || Box::new(StreamedBvh::new(BinCount::FAST, SimdLevel::detect())),
            ..entry::<StreamedBvh>("streamed, fast", true, false)
        },
        entry::<BinnedBvh>("binned", true, true),
        entry::<HybridBvh>("hybrid", true, true),
        entry::<GridBvh>("grid", false, true),
        entry::<MedianBvh>("median", false, true),
    ]
}

/// By the dissertation's fast settings.
pub(crate) fn fast_fused() -> FusedBvh {
    let mut builder = FusedBvh::default();
    builder.bin_count = BinCount::FAST;
    builder
}
