//! `rtcore_scene.h` and `rtcore_geometry.h`: meshes whose vertices move.

use super::{Device, Quality, RayHit, RayHits};
use rayon::prelude::*;
use std::{
    ffi::{c_int, c_uint, c_void},
    sync::Arc,
};

const TRIANGLES: c_int = 0;
const INSTANCE: c_int = 121;
const INDEX_BUFFER: c_int = 0;
const VERTEX_BUFFER: c_int = 1;
/// `RTC_FORMAT_UINT3`.
const UINT3: c_int = 0x5003;
/// `RTC_FORMAT_FLOAT3`.
const FLOAT3: c_int = 0x9003;
/// `RTC_SCENE_FLAG_DYNAMIC`.
const DYNAMIC: c_int = 1;

/// `RTCIntersectContext`.
#[repr(C)]
struct Context {
    /// 0 for incoherent rays, 1 for coherent ones.
    flags: c_int,
    filter: *const c_void,
    instance: c_uint,
}

impl Context {
    fn new(flags: c_int) -> Self {
        Self {
            flags,
            filter: std::ptr::null(),
            instance: c_uint::MAX,
        }
    }
}

unsafe extern "C" {
    fn rtcNewScene(device: *mut c_void) -> *mut c_void;
    fn rtcReleaseScene(scene: *mut c_void);
    fn rtcSetSceneBuildQuality(scene: *mut c_void, quality: Quality);
    fn rtcSetSceneFlags(scene: *mut c_void, flags: c_int);
    fn rtcCommitScene(scene: *mut c_void);
    fn rtcAttachGeometry(scene: *mut c_void, geometry: *mut c_void) -> c_uint;
    fn rtcNewGeometry(device: *mut c_void, kind: c_int) -> *mut c_void;
    fn rtcReleaseGeometry(geometry: *mut c_void);
    fn rtcSetGeometryBuildQuality(geometry: *mut c_void, quality: Quality);
    fn rtcSetGeometryInstancedScene(geometry: *mut c_void, scene: *mut c_void);
    fn rtcUpdateGeometryBuffer(geometry: *mut c_void, kind: c_int, slot: c_uint);
    fn rtcCommitGeometry(geometry: *mut c_void);
    fn rtcSetSharedGeometryBuffer(
        geometry: *mut c_void,
        kind: c_int,
        slot: c_uint,
        format: c_int,
        data: *const c_void,
        offset: usize,
        stride: usize,
        count: usize,
    );
    fn rtcIntersect1(scene: *mut c_void, context: *mut Context, ray: *mut RayHit);
    fn rtcIntersect8(valid: *const c_int, scene: *mut c_void, context: *mut Context, rays: *mut RayHits<8>);
    fn rtcIntersect16(valid: *const c_int, scene: *mut c_void, context: *mut Context, rays: *mut RayHits<16>);
}

/// How a scene follows its vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Update {
    /// The tree of the first update is refitted.
    Refit,
    /// Built anew.
    Rebuild(Quality),
}

impl Update {
    fn qualities(self) -> [Quality; 2] {
        match self {
            Self::Refit => [Quality::Low, Quality::Refit],
            Self::Rebuild(quality) => [quality; 2],
        }
    }
}

/// Vertices and corners that scenes share with their owner.
pub(crate) struct Meshes {
    pub vertices: Vec<[f32; 4]>,
    /// Into the vertices of one mesh.
    pub triangles: Vec<[u32; 3]>,
}

/// A scene of one mesh, or of scenes.
pub(crate) struct Scene {
    scene: *mut c_void,
    geometries: Vec<*mut c_void>,
    has_vertices: bool,
    children: Vec<Scene>,
    device: Arc<Device>,
}

// SAFETY: Embree's objects may be used by any thread; this one changes them only by `&mut self`, and tracing does not.
unsafe impl Send for Scene {}
// SAFETY: as above.
unsafe impl Sync for Scene {}

