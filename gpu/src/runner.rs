//! Answering a question in one run, or in as many as the budget makes necessary.
//!
//! A run whose lists overflow, or which is too much work for a workgroup, is dropped, and what it
//! started from is divided: a few node pairs are replaced by their children, many are split.
//! Counters count on beyond what lists hold, so one failed run tells into how many parts. A single
//! leaf pair always fits ([`Budget::LEAST`]), so this ends, and the parts together are the whole
//! answer.
//!
//! [`Budget::LEAST`]: crate::Budget::LEAST

use crate::ahead::Ahead;
use crate::engine::Engine;
use crate::layout::{Body, Counters, Query, Rest, Row};
use crate::memory::reserve;
use crate::read::read_now;
use crate::refit::Refit;
use crate::results::{Found, MappedHits, Run};
use crate::task::{Entry, GpuVerb, Start, Task};
use crate::{GpuError, GpuReport, totals, wear};
use pfront_core::bvtt::TrianglePair;
use pfront_core::triangle::{Adjacency, intersects, intersects_in_mesh};
use pfront_core::{Mesh, Pose};
use pfront_shaders::constants::{HIT_OVERFLOW, LEAF, REST_OVERFLOW};
use std::sync::Arc;
use wgpu::CommandEncoder;

/// A front this long is split rather than refined. Its children fit in the least front.
const LONG: usize = 64;

/// As many triangle pairs are decided on the CPU in the time that the device takes for a dispatch that finds little to do: some
/// microseconds.
const FEW_OPEN: u32 = 64;

/// An engine, the runs that it answers in, and the answer so far.
#[derive(Debug)]
pub(crate) struct Runner {
    pub(crate) engine: Engine,
    /// Commands for the next question, if they are recorded.
    ahead: Option<Ahead>,
    /// The pairs found so far, if they are wanted and not shown where they are mapped.
    pairs: Vec<TrianglePair>,
    /// Pairs that the CPU decided, until they join `pairs`.
    late: Vec<TrianglePair>,
    /// Pairs that the device left open for the host.
    pub(crate) open: Vec<TrianglePair>,
    pub(crate) count: u64,
    pub(crate) report: GpuReport,
    /// The instances that are asked about, and their pairs by blocks of ids.
    pub(crate) bodies: Arc<Vec<Body>>,
    pub(crate) rows: Vec<Row>,
    /// Hits of each of them that the device has decided, if they are wanted of each.
    pub(crate) tallies: Vec<u64>,
    /// How many hits, and how many of the rest, the last answers had: about what the next will have at most.
    expected: [u32; 2],
    /// The parts of the last question that was too much for one run.
    division: Option<Division>,
}

/// A question that has been recorded.
#[derive(Debug)]
pub(crate) struct Asked {
    pub(crate) task: Task,
    /// Its parts, of which the last is what the run is about.
    pub(crate) parts: Vec<Vec<Entry>>,
    pub(crate) run: Run,
    /// Whether its commands are worth recording ahead, for the same question in another pose.
    may_repeat: bool,
}

/// Parts that are a front of a BVTT.
#[derive(Debug)]
struct Division {
    /// The models, and whether it is one with itself.
    about: ([u64; 2], u32),
    parts: Vec<Vec<Entry>>,
}

impl Asked {
    /// A question that is asked in one part.
    fn whole(task: Task, run: Run) -> Self {
        Self { task, parts: vec![vec![task.root]], run, may_repeat: false }
    }
}

impl Runner {
    pub(crate) fn new(engine: Engine) -> Self {
        Self {
            engine,
            ahead: None,
            pairs: Vec::new(),
            late: Vec::new(),
            open: Vec::new(),
            count: 0,
            report: GpuReport::default(),
            bodies: Arc::default(),
            rows: Vec::new(),
            tallies: Vec::new(),
            expected: [1024, 16],
            division: None,
        }
    }

    /// The answer about nothing.
    pub(crate) fn clear(&mut self) {
        self.reset();
        self.engine.forget_times();
    }

    /// The pairs that were found, if they are wanted.
    pub(crate) fn pairs(&self) -> &[TrianglePair] {
        let shown = self.engine.read_back.shown.as_ref();
        shown.and_then(MappedHits::list).unwrap_or(&self.pairs)
    }

