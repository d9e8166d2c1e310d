//! Sorting in place.

/// Sorts items by a key. Without `std` a heap sort, which is slower, but takes 2.5 KiB of machine code and 4.5 KiB of stack less
/// than that of the standard library.
pub(crate) fn sort<T: Copy, K: Ord>(items: &mut [T], key: impl Fn(&T) -> K) {
    if cfg!(feature = "std") {
        return items.sort_unstable_by_key(key);
    }
    // One copy in machine code serves all keys.
    let after: &dyn Fn(&T, &T) -> bool = &|x, y| key(x) > key(y);
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

/// Restores a heap, in which no item is `before` its parent, where only the item at `index` may have to move down.
#[inline]
pub(crate) fn sift_down<T: Copy>(
    heap: &mut [T],
    mut index: usize,
    before: impl Fn(&T, &T) -> bool,
) {
    let Some(&moved) = heap.get(index) else { return };
    while 2 * index + 1 < heap.len() {
        let left = 2 * index + 1;
        let right = (left + 1).min(heap.len() - 1);
        // The choice takes no branch: which child is first is a coin toss to a predictor.
        let child = left + usize::from(before(&heap[right], &heap[left]));
        let risen = heap[child];
        if !before(&risen, &moved) {
            break;
        }
        heap[index] = risen;
        index = child;
    }
    heap[index] = moved;
}
