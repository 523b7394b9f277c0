use super::{
    fly::IN_FLIGHT,
    moments::Moments,
    traveller::Traveller,
    walk::{EMPTY_LEVEL, Level},
};
use crate::{
    Hit, InstanceId,
    asset_instance::AssetInstance,
    cluster_frame::LatticeRay,
    excess::Motions,
    prepared::Prepared,
    scene::Scene,
    wide::{FuzzyPath, GROUP, GroupHits, KdStack, LocalRays, PACKET, Packet, WideNode, WideRay, WideStack},
};
use restpose_formats::rows::MAX_WIDE_DEPTH;
use std::cell::RefCell;

/// Scratch of a ray's way through a scene. Making it costs more than a ray does: keep one per thread.
pub(crate) struct TraceContext {
    pub(super) flight: FlightContext,
    pub(super) packet: PacketContext,
}

pub(super) struct PacketContext {
    pub packet: Packet,
    /// Per ray, the best hit so far.
    pub best: [Option<Hit>; PACKET],
    /// Rays that have gone alone, as they begin, and the scaled `t` at which they begin.
    pub travellers: Vec<Option<(Traveller, f32)>>,
    /// Hits of a triangle.
    pub hits: [GroupHits; PACKET / GROUP],
    /// For the tree over instances.
    pub stack: WideStack,
    pub inside: InsideRoom,
}

/// For the trees of an instance.
pub(super) struct InsideRoom {
    /// For the one over all of its triangles, or over its clusters.
    pub stack: WideStack,
    /// For rays of the packet that go alone through trees over triangles.
    pub lone_stack: WideStack,
    /// Those, ready for the one over all of its triangles.
    pub whole_rays: Box<[WideRay; PACKET]>,
    pub cluster: ClusterRoom,
}

/// For the tree of a cluster in its local space.
pub(super) struct ClusterRoom {
    pub stack: WideStack,
    /// Rays that go together.
    pub local: Box<LocalRays>,
    pub path: Box<FuzzyPath>,
    pub kd_stack: Box<KdStack>,
    /// Rays that go alone, ready for the tree's two lattices.
    pub rays: Box<[[LatticeRay; 2]; PACKET]>,
}

pub(super) struct FlightContext {
    /// For the trees that a ray is in, of each of those in flight.
    pub stacks: [WideStack; IN_FLIGHT],
    /// For those of a moving instance.
    pub moving: WideStack,
    pub cluster: ClusterContext,
    pub moments: Moments,
}

pub(super) struct ClusterContext {
    pub binary: Level,
    pub motions: Motions,
}

impl TraceContext {
    fn new() -> Self {
        Self {
            flight: FlightContext {
                stacks: std::array::from_fn(|_| WideStack::new()),
                moving: WideStack::new(),
                cluster: ClusterContext {
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
                inside: InsideRoom {
                    stack: WideStack::new(),
                    lone_stack: WideStack::new(),
                    whole_rays: Box::new([WideRay::NONE; PACKET]),
                    cluster: ClusterRoom {
                        stack: WideStack::new(),
                        local: Box::new(LocalRays::NONE),
                        path: Box::new([WideNode::EMPTY; MAX_WIDE_DEPTH]),
                        kd_stack: Box::new(KdStack::NONE),
                        rays: Box::new([[LatticeRay::NONE; 2]; PACKET]),
                    },
                },
            },
        }
    }

    /// Not inlined: its room on the stack would be every ray's.
    #[cold]
    #[inline(never)]
    fn another() -> Box<Self> {
        Box::new(Self::new())
    }

    /// What rays need of an instance at a time of the scene's interval.
    pub(crate) fn prepared_at<'a>(
        &'a mut self,
        scene: &Scene,
        id: InstanceId,
        instance: &'a AssetInstance,
        time: f32,
    ) -> &'a Prepared {
        self.flight.moments.prepared_at(scene, id.index, instance, time)
    }

    /// Runs `trace` with the thread's own.
    pub(crate) fn with<T>(trace: impl FnOnce(&mut Self) -> T) -> T {
        thread_local! {
            static OWN: RefCell<TraceContext> = RefCell::new(TraceContext::new());
        }
        OWN.with(|own| match own.try_borrow_mut() {
            Ok(mut own) => trace(&mut own),
            // A task that was stolen while a ray of this thread waits for others, as when it poses a whole instance.
            Err(_) => trace(&mut Self::another()),
        })
    }
}