impl Scene {
    /// A scene of one mesh: `vertex_count` vertices from `vertex_first` on.
    ///
    /// # Safety
    /// The vectors of `meshes` stay where they are and as long as they are while the scene lives, and nobody changes vertices
    /// while it is updated or traced.
    pub unsafe fn of_mesh(
        device: &Arc<Device>,
        meshes: &Meshes,
        vertex_first: usize,
        vertex_count: usize,
        update: Update,
    ) -> Self {
        let [scene_quality, geometry_quality] = update.qualities();
        let flags = if update == Update::Refit { DYNAMIC } else { 0 };
        let mut out = Self::new(device, scene_quality, flags);
        let vertices = &meshes.vertices[vertex_first..vertex_first + vertex_count];
        // SAFETY: device and scene are alive; both buffers are as long as stated, have the stated layout (a vertex has a fourth
        // number, so that sixteen bytes can be read of each) and stay, by the caller's promise.
        unsafe {
            let geometry = rtcNewGeometry(device.0, TRIANGLES);
            let (data, count) = (vertices.as_ptr().cast(), vertices.len());
            rtcSetSharedGeometryBuffer(
                geometry,
                VERTEX_BUFFER,
                0,
                FLOAT3,
                data,
                0,
                size_of::<[f32; 4]>(),
                count,
            );
            let (data, count) = (meshes.triangles.as_ptr().cast(), meshes.triangles.len());
            rtcSetSharedGeometryBuffer(geometry, INDEX_BUFFER, 0, UINT3, data, 0, size_of::<[u32; 3]>(), count);
            rtcSetGeometryBuildQuality(geometry, geometry_quality);
            rtcAttachGeometry(out.scene, geometry);
            out.geometries.push(geometry);
        }
        out.has_vertices = true;
        out
    }

    /// A scene of scenes, each where it is.
    pub fn of_scenes(device: &Arc<Device>, children: Vec<Self>) -> Self {
        let mut out = Self::new(device, Quality::Low, DYNAMIC);
        for child in &children {
            // SAFETY: device and both scenes are alive; the children live as long as this scene.
            unsafe {
                let geometry = rtcNewGeometry(device.0, INSTANCE);
                rtcSetGeometryInstancedScene(geometry, child.scene);
                rtcAttachGeometry(out.scene, geometry);
                out.geometries.push(geometry);
            }
        }
        out.children = children;
        out
    }

    fn new(device: &Arc<Device>, quality: Quality, flags: c_int) -> Self {
        // SAFETY: the device is alive, and so is the scene that it gives.
        let scene = unsafe {
            let scene = rtcNewScene(device.0);
            rtcSetSceneBuildQuality(scene, quality);
            rtcSetSceneFlags(scene, flags);
            scene
        };
        Self {
            scene,
            geometries: Vec::new(),
            has_vertices: false,
            children: Vec::new(),
            device: Arc::clone(device),
        }
    }

    /// Brings the trees up to date with the vertices. An error is Embree's code.
    pub fn update(&mut self) -> Result<(), c_int> {
        self.children.par_iter_mut().try_for_each(Self::update)?;
        // SAFETY: scene and geometries are alive and, by `&mut self`, not in use.
        unsafe {
            for geometry in &self.geometries {
                if self.has_vertices {
                    rtcUpdateGeometryBuffer(*geometry, VERTEX_BUFFER, 0);
                }
                rtcCommitGeometry(*geometry);
            }
            rtcCommitScene(self.scene);
        }
        self.device.take_error()
    }

    /// Traces rays one by one; the scene was updated.
    pub fn intersect(&self, rays: &mut [RayHit]) {
        let mut context = Context::new(0);
        for ray in rays {
            // SAFETY: the scene is alive and was committed; ray and context are ours alone during the call.
            unsafe { rtcIntersect1(self.scene, &raw mut context, ray) };
        }
    }

    /// Traces a packet of eight neighbours.
    pub fn intersect_8(&self, rays: &mut RayHits<8>) {
        let (valid, mut context) = (Aligned([-1; 8]), Context::new(1));
        // SAFETY: as in `intersect`; all is aligned to 64 bytes.
        unsafe { rtcIntersect8(valid.0.as_ptr(), self.scene, &raw mut context, rays) };
    }

    /// Traces a packet of sixteen neighbours.
    pub fn intersect_16(&self, rays: &mut RayHits<16>) {
        let (valid, mut context) = (Aligned([-1; 16]), Context::new(1));
        // SAFETY: as in `intersect`; all is aligned to 64 bytes.
        unsafe { rtcIntersect16(valid.0.as_ptr(), self.scene, &raw mut context, rays) };
    }
}

#[repr(align(64))]
struct Aligned<const N: usize>([c_int; N]);

impl Drop for Scene {
    fn drop(&mut self) {
        // SAFETY: all are ours and alive; children and device go after them.
        unsafe {
            for geometry in &self.geometries {
                rtcReleaseGeometry(*geometry);
            }
            rtcReleaseScene(self.scene);
        }
    }
}
