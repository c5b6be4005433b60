//! How much memory the process has used.

/// Peak resident set of this process in bytes, as the Linux kernel counts it (`VmHWM`); 0 where
/// that is not known, as on other systems.
pub fn peak_rss_bytes() -> u64 {
    std::fs::read_to_string("/proc/self/status").map(|text| peak_in(&text)).unwrap_or(0)
}

/// Lets the peak start anew from what is resident now; where the system cannot, it goes on from before.
pub fn restart_peak() {
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

/// The `VmHWM` line of a process status, in bytes; 0 without one.
fn peak_in(status: &str) -> u64 {
    let kilobytes = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))
        .and_then(|rest| rest.split_whitespace().next())
        .and_then(|number| number.parse::<u64>().ok());
    kilobytes.unwrap_or(0) * 1024
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_the_kernels_line() {
        assert_eq!(peak_in("Name:\tx\nVmPeak:\t  99 kB\nVmHWM:\t    2048 kB\nVmRSS:\t 7 kB\n"), 2048 * 1024);
        assert_eq!(peak_in("Name:\tx\n"), 0);
        assert_eq!(peak_in("VmHWM: many kB"), 0);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn counts_memory_that_was_touched() {
        let block = vec![1u8; 64 << 20];
        assert!(block.iter().step_by(4096).all(|&b| b == 1));
        assert!(peak_rss_bytes() >= 64 << 20, "the peak is below what is held right now");
    }
}
