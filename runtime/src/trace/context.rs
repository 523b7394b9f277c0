use super::{
    moments::Moments,
    traveller::Traveller,
    walk::{EMPTY_LEVEL, Level},
};
use crate::{
    Hit, InstanceId,
    asset_instance::AssetInstance,
    excess::Motions,
    prepared::Prepared,
    scene::Scene,
    wide::{GROUP, GroupHits, PACKET, Packet, WideStack},
};
use std::cell::RefCell;

/// Scratch of a ray's way through a scene. Large: keep one per thread.
pub(crate) struct TraceContext {
    /// For the tree over instances.
    pub(super) stack: WideStack,
    pub(super) instance: InstanceContext,
    pub(super) packet: PacketContext,
}

pub(super) struct PacketContext {
    pub packet: Packet,
    /// Per ray, the best hit so far.
    pub best: [Option<Hit>; PACKET],
    /// Rays that went alone, and the scaled `t` at which they begin.
    pub travellers: Vec<Option<(Traveller, f32)>>,
    /// Hits of a triangle.
    pub hits: [GroupHits; PACKET / GROUP],
    /// For the tree over instances.
    pub stack: WideStack,
}

pub(super) struct InstanceContext {
    /// For the tree over clusters, or over all triangles.
    pub stack: WideStack,
    /// For the tree over all triangles.
    pub packet_stack: WideStack,
    pub cluster: ClusterContext,
    pub moments: Moments,
}

pub(super) struct ClusterContext {
    pub stack: WideStack,
    pub binary: Level,
    pub motions: Motions,
}

impl TraceContext {
    fn new() -> Self {
        Self {
            stack: WideStack::new(),
            instance: InstanceContext {
                stack: WideStack::new(),
                packet_stack: WideStack::new(),
                cluster: ClusterContext {
                    stack: WideStack::new(),
                    binary: EMPTY_LEVEL,
                    motions: Motions::default(),
                },
                moments: Moments::default(),
            },
            packet: PacketContext {
                packet: Packet::new(),
                best: [None; PACKET],
                travellers: vec![None; PACKET],
                hits: [GroupHits::NONE; PACKET / GROUP],
                stack: WideStack::new(),
            },
        }
    }

    /// What rays need of an instance at a time of the scene's interval.
    pub(crate) fn prepared_at<'a>(
        &'a mut self,
        scene: &Scene,
        id: InstanceId,
        instance: &'a AssetInstance,
        time: f32,
    ) -> &'a Prepared {
        self.instance.moments.prepared_at(scene, id.index, instance, time)
    }

    /// Runs `trace` with the thread's own.
    pub(crate) fn with<T>(trace: impl FnOnce(&mut Self) -> T) -> T {
        thread_local! {
            static OWN: RefCell<TraceContext> = RefCell::new(TraceContext::new());
        }
        OWN.with(|own| match own.try_borrow_mut() {
            Ok(mut own) => trace(&mut own),
            // A task that was stolen while a ray of this thread waits for others, as when it poses a whole instance.
            Err(_) => trace(&mut Self::new()),
        })
    }
}
