//! What memory some work takes, measured in a process that does nothing else: one test, for the peak is that of the process.

#![cfg(all(target_os = "linux", target_env = "gnu"))]

use lightshaft::memory::Rise;

/// Bytes that resident memory rises by with so many blocks, so small that the allocator keeps them when they are freed.
fn work(blocks: usize) -> u64 {
    let rise = Rise::begin();
    let kept: Vec<Vec<u8>> = (0..blocks).map(|_| vec![1u8; 1000]).collect();
    assert!(kept.iter().all(|block| block[999] == 1));
    rise.bytes()
}

/// What was freed does not count as there already: the same work rises by the same, whatever was done before it.
#[test]
fn memory_that_was_touched_is_counted_and_the_order_of_work_does_not_matter() {
    let (small, large, again) = (work(40_000), work(200_000), work(40_000));
    assert!((36 << 20..80 << 20).contains(&small) && large > 180 << 20, "{small}, {large}");
    assert!(again.abs_diff(small) < small / 10, "{small} before, {again} after");
}
