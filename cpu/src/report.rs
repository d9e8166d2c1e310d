//! Counts and durations of a frame: the figures that the paper plots.

use pfront_core::bvtt::Work;
use pfront_core::front::FrontReport;
use std::ops::Add;
use std::time::Duration;

/// The part of one worker.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Share {
    /// The cost it was predicted to have, in box tests.
    pub predicted: f64,
    /// The work that the worker did.
    pub work: Work,
}

/// Counts and durations of a frame of a [`Traversal`](crate::Traversal). Under [`Static`](crate::Schedule::Static) the counts are the
/// same on every machine and for any number of threads. Durations are measured.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Report {
    /// The work of the calling thread before others were called; all work, if the frame ended there.
    pub alone: Work,
    /// Each worker, none if others were not called.
    pub shares: Vec<Share>,
    /// Whether the deadline came before the end.
    pub late: bool,
    /// Whether the cancel flag was seen before the end, even if it has been cleared since.
    pub cancelled: bool,
    /// The outcome of refinement: its certificate, and whether the costs of the last frame were used. Its box tests
    /// are not part of the shares.
    pub front: FrontReport,
    /// Nodes of the p-partition front, N_p; 0 where there was none.
    pub nodes: usize,
    /// Bytes of memory held for fronts and their costs; this front uses 80 per node.
    pub front_bytes: usize,
    /// The time to generate and partition the front.
    pub front_time: Duration,
    /// The time of the traversal; zero for a frame that ended within its first 512 tests.
    pub traversal_time: Duration,
    /// The part of it before others were called.
    pub alone_time: Duration,
    /// The mean time over the threads from their call until they began; part of the traversal, and zero where none were
    /// called.
    pub waking_time: Duration,
    /// The mean time over the threads in which they were busy with the traversal after others were called; zero where
    /// none were. In the rest they waited for the last one.
    pub busy_time: Duration,
    /// The time to merge the sorted lists of the threads, where others than the calling thread were called.
    pub gather_time: Duration,
}

impl Report {
    /// The measured imbalance: busiest worker over mean, in counted cost; 1 where there was nothing to divide.
    #[must_use]
    pub fn imbalance(&self) -> f64 {
        let costs = || self.shares.iter().map(|share| share.work.cost());
        let total: f64 = costs().sum();
        let busiest = costs().fold(0.0, f64::max);
        if total > 0.0 { busiest * self.shares.len() as f64 / total } else { 1.0 }
    }

    /// All box and triangle tests, those for the front included.
    #[must_use]
    pub fn work(&self) -> Work {
        let front = Work { box_tests: self.front.box_tests, triangle_tests: 0 };
        let shares = self.shares.iter().map(|share| share.work);
        shares.chain([self.alone]).fold(front, Work::add)
    }

    /// Adds a frame that continues this one: counts and durations are summed, maxima are kept of values
    /// that do not add up, and the sum is coherent if both frames are.
    pub fn add(&mut self, next: &Self) {
        self.shares.resize(self.shares.len().max(next.shares.len()), Share::default());
        for (share, more) in self.shares.iter_mut().zip(&next.shares) {
            share.predicted += more.predicted;
            share.work = share.work + more.work;
        }
        self.alone = self.alone + next.alone;
        self.late |= next.late;
        self.cancelled |= next.cancelled;
        let FrontReport { coherent, epsilon, full, box_tests } = next.front;
        self.front = FrontReport {
            coherent: self.front.coherent && coherent,
            epsilon: self.front.epsilon.max(epsilon),
            full: self.front.full || full,
            box_tests: self.front.box_tests + box_tests,
        };
        self.nodes += next.nodes;
        self.front_bytes = self.front_bytes.max(next.front_bytes);
        self.front_time += next.front_time;
        self.traversal_time += next.traversal_time;
        self.alone_time += next.alone_time;
        self.waking_time += next.waking_time;
        self.busy_time += next.busy_time;
        self.gather_time += next.gather_time;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn work(box_tests: u64, triangle_tests: u64) -> Work {
        Work { box_tests, triangle_tests }
    }

    /// A frame of two workers, the second with three times the work of the first.
    fn frame() -> Report {
        let share = |predicted, work| Share { predicted, work };
        let (nodes, front_bytes, late) = (7, 560, true);
        let front = FrontReport { coherent: true, epsilon: 0.5, full: false, box_tests: 4 };
        let shares = vec![share(1.0, work(10, 20)), share(2.0, work(30, 60))];
        let time = Duration::from_millis(3);
        let times = Report { front_time: time, gather_time: time, ..Report::default() };
        Report { alone: work(1, 2), shares, late, front, nodes, front_bytes, ..times }
    }

    #[test]
    fn a_report_counts_all_work_and_compares_the_busiest_with_the_mean() {
        assert_eq!(frame().work(), work(4 + 1 + 40, 2 + 80));
        assert!((frame().imbalance() - 1.5).abs() < 1e-12);
        assert_eq!(Report::default().imbalance(), 1.0);
    }

    #[test]
    fn reports_add_up_and_keep_maxima() {
        let (mut sum, mut next) = (frame(), frame());
        next.shares.push(Share { predicted: 4.0, work: work(5, 6) });
        (next.front.coherent, next.front.epsilon, next.front.full) = (false, 0.75, true);
        (next.front_bytes, next.late, next.cancelled) = (400, false, true);
        sum.add(&next);
        let shares: Vec<_> = sum.shares.iter().map(|share| (share.predicted, share.work)).collect();
        assert_eq!(shares, [(2.0, work(20, 40)), (4.0, work(60, 120)), (4.0, work(5, 6))]);
        assert_eq!((sum.alone, sum.nodes, sum.front_bytes), (work(2, 4), 14, 560));
        let FrontReport { coherent, epsilon, full, box_tests } = sum.front;
        assert_eq!((coherent, epsilon, full, box_tests), (false, 0.75, true, 8));
        assert!(sum.late && sum.cancelled);
        assert_eq!([sum.front_time, sum.gather_time], [Duration::from_millis(6); 2]);
    }
}
