//! One run of the passes: recording it, and reading what it found.
//!
//! All passes of a run are known before it starts: the depth of both trees bounds how many it takes to
//! get to the bottom. What a pass works on is counted on the device, so a run is one submission with
//! nothing read back in between.

use crate::answer::GpuVerb;
use crate::clock::{Clock, Timing};
use crate::gpu::{Descent, Gpu, OfShadows};
use crate::groups::{Dispatches, Groups, Meshes};
use crate::layout::{Counters, Query, Rest};
use crate::lists::{Lists, ORDERED_AT};
use crate::memory::Usage;
use crate::pass::Named;
use crate::read::{Mapping, read_now};
use crate::sequence::groups_for;
use crate::staging::Staging;
use crate::{GpuError, GpuModel, GpuSettings};
use bytemuck::Zeroable;
use pfront_core::bvtt::TrianglePair;
use pfront_shaders::constants::{ANY_EACH, BEAM, BUCKETS, COUNT_EACH, FEW, FRONTS, GROUP, RANKERS};
use std::mem::offset_of;
use std::ops::Range;
use std::sync::Arc;
use wgpu::{Buffer, CommandEncoder, MapMode, WriteOnly};

/// A node pair as fronts hold it.
pub(crate) type Entry = [u32; 2];

/// A question about the models that are bound. The engine fills in the capacities.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Task {
    pub(crate) query: Query,
    /// The root of the BVTT.
    pub(crate) root: Entry,
    /// Levels of the BVTT.
    pub(crate) levels: u32,
    /// The same below the seeds.
    pub(crate) levels_below_seeds: u32,
}

/// Where a run starts.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Start<'a> {
    /// All pairs of seeds.
    Seeds,
    /// These node pairs.
    Front(&'a [Entry]),
    /// The front of this index, left over by a run that counted this. Its results stay.
    Left(u32, &'a Counters),
}

/// The passes that put hits in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Order {
    /// No pass: any order will do.
    None,
    /// One pass, which leaves more than [`FEW`] as they are.
    Few,
    /// As many as there may be.
    Many,
}

impl Order {
    /// What suits so many hits, if they are all wanted.
    fn new(verb: GpuVerb, hits: u32) -> Self {
        match verb {
            GpuVerb::All if hits <= FEW => Self::Few,
            GpuVerb::All => Self::Many,
            GpuVerb::Any | GpuVerb::Count | GpuVerb::AnyEach | GpuVerb::CountEach => Self::None,
        }
    }
}

/// A run that has been recorded.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    ticket: u32,
    /// The front after the last pass, which is empty if the run got to the bottom.
    pub(crate) last_front: u32,
    /// How many hits, and how many of the rest, are copied for the host.
    copied: [u32; 2],
    /// Hits that are copied, of a run that counts no more.
    most_hits: u32,
}

/// The results of a run, as far as they were copied.
#[derive(Debug)]
pub(crate) struct Found {
    pub(crate) counters: Counters,
    pub(crate) rest: Vec<Rest>,
}

/// Runs passes over the lists of one query.
#[derive(Debug)]
pub(crate) struct Engine {
    pub(crate) gpu: Gpu,
    pub(crate) lists: Lists,
    depth: u32,
    workgroups: u32,
    descent: Arc<Descent>,
    /// What takes the place of some of them about shadows, once there was a question about some.
    shadows: Option<Arc<OfShadows>>,
    groups: Groups,
    meshes: Option<Meshes>,
    /// Hits of each pair of instances.
    pub(crate) tallies: Option<Buffer>,
    ticket: u32,
    staging: Staging,
    read_back: Buffer,
    /// If the host has begun to read.
    mapping: Option<Mapping>,
    /// If times are wanted.
    clock: Option<Clock>,
}

impl Engine {
    /// An engine for queries about two meshes or one.
    pub(crate) fn new(gpu: &Gpu, settings: &GpuSettings) -> Result<Self, GpuError> {
        Self::with_passes(gpu, settings, gpu.passes().meshes.clone())
    }

