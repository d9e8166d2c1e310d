//! One run of the passes, recorded.
//!
//! All passes of a run are known before it starts: the depth of both trees bounds how many it takes to
//! get to the bottom. The device counts what a pass works on, so a run is one submission with nothing read
//! back in between.

use crate::clock::{Clock, Timing};
use crate::gpu::{Certifying, Descent, Gpu};
use crate::groups::{Dispatches, Groups, Meshes};
use crate::layout::{Counters, Query};
use crate::lists::Lists;
use crate::model::Outside;
use crate::pass::Named;
use crate::read::read_now;
use crate::refit::Refit;
use crate::results::{ReadBack, Run};
use crate::sequence::groups_for;
use crate::staging::Staging;
use crate::task::{Entry, GpuVerb, Order, Start, Task};
use crate::totals::count;
use crate::wear::Wear;
use crate::{GpuError, GpuModel, GpuSettings};
use pfront_shaders::constants::{
    ANY_EACH, BEAM, BUCKETS, COUNT_EACH, FEW, FINER, FRONTS, GROUP, RANKERS,
};
use std::mem::offset_of;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use wgpu::{
    BindGroup, BindingResource, Buffer, BufferBinding, BufferSize, CommandBuffer, CommandEncoder,
    WriteOnly,
};

/// Parameters and, from byte [`COUNTERS_AT`] on, counters that passes begin with: bindings begin at multiples of 256.
const SET: usize = COUNTERS_AT + size_of::<Counters>().next_multiple_of(256);
const COUNTERS_AT: usize = size_of::<Query>().next_multiple_of(256);

