//! How much memory the process uses, and how far a part of its work makes that rise.

/// Peak resident set of this process in bytes, as the Linux kernel counts it (`VmHWM`); 0 where
/// that is not known, as on other systems.
pub fn peak_rss_bytes() -> u64 {
    of_status("VmHWM:")
}

fn restart_peak() {
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

/// A line of the status of this process, in bytes.
fn of_status(line: &str) -> u64 {
    std::fs::read_to_string("/proc/self/status").map(|text| bytes_in(&text, line)).unwrap_or(0)
}

/// Resident memory while something is done, against what was resident before.
///
/// Memory that the process frees may stay resident, and is used again: what is done first is measured as it is; of what
/// is done after that, what was freed before counts as well.
#[derive(Clone, Copy, Debug)]
pub struct Rise {
    before: u64,
}

impl Rise {
    /// Above what is resident now. Where the system cannot let the peak start anew it goes on from before.
    pub fn begin() -> Rise {
        restart_peak();
        Rise { before: peak_rss_bytes() }
    }

    /// The same work is done again, or other work: the peak starts anew, and what it is measured from stays.
    pub fn again(&self) {
        restart_peak();
    }

    /// How far resident memory has been above what it was, bytes.
    pub fn bytes(&self) -> u64 {
        peak_rss_bytes().saturating_sub(self.before)
    }

    /// How far resident memory is above what it was now, bytes: what was made and is kept.
    pub fn left_bytes(&self) -> u64 {
        of_status("VmRSS:").saturating_sub(self.before)
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

    #[cfg(target_os = "linux")]
    #[test]
    fn counts_memory_that_was_touched() {
        let rise = Rise::begin();
        let block = vec![1u8; 64 << 20];
        assert!(block.iter().step_by(4096).all(|&b| b == 1));
        assert!(peak_rss_bytes() >= 64 << 20, "the peak is below what is held right now");
        let risen = rise.bytes();
        assert!((63 << 20..400 << 20).contains(&risen), "{risen}");
        drop(block);
        assert!(rise.left_bytes() <= risen);
    }
}
