use super::{
    context::{FlightContext, InsideRoom},
    flight::{Actor, Inside},
    fly::{Departure, IN_FLIGHT, Rays, fly},
    lone_rays::{LoneTree, pass_below},
    traveller::Traveller,
    whole_tree::WholeTree,
};
use crate::{
    Hit, InstanceId, Ray,
    instance::Instance,
    posed_mesh::PosedMesh,
    scene::Scene,
    set_bits::set_bits,
    wide::{Bundled, GROUP, GroupHits, PACKET, Part, WideStack, walk_together},
};

/// Rays on their way together.
pub(super) struct Bundle<'a> {
    pub scene: &'a Scene,
    pub rays: &'a [Ray],
    /// Per ray, the best hit so far.
    pub best: &'a mut [Option<Hit>; PACKET],
    /// Rays that have gone alone, as they begin, and the scaled `t` at which they begin; meaningful where `ready` has a bit.
    pub travellers: &'a mut [Option<(Traveller, f32)>],
    pub ready: u64,
    /// Hits of a triangle.
    pub hits: &'a mut [GroupHits; PACKET / GROUP],
}

impl Bundle<'_> {
    /// Traces these groups through an instance.
    pub(super) fn enter_instance<const ANY: bool>(
        &mut self,
        index: u32,
        groups: u32,
        bundled: &mut Bundled,
        room: &mut InsideRoom,
        context: &mut FlightContext,
    ) {
        let scene = self.scene;
        let Some(instance) = scene.in_slot(index) else {
            return;
        };
        let id = scene.id(index);
        let is_done = if let Instance::Asset(instance) = instance {
            let (asset, prepared) = (instance.asset(), instance.prepared());
            match prepared.enter(instance.pool()) {
                Some(whole) if !whole.nodes.is_empty() => {
                    let is_done = self.enter_whole::<ANY>(id, whole.mesh(asset.model()), bundled, room);
                    if is_done {
                        prepared.count_whole(groups.count_ones() * GROUP as u32);
                    }
                    is_done
                }
                // Where it has none, its vertices are of use.
                _ => {
                    let actor = Actor { id, asset, prepared };
                    self.enter_clusters::<ANY>((actor, index), groups, bundled, room, context)
                }
            }
        } else if let Instance::Geometry(geometry) = instance
            && let Some(mesh) = geometry.mesh()
        {
            let is_done = self.enter_whole::<ANY>(id, mesh, bundled, room);
            if is_done {
                geometry.count(groups.count_ones() * GROUP as u32);
            }
            is_done
        } else {
            false
        };
        if is_done {
            return;
        }
        let places = bundled.meeting(scene.simd, groups, &instance.bounds());
        let inside = Inside::All;
        self.alone_from::<ANY>(Departure::Instance { index, inside }, places, bundled, context);
    }

    /// Traces rays that part outside of trees over triangles.
    pub(super) fn alone_from<const ANY: bool>(
        &mut self,
        departure: Departure,
        places: u64,
        bundled: &mut Bundled,
        context: &mut FlightContext,
    ) {
        let scene = self.scene;
        self.alone(places, bundled, |rays: &mut Alone<ANY>| {
            fly::<ANY, IN_FLIGHT, _, _>(scene, departure, 0.0, rays, context, &mut ());
        });
    }

    /// Traces rays that part at a node of a tree over triangles.
    pub(super) fn alone_below<const ANY: bool>(
        &mut self,
        tree: &mut impl LoneTree,
        node: u32,
        places: u64,
        bundled: &mut Bundled,
        stack: &mut WideStack,
    ) {
        let level = self.scene.simd;
        self.alone(places, bundled, |rays: &mut Alone<ANY>| {
            while let Some((place, mut traveller, start)) = rays.next() {
                pass_below::<ANY, _>(tree, level, node, (place, &mut traveller, start), stack);
                rays.landed(place, &traveller);
            }
        });
    }

    /// Traces rays that part.
    fn alone<const ANY: bool>(
        &mut self,
        places: u64,
        bundled: &mut Bundled,
        trace: impl FnOnce(&mut Alone<'_, '_, ANY>),
    ) {
        for place in set_bits(places & !self.ready) {
            self.travellers[place] = Traveller::new(&self.rays[place]);
        }
        self.ready |= places;
        let mut alone = Alone::<ANY> {
            places,
            travellers: self.travellers,
            best: self.best,
            bundled,
            cut: 0,
        };
        trace(&mut alone);
        let cut = alone.cut;
        if cut != 0 {
            bundled.shorten(self.scene.simd, cut);
        }
    }

    /// False where the rays must go one by one.
    fn enter_whole<const ANY: bool>(
        &mut self,
        id: InstanceId,
        mesh: PosedMesh,
        bundled: &mut Bundled,
        room: &mut InsideRoom,
    ) -> bool {
        if !bundled.is_narrow(&mesh.nodes[0].around(), mesh.nodes.len()) {
            return false;
        }
        let Some(together) = bundled.in_world(mesh.nodes) else {
            return false;
        };
        let level = self.scene.simd;
        let InsideRoom {
            stack,
            lone_stack,
            whole_rays,
            ..
        } = room;
        let mut tree = WholeTree::new(id, mesh, whole_rays);
        let mut visit = |part: Part, bundled: &mut Bundled| {
            match part {
                Part::Leaf { leaf, groups } => self.test::<ANY>(id, leaf, &mesh.corners(leaf), groups, bundled),
                Part::Alone { node, places } => {
                    self.alone_below::<ANY>(&mut tree, node, places, bundled, lone_stack);
                }
            }
            bundled.is_over()
        };
        walk_together(level, &mut &mesh.nodes[..], &together, bundled, stack, &mut visit);
        true
    }

    /// Tests a triangle against some groups.
    pub(super) fn test<const ANY: bool>(
        &mut self,
        instance: InstanceId,
        triangle: u32,
        corners: &[[f32; 3]; 3],
        groups: u32,
        bundled: &mut Bundled,
    ) {
        let found = bundled.hits(self.scene.simd, groups, corners, self.hits);
        let mut cut = 0;
        for place in set_bits(found) {
            let (hits, lane) = (&self.hits[place / GROUP], place % GROUP);
            let hit = Hit {
                t: hits.t[lane],
                u: hits.u[lane],
                v: hits.v[lane],
                instance,
                triangle,
            };
            if self.best[place].is_none_or(|best| hit.is_before(&best)) {
                self.best[place] = Some(hit);
                bundled.cut(place, if ANY { f32::NEG_INFINITY } else { hit.t });
                cut |= 1 << (place / GROUP);
            }
        }
        if cut != 0 {
            bundled.shorten(self.scene.simd, cut);
        }
    }
}

