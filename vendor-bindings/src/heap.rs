//! The allocator of the C library: what the program freed, given back to the system.

/// Gives back to the system what was freed, as far as the allocator knows how (`malloc_trim` of the GNU C library);
/// whether it does. Elsewhere nothing happens.
pub fn give_back_freed() -> bool {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        unsafe extern "C" {
            fn malloc_trim(pad: usize) -> std::ffi::c_int;
        }
        // SAFETY: declared as in malloc.h of the GNU C library, which this target has; it may be called from any thread at
        // any time and changes nothing that a program can see.
        unsafe { malloc_trim(0) };
        true
    }
    #[cfg(not(all(target_os = "linux", target_env = "gnu")))]
    false
}
