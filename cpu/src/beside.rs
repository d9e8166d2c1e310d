//! Who a front is for where workers are not alone: the share of it that a device takes, such as a GPU.
//!
//! Zhang & Kim 2014 leave the hybrid of CPU and GPU to future work. Here both walk parts of one front. A
//! device takes whole nodes, of all sizes in the same proportion: it spreads what is below them over its
//! threads by itself, and workers get what is left of each size to balance their loads with.
//!
//! What a node costs that a device walks is not counted. It is taken to be what it was expected to be, on the
//! scale of what the others turned out to cost; and the choice moves on from frame to frame, so that workers
//! come by every node in its turn, and measure it.

use pfront_core::front::FrontNode;

/// The [`FrontNode::part`] of nodes for the device.
pub(crate) const DEVICE: u32 = u32::MAX;

/// A front is made for at most so many times the number of workers: a share of nearly everything leaves
/// little to balance.
const MOST_PARTS: f64 = 4.0;

/// Who walks a front: p workers, and a device that takes a share of its cost.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crew {
    pub(crate) workers: usize,
    /// 0 to 1.
    pub(crate) share: f64,
}

impl Crew {
    /// Workers alone.
    pub(crate) fn of(workers: usize) -> Self {
        Self { workers, share: 0.0 }
    }

    /// The same beside a device.
    pub(crate) fn beside(self, share: f64) -> Self {
        Self { share: if share.is_nan() { 0.0 } else { share.clamp(0.0, 1.0) }, ..self }
    }

    /// How many workers would each get as much of the whole as these get of their part of it.
    pub(crate) fn parts(self) -> usize {
        let workers = self.workers as f64;
        (workers / (1.0 - self.share)).min(MOST_PARTS * workers).ceil() as usize
    }
}

/// Chooses nodes for a device that is to get `share` of their cost, 0 to 1, from those that are in order,
/// dearest first. Moves them to the end, and returns how many stay before them, in order.
///
/// The cost of the choice differs from `share` of the whole by less than the dearest node, and about by one of
/// the cheapest where there are many of each size.
pub(crate) fn choose(nodes: &mut [FrontNode], share: f64, frame: u32) -> usize {
    // The device takes a node as soon as it is owed this much of it. Multiples of the golden ratio leave no
    // part of (0, 1] out for long.
    let due_from = 1.0 - (f64::from(frame) * 0.618_033_988_749_895).fract();
    let (mut owed, mut stay) = (0.0, 0);
    for i in 0..nodes.len() {
        let cost = f64::from(nodes[i].cost);
        owed += share * cost;
        if owed >= due_from * cost {
            owed -= cost;
            nodes[i].part = DEVICE;
        } else {
            nodes.swap(stay, i);
            stay += 1;
        }
    }
    stay
}

#[cfg(test)]
mod tests {
    use super::*;
    use pfront_core::front::dearest_first;

    fn nodes(costs: impl IntoIterator<Item = f32>) -> Vec<FrontNode> {
        let node = |(cost, index)| FrontNode { cost, index, ..FrontNode::default() };
        let mut nodes: Vec<_> = costs.into_iter().zip(0..).map(node).collect();
        dearest_first(&mut nodes);
        nodes
    }

    fn cost(nodes: &[FrontNode]) -> f64 {
        nodes.iter().map(|node| f64::from(node.cost)).sum()
    }

    #[test]
    fn a_device_gets_its_share_and_no_node_is_lost() {
        let sizes = |i: u32| 1.0 + (i * 7919 % 1000) as f32;
        for (share, off) in
            [(0.0, 0.0), (0.02, 200.0), (0.1, 40.0), (0.5, 8.0), (0.9, 40.0), (1.0, 0.0)]
        {
            for frame in 0..50 {
                let mut front = nodes((0..300).map(sizes));
                let whole = cost(&front);
                let stay = choose(&mut front, share, frame);
                let (own, device) = front.split_at(stay);
                assert!((cost(device) - share * whole).abs() <= off, "{share} {frame}");
                assert!(device.iter().all(|node| node.part == DEVICE));
                assert!(own.is_sorted_by(|x, y| x.cost >= y.cost));
                let mut indices: Vec<_> = front.iter().map(|node| node.index).collect();
                indices.sort_unstable();
                assert!(indices.into_iter().eq(0..300));
            }
        }
    }

    #[test]
    fn every_node_has_its_turn() {
        for share in [0.1, 0.5, 0.9] {
            let mut walked = [0; 40];
            for frame in 0..100 {
                let mut front = nodes([8.0; 40]);
                let stay = choose(&mut front, share, frame);
                front[..stay].iter().for_each(|node| walked[node.index as usize] += 1);
            }
            let expected = 100.0 * (1.0 - share);
            for times in walked {
                assert!((f64::from(times) - expected).abs() < 0.5 * expected, "{share}: {times}");
            }
        }
    }

    #[test]
    fn any_share_is_one() {
        for share in [f64::NAN, -1.0, f64::NEG_INFINITY] {
            assert_eq!(Crew::of(3).beside(share).share, 0.0);
        }
        assert_eq!(Crew::of(3).beside(f64::INFINITY).share, 1.0);
        let parts = [0.0, 0.1, 0.5, 0.9, 1.0].map(|share| Crew::of(6).beside(share).parts());
        assert_eq!(parts, [6, 7, 12, 24, 24]);
    }
}
