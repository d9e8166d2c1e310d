//! Sorting one list.

use crate::memory::resize;

/// Elements that one thread sorts in the time that it takes to call others three times, some 40 us.
pub(crate) const SORTED_ALONE: usize = 4096;

/// Shorter lists are sorted by comparison: they have few elements for each of the 256 counters of a byte.
const RADIX_FROM: usize = 512;

/// Sorts a list that may be sorted already, by keys in the order of its items.
pub(crate) fn sort<T: Copy + Default + Ord>(
    items: &mut [T],
    scratch: &mut Vec<T>,
    key: impl Fn(&T) -> u128,
) {
    if items.len() < RADIX_FROM {
        items.sort_unstable();
    } else if !items.is_sorted() {
        radix_sort(items, scratch, key);
    }
}

/// Sorts by one byte of the key after the other, from the least on, leaving out those in which all keys agree; by comparison
/// where there is no memory for `scratch`.
fn radix_sort<T: Copy + Default + Ord>(
    items: &mut [T],
    scratch: &mut Vec<T>,
    key: impl Fn(&T) -> u128,
) {
    let bits = |(any, all), item: &T| (any | key(item), all & key(item));
    let (any, all) = items.iter().fold((0, u128::MAX), bits);
    if resize(scratch, items.len()).is_err() {
        return items.sort_unstable();
    }
    let (mut from, mut to) = (items, &mut scratch[..]);
    let mut is_in_scratch = false;
    for shift in (0..128).step_by(8).filter(|shift| (any ^ all) >> shift & 255 != 0) {
        let byte = |item: &T| (key(item) >> shift) as usize & 255;
        let mut ends = [0; 256];
        from.iter().for_each(|item| ends[byte(item)] += 1);
        let mut sum = 0;
        ends.iter_mut().for_each(|end| sum += std::mem::replace(end, sum));
        for item in from.iter() {
            let place = &mut ends[byte(item)];
            to[*place] = *item;
            *place += 1;
        }
        std::mem::swap(&mut from, &mut to);
        is_in_scratch = !is_in_scratch;
    }
    if is_in_scratch {
        to.copy_from_slice(from);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Hit;
    use crate::output::Item;
    use pfront_core::bvtt::TrianglePair;
    use pfront_testkit::rng::{RngExt, seeded};

    #[test]
    fn radix_sort_sorts() {
        let mut rng = seeded(1);
        let mut random = |most: u32| rng.random_range(0..most);
        let mut scratch = Vec::new();
        for (count, most) in
            [(0, 1), (1, 1), (600, 1), (700, 300), (5_000, 70_000), (900, u32::MAX)]
        {
            let mut hit = || Hit {
                query: random(most),
                pair: TrianglePair { a: random(most), b: random(most) },
            };
            let mut hits: Vec<Hit> = (0..count).map(|_| hit()).collect();
            let mut expected = hits.clone();
            expected.sort();
            radix_sort(&mut hits, &mut scratch, Item::key);
            assert!(hits == expected, "{count} {most}");
        }
    }
}
