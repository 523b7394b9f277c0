//! `rtcore_builder.h`, and the callbacks of a build.

use super::{Device, Quality};
use restpose_runtime::Aabb;
use std::ffi::{c_int, c_uint, c_void};

/// Boxes of a leaf at most: `RTC_BUILD_MAX_PRIMITIVES_PER_LEAF`.
const MOST_BOXES_OF_A_LEAF: c_uint = 32;

/// Deeper than the default of 32, which ten million triangles exceed, and within what the runtime's traversal keeps room
/// for with the levels that large leaves add.
const MOST_LEVELS: c_uint = 48;

/// `RTC_ERROR_UNKNOWN`: for a build that gives nothing and no reason.
const UNKNOWN_ERROR: c_int = 1;

/// `RTCBuildPrimitive`.
#[derive(Clone, Copy)]
#[repr(C, align(32))]
pub(crate) struct BuildPrimitive {
    lower: [f32; 3],
    geometry: c_uint,
    upper: [f32; 3],
    id: c_uint,
}

/// `RTCBounds`.
#[derive(Clone, Copy)]
#[repr(C, align(16))]
struct Bounds {
    lower: [f32; 4],
    upper: [f32; 4],
}

type Allocator = *mut c_void;

/// `RTCBuildArguments`.
#[repr(C)]
struct BuildArguments {
    byte_size: usize,
    quality: Quality,
    flags: c_int,
    max_branching_factor: c_uint,
    max_depth: c_uint,
    sah_block_size: c_uint,
    min_leaf_size: c_uint,
    max_leaf_size: c_uint,
    traversal_cost: f32,
    intersection_cost: f32,
    bvh: *mut c_void,
    primitives: *mut BuildPrimitive,
    primitive_count: usize,
    primitive_capacity: usize,
    create_node: extern "C" fn(Allocator, c_uint, *mut c_void) -> *mut c_void,
    set_children: extern "C" fn(*mut c_void, *mut *mut c_void, c_uint, *mut c_void),
    set_bounds: extern "C" fn(*mut c_void, *mut *const Bounds, c_uint, *mut c_void),
    create_leaf: extern "C" fn(Allocator, *const BuildPrimitive, usize, *mut c_void) -> *mut c_void,
    split_primitive: *const c_void,
    progress: *const c_void,
    user: *mut c_void,
}

unsafe extern "C" {
    fn rtcNewBVH(device: *mut c_void) -> *mut c_void;
    fn rtcReleaseBVH(bvh: *mut c_void);
    fn rtcBuildBVH(arguments: *const BuildArguments) -> *mut c_void;
    fn rtcThreadLocalAlloc(allocator: Allocator, bytes: usize, align: usize) -> *mut c_void;
}

/// A leaf if `count` is above zero: then its ids stand behind it.
#[repr(C, align(16))]
struct Leaf {
    count: u64,
}

/// An inner node: `count` is zero.
#[repr(C, align(16))]
struct Inner {
    count: u64,
    children: [*mut c_void; 2],
    bounds: [Bounds; 2],
}

extern "C" fn create_node(allocator: Allocator, _children: c_uint, _user: *mut c_void) -> *mut c_void {
    // SAFETY: the allocator is the one that Embree just gave to this call; the alignment is a power of two.
    let node = unsafe { rtcThreadLocalAlloc(allocator, size_of::<Inner>(), align_of::<Inner>()) }.cast::<Inner>();
    // SAFETY: the memory is new, large and aligned enough, and Embree ends a build that has none left by itself.
    unsafe {
        node.write(Inner {
            count: 0,
            children: [std::ptr::null_mut(); 2],
            bounds: [Bounds {
                lower: [0.0; 4],
                upper: [0.0; 4],
            }; 2],
        });
    }
    node.cast()
}

extern "C" fn set_children(node: *mut c_void, children: *mut *mut c_void, count: c_uint, _user: *mut c_void) {
    for child in 0..(count as usize).min(2) {
        // SAFETY: `node` is one that `create_node` made, and is set by one call at a time; `children` has `count` entries.
        unsafe { (*node.cast::<Inner>()).children[child] = *children.add(child) };
    }
}

extern "C" fn set_bounds(node: *mut c_void, bounds: *mut *const Bounds, count: c_uint, _user: *mut c_void) {
    for child in 0..(count as usize).min(2) {
        // SAFETY: as in `set_children`; each entry points to bounds that live through this call.
        unsafe { (*node.cast::<Inner>()).bounds[child] = **bounds.add(child) };
    }
}

