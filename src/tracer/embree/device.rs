//! An Embree device with its error log, and how much memory it has.

use std::{
    ffi::{CStr, CString, c_char, c_void},
    ptr,
    sync::{
        Arc, Mutex,
        atomic::{AtomicIsize, Ordering},
    },
};

use embree4_sys as raw;

/// The first error Embree reported since the last look.
#[derive(Debug, Default)]
struct ErrorLog(Mutex<Option<String>>);

/// Owns an `RTCDevice`; the library stays loaded at least as long.
#[derive(Debug)]
pub(super) struct Device {
    api: Arc<raw::Api>,
    device: raw::RTCDevice,
    /// Embree holds its address: boxed, so that moving the device does not move it.
    log: Box<ErrorLog>,
    /// Bytes that Embree has allocated and not freed. It holds this address, too.
    allocated: Box<AtomicIsize>,
}

impl Device {
    /// A device that builds on at most `threads` threads; the error is Embree's own text.
    pub(super) fn new(api: &Arc<raw::Api>, threads: usize) -> Result<Self, String> {
        let config = CString::new(format!("threads={}", threads.max(1))).expect("no NUL in it");
        // SAFETY: the string is NUL-terminated and read before the call returns.
        let device = unsafe { api.rtcNewDevice(config.as_ptr()) };
        if device.is_null() {
            // SAFETY: a null device asks for the error of the calling thread's failed rtcNewDevice.
            let code = unsafe { api.rtcGetDeviceError(ptr::null_mut()) };
            return Err(error_name(code).to_owned());
        }
        let log = Box::<ErrorLog>::default();
        let user = (&raw const *log).cast_mut().cast::<c_void>();
        // SAFETY: the device is valid; the callback has the declared signature, and what `user` points
        // to lives until after the device is released, and is only ever shared.
        unsafe { api.rtcSetDeviceErrorFunction(device, Some(log_error), user) };
        let allocated = Box::<AtomicIsize>::default();
        let user = (&raw const *allocated).cast_mut().cast::<c_void>();
        // SAFETY: as above.
        unsafe { api.rtcSetDeviceMemoryMonitorFunction(device, Some(count_memory), user) };
        Ok(Device { api: Arc::clone(api), device, log, allocated })
    }

    pub(super) fn api(&self) -> &Arc<raw::Api> {
        &self.api
    }

    pub(super) fn raw(&self) -> raw::RTCDevice {
        self.device
    }

    pub(super) fn property(&self, property: raw::RTCDeviceProperty) -> isize {
        // SAFETY: the device is valid; an unknown property is reported as an error and gives 0.
        unsafe { self.api.rtcGetDeviceProperty(self.device, property) }
    }

    /// Bytes that Embree has allocated for this device and what was made with it.
    pub(super) fn bytes(&self) -> u64 {
        self.allocated.load(Ordering::Relaxed).try_into().unwrap_or(0)
    }

    /// The first error since the last call, if there was one.
    pub(super) fn take_error(&self) -> Option<String> {
        // SAFETY: the device is valid.
        let code = unsafe { self.api.rtcGetDeviceError(self.device) };
        let logged = self.log.0.lock().ok().and_then(|mut first| first.take());
        match logged {
            None if code != raw::RTCError::RTC_ERROR_NONE => Some(error_name(code).to_owned()),
            logged => logged,
        }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: the device is valid and this is the only reference we hold.
        unsafe { self.api.rtcReleaseDevice(self.device) };
    }
}

/// Called by Embree from any of its threads: keeps the first message, never panics.
unsafe extern "C" fn log_error(user: *mut c_void, code: raw::RTCError, message: *const c_char) {
    // SAFETY: `user` is the boxed log of a device that is still alive, or null.
    let Some(log) = (unsafe { user.cast::<ErrorLog>().as_ref() }) else { return };
    let said = if message.is_null() {
        String::new()
    } else {
        // SAFETY: Embree passes a NUL-terminated string that lives during the call.
        unsafe { CStr::from_ptr(message) }.to_string_lossy().into_owned()
    };
    if let Ok(mut first) = log.0.lock() {
        first.get_or_insert_with(|| format!("{said} ({})", error_name(code)));
    }
}

/// Called by Embree from any of its threads, for what it allocates (`bytes` above 0) and what it frees: goes on always.
unsafe extern "C" fn count_memory(user: *mut c_void, bytes: isize, _post: bool) -> bool {
    // SAFETY: `user` is the boxed count of a device that is still alive, or null.
    if let Some(allocated) = unsafe { user.cast::<AtomicIsize>().as_ref() } {
        allocated.fetch_add(bytes, Ordering::Relaxed);
    }
    true
}

fn error_name(code: raw::RTCError) -> &'static str {
    match code {
        raw::RTCError::RTC_ERROR_NONE => "no error",
        raw::RTCError::RTC_ERROR_INVALID_ARGUMENT => "invalid argument",
        raw::RTCError::RTC_ERROR_INVALID_OPERATION => "invalid operation",
        raw::RTCError::RTC_ERROR_OUT_OF_MEMORY => "out of memory",
        raw::RTCError::RTC_ERROR_UNSUPPORTED_CPU => "unsupported processor",
        raw::RTCError::RTC_ERROR_CANCELLED => "cancelled",
        _ => "unknown error",
    }
}
