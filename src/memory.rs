//! How much memory the process uses, and how far a part of its work makes that rise.

pub(crate) use embree4_sys::give_back_freed;

/// Peak resident set of this process in bytes, as the Linux kernel counts it (`VmHWM`); 0 where
/// that is not known, as on other systems.
pub fn peak_rss_bytes() -> u64 {
    of_status("VmHWM:")
}

/// A line of the status of this process, in bytes.
fn of_status(line: &str) -> u64 {
    std::fs::read_to_string("/proc/self/status").map(|text| bytes_in(&text, line)).unwrap_or(0)
}

/// Resident memory while something is done, against what was resident before.
///
/// What was freed before is given back to the system first, as far as its allocator can (that of the GNU C library does):
/// else it would stay resident and be used again, and what is done later would seem to need less. What is left of that are
/// the free ends of the heaps of threads, which it keeps: some MB.
#[derive(Clone, Copy, Debug)]
pub struct Rise {
    before: u64,
}

impl Rise {
    /// Above what is in use now. Where the system cannot let the peak start anew it goes on from before.
    pub fn begin() -> Rise {
        give_back_freed();
        let _ = std::fs::write("/proc/self/clear_refs", "5");
        Rise { before: peak_rss_bytes() }
    }

    /// How far resident memory has been above what it was, bytes.
    pub fn bytes(&self) -> u64 {
        peak_rss_bytes().saturating_sub(self.before)
    }
}

/// A line of a process status, in bytes; 0 without one.
fn bytes_in(status: &str, name: &str) -> u64 {
    let kilobytes = status
        .lines()
        .find_map(|line| line.strip_prefix(name))
        .and_then(|rest| rest.split_whitespace().next())
        .and_then(|number| number.parse::<u64>().ok());
    kilobytes.unwrap_or(0) * 1024
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_the_kernels_line() {
        let status = "Name:\tx\nVmPeak:\t  99 kB\nVmHWM:\t    2048 kB\nVmRSS:\t 7 kB\n";
        assert_eq!([bytes_in(status, "VmHWM:"), bytes_in(status, "VmRSS:")], [2048 * 1024, 7 * 1024]);
        assert_eq!(bytes_in("Name:\tx\n", "VmHWM:"), 0);
        assert_eq!(bytes_in("VmHWM: many kB", "VmHWM:"), 0);
    }
}