extern "C" fn create_leaf(
    allocator: Allocator,
    primitives: *const BuildPrimitive,
    count: usize,
    _user: *mut c_void,
) -> *mut c_void {
    let bytes = size_of::<Leaf>() + count * size_of::<u32>();
    // SAFETY: as in `create_node`.
    let leaf = unsafe { rtcThreadLocalAlloc(allocator, bytes, align_of::<Leaf>()) }.cast::<Leaf>();
    // SAFETY: the memory is new and has room for the leaf and `count` ids behind it, whose alignment is less than the
    // leaf's; `primitives` has `count` entries.
    unsafe {
        leaf.write(Leaf { count: count as u64 });
        let ids = leaf.add(1).cast::<u32>();
        for index in 0..count {
            ids.add(index).write((*primitives.add(index)).id);
        }
    }
    leaf.cast()
}

/// A builder's memory, and the tree in it.
pub(crate) struct Builder {
    bvh: *mut c_void,
    quality: Quality,
    root: *mut c_void,
    /// Last: it goes last.
    device: Device,
}

// SAFETY: Embree's objects may be used by any thread; this one owns them, and is used by one thread at a time.
unsafe impl Send for Builder {}

/// A node of the tree.
pub(crate) enum Node<'a> {
    Inner([usize; 2]),
    Leaf(&'a [u32]),
}

impl Builder {
    /// A builder of its own on a device.
    pub fn new(device: Device, quality: Quality) -> Self {
        // SAFETY: the device is alive.
        let bvh = unsafe { rtcNewBVH(device.0) };
        Self {
            bvh,
            quality,
            root: std::ptr::null_mut(),
            device,
        }
    }

    /// Builds over `primitives`, which Embree puts into another order. An error is Embree's code.
    pub fn build(&mut self, primitives: &mut [BuildPrimitive]) -> Result<(), c_int> {
        let arguments = BuildArguments {
            byte_size: size_of::<BuildArguments>(),
            quality: self.quality,
            flags: 0,
            max_branching_factor: 2,
            max_depth: MOST_LEVELS,
            sah_block_size: 1,
            min_leaf_size: 1,
            max_leaf_size: MOST_BOXES_OF_A_LEAF,
            traversal_cost: 1.0,
            intersection_cost: 1.0,
            bvh: self.bvh,
            primitives: primitives.as_mut_ptr(),
            primitive_count: primitives.len(),
            primitive_capacity: primitives.len(),
            create_node,
            set_children,
            set_bounds,
            create_leaf,
            split_primitive: std::ptr::null(),
            progress: std::ptr::null(),
            user: std::ptr::null_mut(),
        };
        // SAFETY: the arguments are complete; the builder is alive; the primitives are as many as stated and are ours alone
        // during the call; the callbacks do not unwind.
        self.root = unsafe { rtcBuildBVH(&raw const arguments) };
        self.device.take_error()?;
        if self.root.is_null() {
            Err(UNKNOWN_ERROR)
        } else {
            Ok(())
        }
    }

    /// The root of what was built last; `None` before that.
    pub fn root(&self) -> Option<usize> {
        (!self.root.is_null()).then_some(self.root as usize)
    }

    /// A node of the tree that was built last.
    ///
    /// # Safety
    /// `place` is what [`root`](Self::root) gave or a child of a node that this gave, since the last build.
    pub unsafe fn node(&self, place: usize) -> Option<Node<'_>> {
        if place == 0 {
            return None;
        }
        let node = place as *const Inner;
        // SAFETY: the caller's promise: the place is one of `create_node` or `create_leaf`, which both begin with the count,
        // and lives as long as the builder's memory does.
        unsafe {
            Some(match (*node.cast::<Leaf>()).count {
                0 => Node::Inner((*node).children.map(|child| child as usize)),
                count => Node::Leaf(std::slice::from_raw_parts(
                    node.cast::<Leaf>().add(1).cast::<u32>(),
                    count as usize,
                )),
            })
        }
    }
}

impl Drop for Builder {
    fn drop(&mut self) {
        // SAFETY: it is ours and alive; its device goes after it.
        unsafe { rtcReleaseBVH(self.bvh) };
    }
}

/// A box as Embree takes it.
pub(crate) fn primitive(id: usize, bounds: &Aabb) -> BuildPrimitive {
    BuildPrimitive {
        lower: bounds.min,
        geometry: 0,
        upper: bounds.max,
        id: id as c_uint,
    }
}