    pub(crate) fn with_passes(
        gpu: &Gpu,
        settings: &GpuSettings,
        descent: Arc<Descent>,
    ) -> Result<Self, GpuError> {
        let lists = Lists::new(gpu, settings)?;
        Ok(Self {
            gpu: gpu.clone(),
            depth: settings.depth.max(1),
            workgroups: settings.groups.clamp(1, 65_535),
            groups: Groups::new(gpu, &descent, &lists)?,
            descent,
            shadows: None,
            meshes: None,
            tallies: None,
            ticket: 0,
            staging: Staging::default(),
            read_back: gpu.buffer("the read-back", 4096, Usage::ReadBack)?,
            mapping: None,
            clock: None,
            lists,
        })
    }

    /// Keeps time from now on, if the device can: of each pass, or of all together.
    pub(crate) fn keep_time(&mut self, each: bool) -> Result<(), GpuError> {
        self.clock = Clock::new(&self.gpu, each)?;
        Ok(())
    }

    /// Forgets the times of the last run: the last question took no pass.
    pub(crate) fn forget_times(&mut self) {
        if let Some(clock) = &mut self.clock {
            clock.forget();
        }
    }

    /// The passes of the last run and their times.
    pub(crate) fn timings(&self) -> Result<Vec<Timing>, GpuError> {
        Clock::read(self.clock.as_ref(), &self.gpu)
    }

    /// Makes two models those of the runs to come.
    pub(crate) fn bind(&mut self, a: &GpuModel, b: &GpuModel) -> Result<(), GpuError> {
        if [a.device, b.device] != [self.gpu.id(); 2] {
            return Err(GpuError::OtherDevice);
        }
        let buffers = [
            ("nodes_a", &a.nodes),
            ("nodes_b", &b.nodes),
            ("corners_a", &a.corners),
            ("corners_b", &b.corners),
            ("order_a", &a.order),
            ("order_b", &b.order),
            ("seeds_a", &a.seeds),
            ("seeds_b", &b.seeds),
        ];
        self.bind_buffers([a.id, b.id], &buffers)
    }

    /// Has the passes ready for questions about shadows.
    pub(crate) fn ready_for_shadows(&mut self) -> Result<(), GpuError> {
        if self.shadows.is_none() {
            self.shadows = Some(self.gpu.shadows()?);
        }
        Ok(())
    }

    /// The ids of what is bound.
    pub(crate) fn bound(&self) -> [u64; 2] {
        self.meshes.as_ref().map_or([u64::MAX; 2], |meshes| meshes.ids)
    }

    /// The same for buffers by their names in the shaders, of which these ids are the only ones.
    pub(crate) fn bind_buffers(
        &mut self,
        ids: [u64; 2],
        buffers: Named<'_>,
    ) -> Result<(), GpuError> {
        if self.meshes.as_ref().is_none_or(|bound| bound.ids != ids) {
            self.meshes = Some(Meshes::new(&self.gpu, &self.descent, ids, buffers)?);
        }
        Ok(())
    }

