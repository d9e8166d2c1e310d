//! Fork-join over slices, by a caller's [`Join`].
//!
//! A pass over many items halves them down to [`GRAIN`], with a `join` or without: results are the same to the
//! bit, whoever computes them.

/// Runs two tasks, side by side if it can, each once, and returns when both are done: `rayon::join`, for example.
pub type Join<'j> = dyn Fn(&mut (dyn FnMut() + Send), &mut (dyn FnMut() + Send)) + Sync + 'j;

/// Items of a pass that one task takes: some tens of microseconds. Meshes of tests are small.
pub(crate) const GRAIN: usize = if cfg!(test) { 1 << 6 } else { 1 << 13 };

/// Items of a pass whose items are costly: some ten microseconds a task.
pub(crate) const FINE: usize = 1 << 8;

/// Runs two tasks by `join`, or one after the other; a task that `join` leaves out runs after it.
#[inline(always)]
pub(crate) fn both<A: Send, B: Send>(
    join: Option<&Join<'_>>,
    mut a: impl FnMut() -> A + Send,
    mut b: impl FnMut() -> B + Send,
) -> (A, B) {
    let Some(join) = join else { return (a(), b()) };
    let (mut of_a, mut of_b) = (None, None);
    join(&mut || of_a = Some(a()), &mut || of_b = Some(b()));
    (of_a.unwrap_or_else(a), of_b.unwrap_or_else(b))
}

/// Calls `pass` on matching parts of two slices, each at most [`GRAIN`] long, and merges what it returns from left to
/// right. If `b` is shorter than `a`, so are its last parts.
pub(crate) fn halves<A: Send, B: Send, R: Send>(
    join: Option<&Join<'_>>,
    a: &mut [A],
    b: &mut [B],
    pass: &(impl Fn(&mut [A], &mut [B]) -> R + Sync),
    merge: &(impl Fn(R, R) -> R + Sync),
) -> R {
    if a.len() <= GRAIN {
        return pass(a, b);
    }
    let middle = a.len() / 2;
    let (a, right_a) = a.split_at_mut(middle);
    let (b, right_b) = b.split_at_mut(middle.min(b.len()));
    let left = || halves(join, a, b, pass, merge);
    let (left, right) = both(join, left, || halves(join, right_a, right_b, pass, merge));
    merge(left, right)
}

/// Calls `pass` on parts of a slice, each at most [`FINE`] long, with the index of the first item, where that of the
/// slice's first is `first`.
pub(crate) fn parts<T: Send>(
    join: Option<&Join<'_>>,
    first: usize,
    items: &mut [T],
    pass: &(impl Fn(usize, &mut [T]) + Sync),
) {
    if items.len() <= FINE {
        return pass(first, items);
    }
    let (left, right) = items.split_at_mut(items.len() / 2);
    let middle = first + left.len();
    both(join, || parts(join, first, left, pass), || parts(join, middle, right, pass));
}

/// Calls `task` on each item.
pub(crate) fn each<T: Send>(
    join: Option<&Join<'_>>,
    items: &mut [T],
    task: &(impl Fn(&mut T) + Sync),
) {
    match items {
        [] => (),
        [item] => task(item),
        _ => {
            let (left, right) = items.split_at_mut(items.len() / 2);
            both(join, || each(join, left, task), || each(join, right, task));
        }
    }
}

/// Divides a slice at `middle`, or at its end if that comes before: builds that run out of nodes go on counting.
#[inline]
pub(crate) fn split<T>(slice: &mut [T], middle: usize) -> (&mut [T], &mut [T]) {
    slice.split_at_mut(middle.min(slice.len()))
}
