/// Most memory that this process has taken so far, bytes, where the system says it (Linux).
pub(crate) fn peak_memory_bytes() -> Option<u64> {
    bytes_of("VmHWM:", &std::fs::read_to_string("/proc/self/status").ok()?)
}

/// Memory that this process holds now, bytes, where the system says it (Linux).
pub(crate) fn resident_bytes() -> Option<u64> {
    bytes_of("VmRSS:", &std::fs::read_to_string("/proc/self/status").ok()?)
}

/// What `work` gives, and how much more memory than before the process held meanwhile at most, bytes, where the system says
/// it (Linux).
///
/// Memory that was freed before but not given back to the system is not seen when it is used again.
pub(crate) fn peak_while<T>(work: impl FnOnce() -> T) -> (T, Option<u64>) {
    let before = start_anew();
    let out = work();
    let peak = before.and_then(|before| Some(peak_memory_bytes()?.saturating_sub(before)));
    (out, peak)
}

/// Lowers the high-water mark to what the process holds now, and gives that.
fn start_anew() -> Option<u64> {
    // 5: forget the peak (proc(5), since Linux 4.0).
    std::fs::write("/proc/self/clear_refs", "5").ok()?;
    peak_memory_bytes()
}

fn bytes_of(key: &str, status: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix(key))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kilobytes.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_high_water_mark_is_read_in_kilobytes() {
        assert_eq!(
            bytes_of("VmHWM:", "VmPeak:\t  99 kB\nVmHWM:\t  2048 kB\nVmRSS:\t 1 kB\n"),
            Some(2 << 20)
        );
        for other in ["", "VmHWM:\tmuch", "VmHWM:\t18446744073709551615 kB"] {
            assert_eq!(bytes_of("VmHWM:", other), None, "{other}");
        }
    }

    #[test]
    fn what_is_freed_again_counts_and_what_was_there_before_does_not() {
        const BYTES: usize = 100 << 20;
        let kept = std::hint::black_box(vec![1u8; BYTES]);
        let (_, peak) = peak_while(|| drop(std::hint::black_box(vec![1u8; BYTES])));
        let Some(peak) = peak else { return };
        // Other tests of this process run beside it, in less memory.
        let expected = BYTES as u64 / 2..2 * BYTES as u64;
        assert!(expected.contains(&peak), "{peak}");
        drop(kept);
    }
}