    /// Records a run, and copies of so many hits, sorted if all are wanted, and so many of the rest.
    ///
    /// Where any hit will do, a run along a narrow beam of node pairs goes first. If it finds a hit, the
    /// passes of the whole run have nothing to do. Where any hit of each pair of instances will do, `dive` goes first.
    pub(crate) fn record(
        &mut self,
        encoder: &mut CommandEncoder,
        task: &Task,
        start: Start<'_>,
        copies: [u32; 2],
        verb: GpuVerb,
    ) -> Result<Run, GpuError> {
        // A pass reads the front of its own index and writes the next.
        let (first, levels) = match start {
            Start::Seeds => (0, task.levels_below_seeds),
            Start::Front(_) => (0, task.levels),
            // Front p is in buffer p mod 2.
            Start::Left(front, _) => (front % 2, task.levels),
        };
        let is_new = !matches!(start, Start::Left(..));
        let dives = u32::from(verb == GpuVerb::AnyEach && is_new);
        let passes = levels.div_ceil(self.depth).clamp(1, FRONTS - 1 - dives - first);
        let (levels, last_front) = (levels.div_ceil(passes), first + dives + passes);
        self.ticket = self.ticket.wrapping_add(1);
        let one_hit = u32::from(verb == GpuVerb::Any);
        let each = match verb {
            GpuVerb::AnyEach => ANY_EACH,
            GpuVerb::CountEach => COUNT_EACH,
            GpuVerb::All | GpuVerb::Any | GpuVerb::Count => 0,
        };
        let last_pass = last_front - 1;
        let whole = Query { levels, last_pass, one_hit, each, beam: u32::MAX, ..task.query };
        if let Some(tallies) = self.tallies.as_ref().filter(|_| each != 0 && is_new) {
            encoder.clear_buffer(tallies, 0, None);
        }
        let looks_ahead = verb == GpuVerb::Any && is_new;
        if looks_ahead {
            // No pass of it goes to the bottom at once, which all together do.
            let beam = Query { beam: BEAM, last_pass: u32::MAX, ..whole };
            self.prepare(encoder, beam, start, 0)?;
            self.dispatch(encoder, task, start, first..last_front, None);
        }
        let kept = if looks_ahead { offset_of!(Counters, overflow) } else { 0 };
        self.prepare(encoder, whole, start, kept)?;
        let order = Order::new(verb, copies[0]);
        self.dispatch(encoder, task, start, first..last_front, Some((verb, order)));
        if let Some(clock) = &self.clock {
            clock.finish(encoder);
        }
        let (copied, most_hits) = self.copy(encoder, copies, order)?;
        Ok(Run { ticket: self.ticket, last_front, copied, most_hits })
    }

    /// Records the passes of a run. Without a verb, it is one whose time does not count.
    fn dispatch(
        &mut self,
        encoder: &mut CommandEncoder,
        task: &Task,
        start: Start<'_>,
        passes: Range<u32>,
        verb: Option<(GpuVerb, Order)>,
    ) {
        let (verb, order) = verb.unzip();
        let Self { gpu, descent, shadows, groups, workgroups, clock, .. } = self;
        let (narrow, decide) = match shadows.as_ref().filter(|_| task.query.shadows != 0) {
            Some(shadows) => (&shadows.narrow, &shadows.decide),
            None => (&descent.narrow, &descent.decide),
        };
        let shaders = gpu.passes();
        let mut dispatches = Dispatches::begin(encoder, clock.as_mut().filter(|_| verb.is_some()));
        let Some(Meshes { groups: meshes, .. }) = &self.meshes else { return };
        let lists = &groups.lists;
        let first = [&meshes.first, &lists.first, &groups.first_step];
        let of_decide = [&meshes.decide, &lists.decide];
        for index in passes {
            match start {
                Start::Seeds if index == 0 => {
                    let [x, y] = task.query.seeds;
                    dispatches.add(&descent.first, &first, (*workgroups).min(x * y));
                }
                Start::Front(front) if index == 0 && verb == Some(GpuVerb::AnyEach) => {
                    dispatches.add(&descent.first, &first, groups_for(front.len() as u32));
                    // Triangle pairs that f32 left open may settle pairs of bodies before more is done about these.
                    dispatches.add(decide, &of_decide, *workgroups);
                }
                _ => {
                    let groups = [&meshes.expand, &lists.expand, &groups.steps[index as usize]];
                    dispatches.add(&descent.expand, &groups, *workgroups);
                }
            }
        }
        dispatches.add(narrow, &[&meshes.narrow, &lists.narrow], *workgroups);
        dispatches.add(decide, &of_decide, *workgroups);
        match order {
            None | Some(Order::None) => {}
            Some(Order::Few) => {
                dispatches.add(&shaders.order, &[&groups.order], FEW * RANKERS / GROUP);
            }
            Some(Order::Many) => {
                let [sample, deal, settle] = &groups.sort;
                dispatches.add(&shaders.sample, &[sample], BUCKETS * RANKERS / GROUP);
                dispatches.add(&shaders.deal, &[deal], *workgroups);
                dispatches.add(&shaders.settle, &[settle], BUCKETS);
            }
        }
    }