/// Runs passes over the lists of one query.
#[derive(Debug)]
pub(crate) struct Engine {
    pub(crate) gpu: Gpu,
    pub(crate) lists: Lists,
    depth: u32,
    workgroups: u32,
    descent: Arc<Descent>,
    /// The passes that replace two of these where the host decides what f32 leaves open, once that was asked.
    certifying: Option<Arc<Certifying>>,
    groups: Groups,
    meshes: Option<Meshes>,
    /// Hits of each pair of instances.
    pub(crate) tallies: Option<Buffer>,
    pub(crate) ticket: u32,
    /// Whether the last pass of a run has left the counters at 0.
    pub(crate) are_counters_clear: bool,
    pub(crate) staging: Staging,
    pub(crate) read_back: ReadBack,
    /// If times are wanted.
    pub(crate) clock: Option<Clock>,
    /// Two models of which f32 left few pairs open in the last question: the next about them is asked without `decide`.
    pub(crate) few_open: Option<[u64; 2]>,
    /// The positions of the models that are bound, where the host has not seen them.
    outside: [Option<Outside>; 2],
    /// The refits of the models that are bound, as far as these move.
    pub(crate) refits: [Option<Arc<Refit>>; 2],
    /// The wear of the models that are bound.
    pub(crate) wear: Option<[Arc<Wear>; 2]>,
    /// Ends a question early once it is set.
    pub(crate) cancel: Option<Arc<AtomicBool>>,
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
            certifying: None,
            meshes: None,
            tallies: None,
            ticket: 0,
            are_counters_clear: true,
            staging: Staging::default(),
            read_back: ReadBack::new(gpu)?,
            clock: None,
            few_open: None,
            outside: [None, None],
            refits: [None, None],
            wear: None,
            cancel: None,
            lists,
        })
    }

    /// Keeps time from now on, if the device can: of each pass, or of all together.
    pub(crate) fn keep_time(&mut self, each: bool) -> Result<(), GpuError> {
        self.clock = Clock::new(&self.gpu, each)?;
        Ok(())
    }

    /// Whether the question is to end early.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.cancel.as_ref().is_some_and(|flag| flag.load(Relaxed))
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
        self.wear = Some([a.wear.clone(), b.wear.clone()]);
        self.outside = [a.outside.clone(), b.outside.clone()];
        self.refits = [a.refit.clone(), b.refit.clone()];
        self.bind_buffers([a.id, b.id], &buffers)
    }

    /// Has the passes ready for questions about shadows, or pairs within a distance.
    pub(crate) fn ready_to_certify(&mut self) -> Result<(), GpuError> {
        if self.certifying.is_none() {
            self.certifying = Some(self.gpu.certifying()?);
        }
        Ok(())
    }

    /// The ids of what is bound.
    pub(crate) fn bound(&self) -> [u64; 2] {
        self.meshes.as_ref().map_or([u64::MAX; 2], |meshes| meshes.ids)
    }

    /// Whether a question for all pairs or their number is asked without `decide`.
    pub(crate) fn is_direct(&self, task: &Task) -> bool {
        let Query { certify, within, .. } = task.query;
        self.few_open == Some(self.bound()) && certify == 0 && within == 0
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

    /// Records a run, and that so many hits, sorted if all are wanted, and so many of the rest are brought to the host.
    pub(crate) fn record(
        &mut self,
        encoder: &mut CommandEncoder,
        task: &Task,
        start: Start<'_>,
        copies: [u32; 2],
        verb: GpuVerb,
    ) -> Result<Run, GpuError> {
        self.read_back.forget()?;
        let parameters = self.parameters(task, start, verb);
        let fill = |mut view: WriteOnly<'_, [u8]>| view.copy_from_slice(&parameters);
        let source = self.staging.write(&self.gpu, parameters.len() as u64, fill)?;
        self.record_commands(encoder, &source, task, start, copies, verb)
    }

    /// The fronts that the passes of a run read, and how many levels each descends.
    fn passes(&self, task: &Task, start: Start<'_>, verb: GpuVerb) -> (Range<u32>, u32) {
        // A pass reads the front of its own index and writes the next.
        let (first, levels) = match start {
            Start::Seeds => (0, task.levels_below_seeds),
            Start::Front(_) => (0, task.levels),
            // Front p is in buffer p mod 2.
            Start::Left(front, _) => (front % 2, task.levels),
        };
        let dives = u32::from(verb == GpuVerb::AnyEach && !matches!(start, Start::Left(..)));
        let passes = levels.div_ceil(self.depth).clamp(1, FRONTS - 1 - dives - first);
        (first..first + dives + passes, levels.div_ceil(passes))
    }

    /// The bytes that a run reads or copies: parameters and counters of each time that passes begin, [`SET`] bytes, and a front.
    /// They are of the next ticket.
    pub(crate) fn parameters(&mut self, task: &Task, start: Start<'_>, verb: GpuVerb) -> Vec<u8> {
        let (passes, levels) = self.passes(task, start, verb);
        self.ticket = self.ticket.wrapping_add(1);
        let one_hit = u32::from(verb == GpuVerb::Any);
        let each = match verb {
            GpuVerb::AnyEach => ANY_EACH,
            GpuVerb::CountEach => COUNT_EACH,
            GpuVerb::All | GpuVerb::Any | GpuVerb::Count => 0,
        };
        let last_pass = passes.end - 1;
        let whole = Query { levels, last_pass, one_hit, each, beam: u32::MAX, ..task.query };
        let mut bytes = Vec::new();
        if start.looks_ahead(verb) {
            // No pass of it goes to the bottom at once, which all together do.
            let beam = Query { beam: BEAM, last_pass: u32::MAX, ..whole };
            self.add_set(&mut bytes, start, beam);
        }
        self.add_set(&mut bytes, start, whole);
        bytes.extend_from_slice(bytemuck::cast_slice(start.front()));
        bytes
    }

    /// Adds parameters and counters.
    fn add_set(&self, bytes: &mut Vec<u8>, start: Start<'_>, query: Query) {
        let query = Query { ticket: self.ticket, ..self.lists.capacities.in_query(query) };
        let end = bytes.len() + SET;
        bytes.extend_from_slice(bytemuck::bytes_of(&query));
        bytes.resize(end - SET + COUNTERS_AT, 0);
        bytes.extend_from_slice(bytemuck::bytes_of(&start.counters()));
        bytes.resize(end, 0);
    }

    /// Records a run whose parameters will be in `source`.
    ///
    /// Where any hit will do, a run along a narrow beam of node pairs goes first. If it finds a hit, the
    /// passes of the whole run have nothing to do. Where any hit of each pair of instances will do, `dive` goes first.
    pub(crate) fn record_commands(
        &mut self,
        encoder: &mut CommandEncoder,
        source: &Buffer,
        task: &Task,
        start: Start<'_>,
        copies: [u32; 2],
        verb: GpuVerb,
    ) -> Result<Run, GpuError> {
        let (passes, _) = self.passes(task, start, verb);
        let last_front = passes.end;
        let is_each = matches!(verb, GpuVerb::AnyEach | GpuVerb::CountEach);
        let is_new = !matches!(start, Start::Left(..));
        if let Some(tallies) = self.tallies.as_ref().filter(|_| is_each && is_new) {
            encoder.clear_buffer(tallies, 0, None);
        }
        let last = usize::from(start.looks_ahead(verb));
        self.write_front(encoder, source, (last + 1) * SET, start);
        if last != 0 {
            let query = self.prepare(encoder, source, 0, Some(Start::KEPT))?;
            self.dispatch(encoder, &query, task, start, passes.clone(), None);
            self.write_front(encoder, source, (last + 1) * SET, start);
        }
        // The last pass of the run before has left the counters as a run from the seeds begins with them.
        let are_ready = matches!(start, Start::Seeds) && last == 0 && self.are_counters_clear;
        let kept = (!are_ready).then(|| start.kept(verb));
        let query = self.prepare(encoder, source, last * SET, kept)?;
        let order = Order::new(verb, copies[0]);
        self.read_back.make_room(&self.lists, copies)?;
        self.dispatch(encoder, &query, task, start, passes, Some((verb, order)));
        if let Some(clock) = &self.clock {
            clock.finish(encoder);
        }
        let run = self.read_back.bring(encoder, copies, order, self.ticket, last_front);
        Ok(self.read_back.copy_outside(encoder, run, &self.outside))
    }

    /// Records the passes of a run. Without a verb, it is one whose time does not count.
    ///
    /// | first | then | at the end |
    /// |---|---|---|
    /// | two trees: `seed` | `expand` for each further front | `narrow`, `decide` |
    /// | a front of node pairs or of bodies: `expand` | the same | the same |
    /// | a front under [`GpuVerb::AnyEach`]: `dive`, `decide` | the same | the same |
    /// | two meshes of which f32 left few pairs open before | the same | `narrow`, which writes results itself |
    ///
    /// A list of few hits is put in order by `order`, of many by `sample`, `deal` and `settle`, and none by `bring`. The last of them
    /// writes the results for the host.
    fn dispatch(
        &mut self,
        encoder: &mut CommandEncoder,
        query: &BindGroup,
        task: &Task,
        start: Start<'_>,
        passes: Range<u32>,
        verb: Option<(GpuVerb, Order)>,
    ) {
        let (verb, order) = verb.unzip();
        let is_direct = self.is_direct(task) && matches!(verb, Some(GpuVerb::All | GpuVerb::Count));
        let Self { gpu, descent, certifying, groups, workgroups, clock, read_back, .. } = self;
        let (narrow, decide) = match certifying.as_ref().filter(|_| task.query.certify != 0) {
            Some(passes) => (&passes.narrow, &passes.certify),
            None => (&descent.narrow, &descent.decide),
        };
        let shaders = gpu.passes();
        let mut dispatches = Dispatches::begin(encoder, clock.as_mut().filter(|_| verb.is_some()));
        let Some(Meshes { groups: meshes, .. }) = &self.meshes else { return };
        let lists = &groups.lists;
        let first = [query, &meshes.first, &lists.first, &groups.first_step];
        let of_decide = [query, &meshes.decide, &lists.decide];
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
                    let step = &groups.steps[index as usize];
                    let groups = [query, &meshes.expand, &lists.expand, step];
                    dispatches.add(&descent.expand, &groups, *workgroups);
                }
            }
        }
        match (&descent.direct, &meshes.direct, &lists.direct) {
            (Some(pass), Some(meshes), Some(lists)) if is_direct => {
                dispatches.add(pass, &[query, meshes, lists], *workgroups);
            }
            _ => {
                dispatches.add(narrow, &[query, &meshes.narrow, &lists.narrow], *workgroups);
                dispatches.add(decide, &of_decide, *workgroups);
            }
        }
        match order {
            None => {}
            Some(Order::None { hits }) => {
                let workgroups = hits.div_ceil(GROUP).max(1);
                let all = [query, &groups.bring, &read_back.buffers.group];
                dispatches.add(&shaders.bring, &all, workgroups);
            }
            Some(Order::Few) => {
                let all = [query, &groups.order, &read_back.buffers.group];
                dispatches.add(&shaders.order, &all, FEW * RANKERS / GROUP);
            }
            Some(Order::Many) => {
                let [sample, deal, settle] = &groups.sort;
                let ranked = FINER * BUCKETS;
                dispatches.add(&shaders.sample, &[query, sample], ranked * RANKERS / GROUP);
                dispatches.add(&shaders.deal, &[query, deal], *workgroups);
                let all = [query, settle, &read_back.buffers.group];
                dispatches.add(&shaders.settle, &all, BUCKETS);
            }
        }
    }

    /// Records that the front is copied from byte `at` of `source`.
    fn write_front(&self, encoder: &mut CommandEncoder, source: &Buffer, at: usize, start: Start) {
        let bytes = size_of_val(start.front()) as u64;
        if bytes != 0 {
            encoder.copy_buffer_to_buffer(source, at as u64, &self.lists.fronts[0], 0, bytes);
        }
    }

    /// Records what passes begin with, but for a front: counters from byte `kept` on, unless they are there, and parameters, both
    /// from byte `at` of `source` on. Returns the bind group of the parameters.
    ///
    /// They come from a buffer of their own, so that it does not matter which encoders have been recorded or submitted in
    /// between.
    fn prepare(
        &self,
        encoder: &mut CommandEncoder,
        source: &Buffer,
        at: usize,
        kept: Option<usize>,
    ) -> Result<BindGroup, GpuError> {
        let Lists { counters, query, .. } = &self.lists;
        if let Some(kept) = kept {
            let (from, kept) = ((at + COUNTERS_AT + kept) as u64, kept as u64);
            let size = offset_of!(Counters, readers) as u64 - kept;
            encoder.copy_buffer_to_buffer(source, from, counters, kept, size);
        }
        let size = size_of::<Query>() as u64;
        if !self.gpu.is_mapped() {
            encoder.copy_buffer_to_buffer(source, at as u64, query, 0, size);
            return Ok(self.groups.query.clone());
        }
        // All passes have the same layout of it.
        self.descent.expand.bind(self.gpu.device(), 0, |_| {
            let (buffer, offset, size) = (source, at as u64, BufferSize::new(size));
            Some(BindingResource::Buffer(BufferBinding { buffer, offset, size }))
        })
    }

    /// Records that bytes, a multiple of 4, are copied to places in buffers.
    pub(crate) fn write(
        &mut self,
        encoder: &mut CommandEncoder,
        writes: &[(&Buffer, u64, &[u8])],
    ) -> Result<(), GpuError> {
        let size = writes.iter().map(|(.., bytes)| bytes.len()).sum::<usize>() as u64;
        let fill = |mut view: WriteOnly<'_, [u8]>| {
            let mut from = 0;
            for (.., bytes) in writes {
                view.slice(from..from + bytes.len()).copy_from_slice(bytes);
                from += bytes.len();
            }
        };
        let source = self.staging.write(&self.gpu, size, fill)?;
        let mut from = 0;
        for (to, at, bytes) in writes {
            let size = bytes.len() as u64;
            encoder.copy_buffer_to_buffer(&source, from, to, *at, size);
            from += size;
        }
        Ok(())
    }

    /// Forgets what was recorded into an encoder that may never be submitted.
    pub(crate) fn forget_recorded(&mut self) {
        self.staging.forget();
    }

    pub(crate) fn encoder(&self) -> CommandEncoder {
        self.gpu.device().create_command_encoder(&Default::default())
    }

    /// Submits all that was recorded, and has buffers ready for the next run.
    pub(crate) fn submit(&mut self, commands: CommandBuffer) {
        self.gpu.queue().submit([commands]);
        count(&self.gpu.counted().runs);
        self.staging.submitted(&self.gpu);
    }

    /// All children of some node pairs, leaf pairs among them staying what they are.
    pub(crate) async fn refine(
        &mut self,
        task: &Task,
        front: &[Entry],
    ) -> Result<Vec<Entry>, GpuError> {
        let mut encoder = self.encoder();
        self.ticket = self.ticket.wrapping_add(1);
        let query = Query { levels: 1, last_pass: u32::MAX, beam: u32::MAX, ..task.query };
        let start = Start::Front(front);
        let mut bytes = Vec::new();
        self.add_set(&mut bytes, start, query);
        bytes.extend_from_slice(bytemuck::cast_slice(front));
        let fill = |mut view: WriteOnly<'_, [u8]>| view.copy_from_slice(&bytes);
        let source = self.staging.write(&self.gpu, bytes.len() as u64, fill)?;
        self.are_counters_clear = false;
        self.write_front(&mut encoder, &source, SET, start);
        let query = self.prepare(&mut encoder, &source, 0, Some(Start::KEPT))?;
        let Self { gpu, descent, groups, lists, .. } = self;
        if let Some(Meshes { groups: meshes, .. }) = &self.meshes {
            let all = [&query, &meshes.expand, &groups.lists.expand, &groups.refine];
            Dispatches::begin(&mut encoder, None).add(&descent.expand, &all, self.workgroups);
        }
        let (device, queue, cancel) = (gpu.device(), gpu.queue(), self.cancel.as_deref());
        let counters = read_now(device, queue, encoder, &lists.counters, 1, cancel).await?;
        let [counters]: [Counters; 1] = counters.try_into().map_err(|_| GpuError::NotSubmitted)?;
        let encoder = device.create_command_encoder(&Default::default());
        let length = counters.fronts[1] as usize;
        read_now(device, queue, encoder, &lists.fronts[1], length, cancel).await
    }
}