    /// Puts them in place of others.
    pub(crate) fn take_pairs(&mut self, pairs: &mut Vec<TrianglePair>) -> Result<(), GpuError> {
        if let Some(shown) = self.engine.read_back.shown.take() {
            pairs.clear();
            return shown.copy(pairs);
        }
        std::mem::swap(&mut self.pairs, pairs);
        Ok(())
    }

    fn reset(&mut self) {
        self.engine.read_back.shown = None;
        self.pairs.clear();
        self.late.clear();
        self.open.clear();
        self.count = 0;
        self.tallies.clear();
        self.report = GpuReport::default();
    }

    /// Records a run that brings as many results as are likely to be wanted.
    pub(crate) fn record(
        &mut self,
        encoder: &mut CommandEncoder,
        task: &Task,
        start: Start<'_>,
        verb: GpuVerb,
    ) -> Result<Run, GpuError> {
        let copies = match (verb, start) {
            (GpuVerb::AnyEach, Start::Front(front)) => [front.len() as u32, self.expected[1]],
            _ => copies(verb, self.likely()),
        };
        if self.engine.read_back.is_pending() {
            // Commands recorded ahead write into a buffer that this run replaces.
            self.ahead = None;
        }
        self.engine.record(encoder, task, start, copies, verb)
    }

    /// A quarter more than is expected, and some, since few vary more; none where none is.
    fn likely(&self) -> [u32; 2] {
        self.expected.map(|most| if most == 0 { 0 } else { most.saturating_add(most / 4 + 16) })
    }

    /// Submits a question, by commands that were recorded ahead if they suit it.
    pub(crate) fn submit(&mut self, task: Task, verb: GpuVerb) -> Result<Asked, GpuError> {
        self.engine.forget_recorded();
        let may_repeat = self.parts_of(&task, verb).is_none();
        let copies = copies(verb, self.expected);
        let ahead = self.ahead.take_if(|_| may_repeat);
        let ahead = ahead.map(|ahead| ahead.take(&mut self.engine, &task, copies, verb));
        let (commands, asked) = match ahead.transpose()?.flatten() {
            Some((commands, run)) => (commands, Asked::whole(task, run)),
            None => {
                let mut encoder = self.engine.encoder();
                let asked = self.begin(&mut encoder, task, verb)?;
                (encoder.finish(), asked)
            }
        };
        self.engine.submit(commands);
        Ok(Asked { may_repeat, ..asked })
    }

    /// Records the commands of a question again while it is on the device, and those of the refits before it.
    fn record_ahead(
        &mut self,
        asked: &Asked,
        refits: &[Option<Arc<Refit>>; 2],
        verb: GpuVerb,
    ) -> Result<(), GpuError> {
        if !asked.may_repeat || self.engine.read_back.is_done(&asked.run)? {
            return Ok(());
        }
        refits.iter().flatten().for_each(|refit| refit.record_ahead());
        // Times are those of the last run that was recorded.
        if self.ahead.is_some() || self.engine.clock.is_some() {
            return Ok(());
        }
        let (gpu, copies) = (self.engine.gpu.clone(), copies(verb, self.likely()));
        // Without memory for it, the next question is recorded when it is asked.
        let ahead = gpu.checked(|| Ahead::record(&mut self.engine, &asked.task, copies, verb));
        self.ahead = ahead.ok();
        Ok(())
    }

    /// Records a question, in the parts that the last one about the same models was divided into.
    pub(crate) fn begin(
        &mut self,
        encoder: &mut CommandEncoder,
        task: Task,
        verb: GpuVerb,
    ) -> Result<Asked, GpuError> {
        self.engine.forget_recorded();
        match self.parts_of(&task, verb).map(<[_]>::to_vec) {
            Some(parts) => self.begin_parts(encoder, task, parts, verb),
            None => {
                let run = self.record(encoder, &task, Start::Seeds, verb)?;
                Ok(Asked::whole(task, run))
            }
        }
    }

    /// The parts that the last question about the same models was divided into, if it was.
    fn parts_of(&self, task: &Task, verb: GpuVerb) -> Option<&[Vec<Entry>]> {
        let Division { about, parts } = self.division.as_ref()?;
        (*about == self.about(task) && verb != GpuVerb::Any).then_some(parts)
    }

    /// The same from node pairs.
    pub(crate) fn begin_from(
        &mut self,
        encoder: &mut CommandEncoder,
        task: Task,
        front: &[Entry],
        verb: GpuVerb,
    ) -> Result<Asked, GpuError> {
        let most = self.engine.lists.capacities.front as usize;
        let parts = front.chunks(most).rev().map(<[Entry]>::to_vec).collect();
        self.begin_parts(encoder, task, parts, verb)
    }