/// Rays that part from a bundle.
struct Alone<'a, 'b, const ANY: bool> {
    /// Those that are still to come.
    places: u64,
    travellers: &'a [Option<(Traveller, f32)>],
    best: &'a mut [Option<Hit>; PACKET],
    bundled: &'a mut Bundled<'b>,
    /// Groups of those that found a better hit.
    cut: u32,
}

impl<const ANY: bool> Rays for Alone<'_, '_, ANY> {
    fn next(&mut self) -> Option<(usize, Traveller, f32)> {
        loop {
            let place = set_bits(self.places).next()?;
            self.places &= self.places - 1;
            let best = self.best[place];
            if ANY && best.is_some() {
                continue;
            }
            let Some((traveller, start)) = &self.travellers[place] else {
                continue;
            };
            let mut traveller = traveller.clone();
            if let Some(best) = best {
                traveller.resume(best);
            }
            return Some((place, traveller, *start));
        }
    }

    fn landed(&mut self, place: usize, traveller: &Traveller) {
        if let Some(best) = traveller.best
            && self.best[place] != Some(best)
        {
            self.best[place] = Some(best);
            self.bundled.cut(place, if ANY { f32::NEG_INFINITY } else { best.t });
            self.cut |= 1 << (place / GROUP);
        }
    }
}
