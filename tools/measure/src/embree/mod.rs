//! What we use of Embree 3's C interface.
#![expect(unsafe_code, reason = "a C library")]

mod builder;
mod ray_hit;
mod scene;

pub(crate) use builder::{BuildPrimitive, Builder, Node, primitive};
pub(crate) use ray_hit::{RayHit, RayHits};
pub(crate) use scene::{Meshes, Scene, Update};

use std::ffi::{c_char, c_int, c_void};

/// `RTC_ERROR_NONE`.
const NO_ERROR: c_int = 0;

/// `RTCBuildQuality`. High quality splits boxes, which trees that list each box once cannot hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub(crate) enum Quality {
    Low = 0,
    Medium = 1,
    /// Of a geometry alone.
    Refit = 3,
}

unsafe extern "C" {
    fn rtcNewDevice(config: *const c_char) -> *mut c_void;
    fn rtcReleaseDevice(device: *mut c_void);
    fn rtcGetDeviceError(device: *mut c_void) -> c_int;
}

/// A device.
pub(crate) struct Device(*mut c_void);

// SAFETY: Embree's devices may be used by any threads at once.
unsafe impl Send for Device {}
// SAFETY: as above.
unsafe impl Sync for Device {}

impl Device {
    /// `None` where Embree gives no device. Embree's threads are those of the device with the most: no two should live at a
    /// time.
    pub fn new(threads: usize) -> Option<Self> {
        let config = std::ffi::CString::new(format!("threads={threads}")).ok()?;
        // SAFETY: the text ends with a zero and outlives the call.
        let device = unsafe { rtcNewDevice(config.as_ptr()) };
        (!device.is_null()).then_some(Self(device))
    }

    /// What went wrong since this was last asked; an error is Embree's code.
    pub fn take_error(&self) -> Result<(), c_int> {
        // SAFETY: the device is alive.
        match unsafe { rtcGetDeviceError(self.0) } {
            NO_ERROR => Ok(()),
            code => Err(code),
        }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: the device is ours and alive; what was made with it holds it until it goes, too.
        unsafe { rtcReleaseDevice(self.0) };
    }
}