    fn begin_parts(
        &mut self,
        encoder: &mut CommandEncoder,
        task: Task,
        parts: Vec<Vec<Entry>>,
        verb: GpuVerb,
    ) -> Result<Asked, GpuError> {
        let first = Start::Front(parts.last().map_or(&[], Vec::as_slice));
        let run = self.record(encoder, &task, first, verb)?;
        Ok(Asked { task, parts, run, may_repeat: false })
    }

    fn about(&self, task: &Task) -> ([u64; 2], u32) {
        (self.engine.bound(), task.query.within)
    }

    /// Takes the results of what has been recorded, and sees to it that they are complete.
    pub(crate) async fn finish(&mut self, asked: Asked, verb: GpuVerb) -> Result<(), GpuError> {
        self.reset();
        // An idle query holds no mesh that has gone.
        let refits = std::mem::take(&mut self.engine.refits);
        self.record_ahead(&asked, &refits, verb)?;
        let Asked { task, parts: mut waiting, mut run, .. } = asked;
        let task = &task;
        let mut part = waiting.pop().unwrap_or_default();
        // Parts that are answered, with the share of the lists that each took.
        let mut answered: Vec<(Vec<Entry>, f64)> = Vec::new();
        let mut in_order = true;
        loop {
            let before = self.pairs.len();
            let Engine { read_back, cancel, .. } = &mut self.engine;
            let mut found = read_back.read(&run, cancel.as_deref()).await?;
            self.engine.are_counters_clear = true;
            self.report.add(&found.counters, task.query.leaf_size);
            let Counters { overflow, hits, rest, fronts, .. } = found.counters;
            let refused = match verb {
                GpuVerb::All | GpuVerb::AnyEach => overflow,
                GpuVerb::Any if hits > 0 => 0,
                GpuVerb::Any | GpuVerb::Count | GpuVerb::CountEach => overflow & !HIT_OVERFLOW,
            };
            let is_left =
                fronts[run.last_front as usize] != 0 && !(verb == GpuVerb::Any && hits > 0);
            if refused != 0 || is_left {
                // No buffer of the next run may be mapped.
                found.hits = None;
            }
            if refused & REST_OVERFLOW != 0 && self.engine.is_direct(task) {
                // This pose is not like the one before.
                self.engine.few_open = None;
                run = self.run(task, Start::Front(&part), verb)?;
                continue;
            }
            if refused != 0 {
                let parts = self.divide(task, &part, &found.counters).await?;
                waiting.extend(parts.into_iter().rev());
            } else if is_left {
                run = self.run(task, Start::Left(run.last_front, &found.counters), verb)?;
                continue;
            } else {
                if matches!(verb, GpuVerb::All | GpuVerb::Count) {
                    // Some answers are few by chance: after one of them, as many as before would still be copied.
                    let most = |now: u32, before: u32| now.max(before - before.div_ceil(8));
                    let [before, rest_before] = self.expected;
                    self.expected = [most(hits, before), most(rest, rest_before)];
                }
                let share = self.share(&found.counters);
                let most = self.engine.lists.capacities.front as usize;
                match answered.last_mut() {
                    // Half of the lists remain for what moves until the next question.
                    Some((last, sum)) if *sum + share <= 0.5 && last.len() + part.len() <= most => {
                        last.append(&mut part);
                        *sum += share;
                    }
                    _ => answered.push((std::mem::take(&mut part), share)),
                }
                in_order = before == 0 && found.in_order;
                let is_whole = in_order && waiting.is_empty();
                self.take(task, found, is_whole, verb).await?;
                if verb == GpuVerb::Any && self.count > 0 {
                    break;
                }
            }
            match waiting.pop() {
                Some(next) => part = next,
                None => break,
            }
            run = self.run(task, Start::Front(&part), verb)?;
        }
        totals::add(&self.engine.gpu.counted().box_tests, self.report.box_tests);
        if let Some(wear) = &self.engine.wear {
            wear::add(wear, self.report.box_tests);
        }
        if matches!(verb, GpuVerb::All | GpuVerb::Count) {
            let is_open = self.report.runs > 1 || self.report.open > FEW_OPEN;
            self.engine.few_open = (!is_open).then_some(self.engine.bound());
        }
        if verb != GpuVerb::Any {
            let parts: Vec<_> = answered.into_iter().rev().map(|(part, _)| part).collect();
            let about = self.about(task);
            self.division = (parts.len() > 1).then_some(Division { about, parts });
        }
        if matches!(verb, GpuVerb::All | GpuVerb::Any) {
            reserve(&mut self.pairs, self.late.len())?;
            self.put_in_order(in_order);
        } else {
            reserve(&mut self.pairs, self.late.len())?;
            // Each is of a pair of bodies of its own, or stands for a number.
            self.pairs.append(&mut self.late);
        }
        Ok(())
    }

