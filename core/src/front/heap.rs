//! A binary heap in a slice.

/// Restores a heap in which the item `at` may have to move down; an item is above another if it is `before` it.
#[inline]
pub(crate) fn sift_down<T: Copy>(heap: &mut [T], mut at: usize, before: impl Fn(&T, &T) -> bool) {
    let Some(&moved) = heap.get(at) else { return };
    loop {
        let mut child = 2 * at + 1;
        if child >= heap.len() {
            break;
        }
        // Without branches: which child is first is a coin toss to a predictor.
        let other = (child + 1).min(heap.len() - 1);
        child += usize::from(before(&heap[other], &heap[child]));
        let Some(&risen) = heap.get(child) else { break };
        if !before(&risen, &moved) {
            break;
        }
        place(heap, at, risen);
        at = child;
    }
    place(heap, at, moved);
}

#[inline]
fn place<T>(heap: &mut [T], at: usize, item: T) {
    if let Some(slot) = heap.get_mut(at) {
        *slot = item;
    }
}

/// Sorts by keys that all differ. Without `std` a heap sort, which is slower, but small and free of panics.
pub(crate) fn sort<T: Copy, K: Ord>(items: &mut [T], key: impl Fn(&T) -> K) {
    if cfg!(feature = "std") {
        return items.sort_unstable_by_key(key);
    }
    let after = |x: &T, y: &T| key(x) > key(y);
    for root in (0..items.len() / 2).rev() {
        sift_down(items, root, after);
    }
    let mut rest = items;
    while let Some((last, heap)) = rest.split_last_mut() {
        if let Some(first) = heap.first_mut() {
            core::mem::swap(first, last);
        }
        sift_down(heap, 0, after);
        rest = heap;
    }
}