    /// Records what a run starts from: parameters, a front, and the counters but for those before byte
    /// `kept`. They are copied from a buffer of their own, so that it does not matter which encoders have
    /// been recorded or submitted in between.
    fn prepare(
        &mut self,
        encoder: &mut CommandEncoder,
        query: Query,
        start: Start<'_>,
        kept: usize,
    ) -> Result<(), GpuError> {
        let mut counters = Counters { ticket: self.ticket, ..Counters::zeroed() };
        let mut front: &[Entry] = &[];
        match start {
            Start::Seeds => {}
            Start::Front(own) => {
                counters.fronts[0] = own.len() as u32;
                front = own;
            }
            Start::Left(front, before) => {
                counters.fronts[front as usize % 2] = before.fronts[front as usize];
                (counters.hits, counters.rest) = (before.hits, before.rest);
            }
        }
        let query = self.lists.capacities.in_query(query);
        let parts = [
            (&self.lists.counters, kept, &bytemuck::bytes_of(&counters)[kept..]),
            (&self.lists.query, 0, bytemuck::bytes_of(&query)),
            (&self.lists.fronts[0], 0, bytemuck::cast_slice(front)),
        ];
        let contents = parts.map(|(.., bytes)| bytes).concat();
        let write = |mut view: WriteOnly<'_, [u8]>| view.copy_from_slice(&contents);
        let source = self.staging.write(&self.gpu, contents.len() as u64, write)?;
        let mut from = 0;
        for (to, at, bytes) in parts {
            let size = bytes.len() as u64;
            if size != 0 {
                encoder.copy_buffer_to_buffer(&source, from, to, at as u64, size);
            }
            from += size;
        }
        Ok(())
    }

    /// Records that bytes, a multiple of 4, are copied to the begin of a buffer.
    pub(crate) fn write(
        &mut self,
        encoder: &mut CommandEncoder,
        to: &Buffer,
        bytes: &[u8],
    ) -> Result<(), GpuError> {
        let size = bytes.len() as u64;
        let fill = |mut view: WriteOnly<'_, [u8]>| view.copy_from_slice(bytes);
        let source = self.staging.write(&self.gpu, size, fill)?;
        encoder.copy_buffer_to_buffer(&source, 0, to, 0, size);
        Ok(())
    }

    /// Forgets what was recorded into an encoder that may never be submitted.
    pub(crate) fn forget_recorded(&mut self) {
        self.staging.forget();
    }

    /// Copies counters and results for the host.
    fn copy(
        &mut self,
        encoder: &mut CommandEncoder,
        most: [u32; 2],
        order: Order,
    ) -> Result<([u32; 2], u32), GpuError> {
        let capacities = &self.lists.capacities;
        let copied = [most[0].min(capacities.hits), most[1].min(capacities.rest)];
        let [hits_at, rest_at, end] = offsets(copied);
        // A run that nobody has read to the end leaves a buffer that wgpu 30 may map once that run is done, even if it was
        // unmapped and is to be mapped after this one.
        let is_lent = self.mapping.take().is_some();
        if is_lent || self.read_back.size() < end {
            // Half as much again, so that answers that grow do not replace it each time.
            self.read_back = self.gpu.buffer("the read-back", end + end / 2, Usage::ReadBack)?;
        }
        let mut copy = |from: &Buffer, at: u64, bytes: u64| {
            if bytes != 0 {
                encoder.copy_buffer_to_buffer(from, 0, &self.read_back, at, bytes);
            }
        };
        let few = FEW.min(capacities.hits);
        if order == Order::Few {
            copy(&self.lists.counters, 0, rest_at);
        } else {
            copy(&self.lists.counters, 0, size_of::<Counters>() as u64);
            copy(&self.lists.hits, hits_at, rest_at - hits_at);
        }
        copy(&self.lists.rest, rest_at, end - rest_at);
        if order == Order::Few {
            let bytes = u64::from(few) * size_of::<TrianglePair>() as u64;
            let Lists { counters, hits, .. } = &self.lists;
            encoder.copy_buffer_to_buffer(counters, ORDERED_AT, hits, 0, bytes);
        }
        Ok((copied, if order == Order::Few { few } else { u32::MAX }))
    }