    /// Records and submits a run.
    pub(crate) fn run(
        &mut self,
        task: &Task,
        start: Start<'_>,
        verb: GpuVerb,
    ) -> Result<Run, GpuError> {
        if self.engine.is_cancelled() {
            return Err(GpuError::Cancelled);
        }
        let gpu = self.engine.gpu.clone();
        gpu.checked(|| {
            let mut encoder = self.engine.encoder();
            let run = self.record(&mut encoder, task, start, verb)?;
            self.engine.submit(encoder.finish());
            Ok(run)
        })
    }

    /// Divides what was too much for one run.
    async fn divide(
        &mut self,
        task: &Task,
        part: &[Entry],
        counters: &Counters,
    ) -> Result<Vec<Vec<Entry>>, GpuError> {
        let is_leaf_pair = |pair: &Entry| pair.iter().all(|node| node & LEAF != 0);
        let mut front = part.to_vec();
        while front.len() < LONG && !front.iter().all(is_leaf_pair) {
            front = self.engine.refine(task, &front).await?;
        }
        if part.len() == 1 && front == part {
            let reason = "a leaf pair overflowed lists that can hold its results".to_owned();
            return Err(GpuError::Device { reason });
        }
        let length = front.len().div_ceil(self.parts(counters).clamp(2, LONG)).max(1);
        Ok(front.chunks(length).map(<[Entry]>::to_vec).collect())
    }

    /// Into how many parts a run has to be divided, by what it counted. Parts are not equal.
    fn parts(&self, counters: &Counters) -> usize {
        self.share(counters).ceil().max(1.0) as usize * 2
    }

    /// The share that a run took, or would have taken, of the list that it filled most.
    fn share(&self, counters: &Counters) -> f64 {
        let c = &self.engine.lists.capacities;
        // A run starts from a front that fits.
        let longest = counters.fronts.iter().skip(1).fold(0, |longest, &front| longest.max(front));
        let demands = [
            (longest, c.front),
            (counters.leaves, c.leaves),
            (counters.hits, c.hits),
            (counters.kept, c.kept),
            (counters.rest, c.rest),
        ];
        let shares = demands.map(|(demand, capacity)| f64::from(demand) / f64::from(capacity));
        shares.into_iter().fold(0.0, f64::max)
    }

    /// Adds what a complete run found. Hits that are all there are, and in order, stay where they are mapped.
    async fn take(
        &mut self,
        task: &Task,
        found: Found,
        is_whole: bool,
        verb: GpuVerb,
    ) -> Result<(), GpuError> {
        let Found { counters, mut rest, hits, .. } = found;
        let (device, queue) = (self.engine.gpu.device(), self.engine.gpu.queue());
        let again = || device.create_command_encoder(&Default::default());
        let (lists, cancel) = (&self.engine.lists, self.engine.cancel.as_deref());
        let is_listed = matches!(verb, GpuVerb::All | GpuVerb::AnyEach);
        let brought = hits.filter(|hits| !is_listed || hits.len() == counters.hits as usize);
        if let Some(hits) = brought {
            let is_alone = counters.rest == 0 && self.late.is_empty();
            let is_shown = is_whole && is_alone && verb == GpuVerb::All;
            if is_shown && hits.list().is_some() {
                self.engine.read_back.shown = Some(hits);
            } else {
                hits.copy(&mut self.pairs)?;
            }
        } else if is_listed {
            let count = counters.hits as usize;
            let list = lists.results(verb);
            let hits = read_now(device, queue, again(), list, count, cancel).await?;
            reserve(&mut self.pairs, hits.len())?;
            self.pairs.extend_from_slice(&hits);
        }
        if rest.len() < counters.rest as usize && (verb != GpuVerb::Any || counters.hits == 0) {
            let count = counters.rest as usize;
            rest = read_now(device, queue, again(), &lists.rest, count, cancel).await?;
        }
        if let (GpuVerb::CountEach, Some(tallies)) = (verb, &self.engine.tallies) {
            let pairs = self.rows.last().map_or(0, |last| last.number as usize + 1);
            let tallies: Vec<u32> =
                read_now(device, queue, again(), tallies, pairs, cancel).await?;
            let more = pairs.saturating_sub(self.tallies.len());
            reserve(&mut self.tallies, more)?;
            self.tallies.resize(pairs, 0);
            (self.tallies.iter_mut().zip(tallies)).for_each(|(sum, own)| *sum += u64::from(own));
        }
        if task.query.certify != 0 {
            let pair = |rest: &Rest| TrianglePair { a: rest.pair[0], b: rest.pair[1] };
            reserve(&mut self.open, rest.len())?;
            self.open.extend(rest.iter().map(pair));
            rest.clear();
        }
        let late = self.late.len();
        reserve(&mut self.late, rest.len())?;
        let (rows, bodies) = (&self.rows, &self.bodies);
        self.late.extend(rest.iter().filter_map(|rest| meet(&task.query, rows, bodies, rest)));
        self.count += u64::from(counters.hits) + (self.late.len() - late) as u64;
        Ok(())
    }

    /// Sorts all pairs, of which those that the device decided may be `in_order`.
    fn put_in_order(&mut self, in_order: bool) {
        let Self { pairs, late, report, .. } = self;
        if !in_order && pairs.len() > 1 {
            report.sorted_on_host = pairs.len() as u64;
            // No hit is there twice, and runs of several parts are merged.
            pairs.sort_by_key(|pair| (u64::from(pair.a) << 32) | u64::from(pair.b));
        }
        late.sort_unstable();
        // From the last on, so that each pair is moved once.
        let mut end = pairs.len();
        pairs.extend_from_slice(late);
        for (before, pair) in late.drain(..).enumerate().rev() {
            let at = pairs[..end].partition_point(|other| *other < pair);
            pairs.copy_within(at..end, at + before + 1);
            pairs[at + before] = pair;
            end = at;
        }
    }
}

/// How many hits, and how many of the rest, are copied where so many are likely.
fn copies(verb: GpuVerb, [hits, rest]: [u32; 2]) -> [u32; 2] {
    match verb {
        GpuVerb::All | GpuVerb::AnyEach => [hits, rest],
        GpuVerb::Any => [1, rest],
        GpuVerb::Count | GpuVerb::CountEach => [0, rest],
    }
}

/// Decides a triangle pair on the CPU.
fn meet(query: &Query, rows: &[Row], bodies: &[Body], rest: &Rest) -> Option<TrianglePair> {
    let [a, b] = rest.pair;
    let poses = match rows.get((a >> query.pair_shift) as usize) {
        Some(row) => row.bodies.map(|body| Some(bodies[body as usize].pose)),
        None => [0, 1].map(|side| (query.posed[side] != 0).then_some(query.sides[side].rows)),
    };
    let mut positions = rest.corners.map(|corner| corner.position);
    for (rows, triangle) in poses.into_iter().zip(positions.chunks_exact_mut(3)) {
        if let Some(pose) = rows.map(Pose::new) {
            triangle.iter_mut().for_each(|p| *p = pose.apply(*p));
        }
    }
    let meet = if query.within == 0 {
        let [p, q, r, u, v, w] = positions;
        intersects(&[p, q, r], &[u, v, w])
    } else {
        // A mesh of two triangles, whose corners are the same vertex where they were.
        let first = |vertex| rest.corners.iter().position(|c| c.vertex == vertex).unwrap_or(0);
        let [p, q, r, u, v, w] = rest.corners.map(|corner| first(corner.vertex) as u32);
        let triangles = [[p, q, r], [u, v, w]];
        let mesh = Mesh::new_unchecked(&positions, &triangles);
        let adjacency = match query.apart {
            0 => Adjacency::SharedIndexRule,
            _ => Adjacency::SkipNeighbours,
        };
        intersects_in_mesh(mesh, 0, 1, adjacency)
    };
    let in_order = query.within == 0 || a < b;
    let pair = if in_order { TrianglePair { a, b } } else { TrianglePair { a: b, b: a } };
    meet.then_some(pair)
}