    /// Has buffers ready for the next run: all that was recorded has been submitted.
    pub(crate) fn submitted(&mut self) {
        self.staging.submitted(&self.gpu);
    }

    /// Whether a run is done, which must have been submitted.
    pub(crate) fn is_done(&mut self, run: &Run) -> Result<bool, GpuError> {
        let Self { gpu, read_back, mapping, .. } = self;
        let [.., end] = offsets(run.copied);
        let begin = || Mapping::begin(gpu.device(), read_back, end, MapMode::Read);
        mapping.get_or_insert_with(begin).is_done(gpu.device())
    }

    /// Waits for a run, and for nothing that was submitted later; adds the hits to `pairs`.
    pub(crate) fn read(
        &mut self,
        run: &Run,
        pairs: &mut Vec<TrianglePair>,
    ) -> Result<Found, GpuError> {
        let [hits_at, rest_at, end] = offsets(run.copied).map(|at| at as usize);
        let (device, bytes) = (self.gpu.device(), end as u64);
        let begin = || Mapping::begin(device, &self.read_back, bytes, MapMode::Read);
        let mapping = self.mapping.take().unwrap_or_else(begin);
        let found = mapping.read(device, &self.read_back, bytes, |bytes| {
            let counters = &bytes[..size_of::<Counters>()];
            let counters: Counters = bytemuck::pod_read_unaligned(counters);
            // Too many to be put in order are all copied later.
            let copied = if counters.hits <= run.most_hits { run.copied[0] } else { 0 };
            let hits = counters.hits.min(copied) as usize;
            let rest = (counters.rest as usize * size_of::<Rest>()).min(end - rest_at);
            let copied = &bytes[hits_at..][..hits * size_of::<TrianglePair>()];
            match bytemuck::try_cast_slice(copied) {
                Ok(copied) => pairs.extend_from_slice(copied),
                // Nothing says how mapped memory is aligned.
                Err(_) => pairs.extend(bytemuck::pod_collect_to_vec::<_, TrianglePair>(copied)),
            }
            Found { counters, rest: bytemuck::pod_collect_to_vec(&bytes[rest_at..][..rest]) }
        });
        self.gpu.check()?;
        let found = found?;
        if found.counters.ticket != run.ticket {
            return Err(GpuError::NotSubmitted);
        }
        Ok(found)
    }

    /// All children of some node pairs, leaf pairs among them staying what they are.
    pub(crate) fn refine(&mut self, task: &Task, front: &[Entry]) -> Result<Vec<Entry>, GpuError> {
        let mut encoder = self.gpu.device().create_command_encoder(&Default::default());
        self.ticket = self.ticket.wrapping_add(1);
        let query = Query { levels: 1, last_pass: u32::MAX, beam: u32::MAX, ..task.query };
        self.prepare(&mut encoder, query, Start::Front(front), 0)?;
        let Self { gpu, descent, groups, lists, .. } = self;
        if let Some(Meshes { groups: meshes, .. }) = &self.meshes {
            let all = [&meshes.expand, &groups.lists.expand, &groups.refine];
            Dispatches::begin(&mut encoder, None).add(&descent.expand, &all, self.workgroups);
        }
        let (device, queue) = (gpu.device(), gpu.queue());
        let [counters]: [Counters; 1] = read_now(device, queue, encoder, &lists.counters, 1)?
            .try_into()
            .map_err(|_| GpuError::NotSubmitted)?;
        let encoder = device.create_command_encoder(&Default::default());
        read_now(device, queue, encoder, &lists.fronts[1], counters.fronts[1] as usize)
    }
}

/// Where hits and the rest begin in the read-back buffer, and where they end. Few hits in order are as far from the counters
/// on the device.
fn offsets([hits, rest]: [u32; 2]) -> [u64; 3] {
    let hits_at = ORDERED_AT;
    let rest_at = hits_at + u64::from(hits) * size_of::<TrianglePair>() as u64;
    [hits_at, rest_at, rest_at + u64::from(rest) * size_of::<Rest>() as u64]
}
