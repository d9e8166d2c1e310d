//! The history of a query about one model or two: lists whose memory is used again, and the last question, whose
//! answer is that to the next if nothing has changed.

#[cfg(feature = "gpu")]
use crate::Pose;
use crate::environment::{Environment, with_default};
use crate::executor::{Answer, Backend, Executor, Plan, Question, Run, Verb, list, visit};
#[cfg(feature = "gpu")]
use crate::executor::{Device, Mirrors};
#[cfg(feature = "gpu")]
use crate::gpu::GpuQuestion;
use crate::memory::reserve;
use crate::model::{Outline, Stamp};
#[cfg(feature = "threads")]
use crate::threads::{Report, Traversal};
use crate::{Accuracy, Adjacency, AnyPose, Contact, Error, Model, TrianglePair};
use pfront_core::Bvh;
use pfront_core::bvtt::{PairBvtt, Query, SelfBvtt};
use std::ops::ControlFlow;
#[cfg(feature = "threads")]
use std::slice::from_ref;
use std::sync::atomic::AtomicBool;

/// The subject of an answer: the same answer is true of an equal subject.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Subject {
    models: [Stamp; 2],
    /// None within one mesh.
    a_from_b: Option<AnyPose>,
    accuracy: Accuracy,
    adjacency: Adjacency,
}

/// A question about one model or two.
pub(crate) trait About {
    /// The BVTT that the CPU traverses. Fits the BVHs to the positions, if that has not been done.
    ///
    /// # Errors
    /// [`Error::Memory`] if there is no memory for what the traversal goes by.
    fn query(&self) -> Result<impl Query + Sync, Error>;

    /// The same for what looks at single triangles and at poses, and traverses nothing: BVHs that do not fit are left alone.
    fn untraversed<'q>(
        &'q self,
        outlines: &'q [Outline; 2],
    ) -> Result<impl Query + Sync + 'q, Error>;

    fn subject(&self) -> Subject;

    #[cfg(feature = "gpu")]
    fn models(&self) -> &[&Model];

    /// Whether only a CPU answers it.
    #[cfg(feature = "gpu")]
    fn is_for_cpu(&self) -> bool;

    #[cfg(feature = "gpu")]
    fn on_gpu(
        &self,
        device: &Device,
        mirrors: &mut Mirrors,
        verb: Verb,
        pairs: &mut Vec<TrianglePair>,
    ) -> Result<Answer<TrianglePair>, Error>;
}

/// Two models.
pub(crate) struct OfTwo<'m> {
    models: [&'m Model; 2],
    a_from_b: AnyPose,
    accuracy: Accuracy,
}

impl<'m> OfTwo<'m> {
    /// Checks the pose. Fits no BVH, unless the second mesh may be out of range.
    pub(crate) fn new(
        models: [&'m Model; 2],
        a_from_b: AnyPose,
        accuracy: Accuracy,
    ) -> Result<Self, Error> {
        let [_, b] = models;
        with_default(|| {
            // Vertices that no triangle has are in the outline too.
            let is_in_range = a_from_b.check(b.outline(&Outline::default())).is_ok();
            if is_in_range { Ok(()) } else { a_from_b.check(b.bvh()) }
        })?;
        Ok(Self { models, a_from_b, accuracy })
    }

    fn between<'q>(&self, bvhs: [Bvh<'q>; 2]) -> Result<PairBvtt<'q>, Error> {
        Ok(self.a_from_b.pair(bvhs)?.with_accuracy(self.accuracy))
    }

    fn outlined<'q>(&'q self, [of_a, of_b]: &'q [Outline; 2]) -> Result<PairBvtt<'q>, Error> {
        let [a, b] = self.models;
        self.between([a.outline(of_a), b.outline(of_b)])
    }
}

impl About for OfTwo<'_> {
    fn query(&self) -> Result<impl Query + Sync, Error> {
        self.between(self.models.map(Model::bvh))
    }

    fn untraversed<'q>(
        &'q self,
        outlines: &'q [Outline; 2],
    ) -> Result<impl Query + Sync + 'q, Error> {
        self.outlined(outlines)
    }

    fn subject(&self) -> Subject {
        Subject {
            models: self.models.map(Model::stamp),
            a_from_b: Some(self.a_from_b),
            accuracy: self.accuracy,
            adjacency: Adjacency::default(),
        }
    }

    #[cfg(feature = "gpu")]
    fn models(&self) -> &[&Model] {
        &self.models
    }

    #[cfg(feature = "gpu")]
    fn is_for_cpu(&self) -> bool {
        false
    }

    #[cfg(feature = "gpu")]
    fn on_gpu(
        &self,
        device: &Device,
        mirrors: &mut Mirrors,
        verb: Verb,
        pairs: &mut Vec<TrianglePair>,
    ) -> Result<Answer<TrianglePair>, Error> {
        let [a, b] = mirrors.bring(device, &self.models, false)?;
        let (outlines, models) = (Default::default(), &self.models);
        let is_f64 = self.a_from_b.is_f64() || models.iter().any(|model| model.is_f64());
        let in_f64 = if is_f64 { Some(self.outlined(&outlines)?) } else { None };
        let shadows = in_f64.as_ref().and_then(PairBvtt::shadows);
        let question = match (shadows, &self.a_from_b) {
            (Some(shadows), _) => GpuQuestion::shadows(a, b, &shadows),
            (None, AnyPose::F32(a_from_b)) => GpuQuestion::pair(a, b, a_from_b),
            // One of them is empty.
            (None, AnyPose::F64(_)) => GpuQuestion::pair(a, b, &Pose::IDENTITY),
        };
        let intersects = |pair| in_f64.as_ref().is_some_and(|query| query.intersects(pair));
        device.ask(&question, verb, pairs, intersects)
    }
}

/// A model and itself.
pub(crate) struct OfOne<'m> {
    models: [&'m Model; 1],
    adjacency: Adjacency,
    accuracy: Accuracy,
}

impl<'m> OfOne<'m> {
    pub(crate) fn new(model: &'m Model, adjacency: Adjacency, accuracy: Accuracy) -> Self {
        Self { models: [model], adjacency, accuracy }
    }

    pub(crate) fn bvtt(&self) -> SelfBvtt<'m> {
        let [model] = self.models;
        SelfBvtt::new(model.bvh())
            .with_accuracy(self.accuracy)
            .with_adjacency(self.adjacency)
            .with_certificates(model.certificates())
    }
}

impl About for OfOne<'_> {
    fn query(&self) -> Result<impl Query + Sync, Error> {
        Ok(self.bvtt())
    }

    fn untraversed<'q>(
        &'q self,
        [outline, _]: &'q [Outline; 2],
    ) -> Result<impl Query + Sync + 'q, Error> {
        let [model] = self.models;
        Ok(SelfBvtt::new(model.outline(outline)))
    }

    fn subject(&self) -> Subject {
        Subject {
            models: [self.models[0].stamp(); 2],
            a_from_b: None,
            accuracy: self.accuracy,
            adjacency: self.adjacency,
        }
    }

    #[cfg(feature = "gpu")]
    fn models(&self) -> &[&Model] {
        &self.models
    }

    #[cfg(feature = "gpu")]
    fn is_for_cpu(&self) -> bool {
        let [model] = self.models;
        model.is_f64()
    }

    #[cfg(feature = "gpu")]
    fn on_gpu(
        &self,
        device: &Device,
        mirrors: &mut Mirrors,
        verb: Verb,
        pairs: &mut Vec<TrianglePair>,
    ) -> Result<Answer<TrianglePair>, Error> {
        let [model, _] = mirrors.bring(device, &self.models, true)?;
        let question = GpuQuestion::Within { model, adjacency: self.adjacency };
        device.ask(&question, verb, pairs, |_| false)
    }
}

/// The memory of a query.
#[derive(Clone, Debug, Default)]
pub(crate) struct History {
    run: Run,
    #[cfg(feature = "gpu")]
    mirrors: Mirrors,
    pairs: Vec<TrianglePair>,
    contacts: Vec<(TrianglePair, Contact)>,
    /// The last question, and its answer; that to [`Verb::All`] is `pairs`.
    last: Option<(Subject, Verb, Answer<TrianglePair>)>,
    /// The subject of `contacts`.
    touched: Option<Subject>,
}

impl History {
    pub(crate) fn on(executor: &Executor) -> Self {
        Self { run: Run::on(executor), ..Self::default() }
    }

    #[cfg(feature = "threads")]
    pub(crate) fn report(&self) -> Option<&Report> {
        self.run.report()
    }

    pub(crate) fn plan(&self) -> Option<&Plan> {
        self.run.plan()
    }

    /// Takes note that the calling thread has visited pairs.
    pub(crate) fn note_visit(&mut self) {
        self.run.note_cpu(Backend::Sequential);
    }

    pub(crate) fn forget(&mut self) {
        (self.last, self.touched) = (None, None);
    }

    pub(crate) fn set_positions(
        &mut self,
        model: &mut Model,
        positions: &[[f32; 3]],
    ) -> Result<(), Error> {
        self.run.set_positions(model, positions)
    }

    /// All pairs, sorted. Allocates only when there are more than ever before.
    pub(crate) fn all(&mut self, about: &impl About) -> Result<&[TrianglePair], Error> {
        with_default(|| self.ask(about, Verb::All))?;
        Ok(&self.pairs)
    }

    /// How many pairs meet.
    pub(crate) fn count(&mut self, about: &impl About) -> Result<u64, Error> {
        Ok(with_default(|| self.ask(about, Verb::Count))?.count)
    }

    /// Some pair that meets.
    pub(crate) fn any(&mut self, about: &impl About) -> Result<Option<TrianglePair>, Error> {
        Ok(with_default(|| self.ask(about, Verb::Any))?.first)
    }

    /// All pairs that meet, sorted, with where. A pair that only `Conservative` or `Fast` reports
    /// meets nowhere and is left out.
    pub(crate) fn contacts(
        &mut self,
        about: &impl About,
    ) -> Result<&[(TrianglePair, Contact)], Error> {
        with_default(|| self.find_contacts(about))?;
        Ok(&self.contacts)
    }

    fn find_contacts(&mut self, about: &impl About) -> Result<(), Error> {
        self.ask(about, Verb::All)?;
        let subject = about.subject();
        if self.touched.take() != Some(subject) {
            let Self { run, pairs, contacts, .. } = self;
            let outlines = Default::default();
            let query = about.untraversed(&outlines)?;
            contacts.clear();
            // An error gives the list back.
            let mut found = std::mem::take(contacts);
            run.contacts(pairs, |pair| query.contact(pair), &mut found)?;
            *contacts = found;
        }
        // Not before: a thread may panic.
        self.touched = Some(subject);
        Ok(())
    }

    /// [`History::contacts`] in f64, in a list of their own.
    pub(crate) fn contacts_f64(
        &mut self,
        about: &impl About,
    ) -> Result<Vec<(TrianglePair, Contact<f64>)>, Error> {
        with_default(|| {
            self.ask(about, Verb::All)?;
            let (outlines, mut contacts) = (Default::default(), Vec::new());
            let query = about.untraversed(&outlines)?;
            reserve(&mut contacts, self.pairs.len())?;
            self.run.contacts(&self.pairs, |pair| query.contact_f64(pair), &mut contacts)?;
            Ok(contacts)
        })
    }

    /// Answers in the default floating-point environment, in which it is called.
    fn ask(&mut self, about: &impl About, verb: Verb) -> Result<Answer<TrianglePair>, Error> {
        let subject = about.subject();
        match self.last {
            // From a list follows everything else.
            Some((asked, Verb::All, given)) if asked == subject => {
                self.run.keep();
                return Ok(given);
            }
            Some((asked, answered, given)) if asked == subject && answered == verb => {
                self.run.keep();
                return Ok(given);
            }
            _ => self.last = None,
        }
        let Self { run, pairs, .. } = self;
        let mut asking = Asking {
            about,
            pairs,
            #[cfg(feature = "gpu")]
            mirrors: &mut self.mirrors,
        };
        let given = run.ask(&mut asking, verb)?;
        self.last = Some((subject, verb, given));
        Ok(given)
    }
}

/// Visits all pairs on the calling thread, in the floating-point environment of the caller, until `visit` breaks.
pub(crate) fn visit_each(
    query: &impl Query,
    mut visit: impl FnMut(TrianglePair) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let callers = Environment::current();
    with_default(|| query.visit(&mut query.start(), |pair| callers.run(|| visit(pair))))
}

/// Answers a question on threads; `pairs` are replaced under [`Verb::All`].
#[cfg(feature = "threads")]
pub(crate) fn traverse(
    traversal: &mut Traversal,
    query: &(impl Query + Sync),
    verb: Verb,
    pairs: &mut Vec<TrianglePair>,
) -> Result<Answer<TrianglePair>, Error> {
    Ok(match verb {
        Verb::All => {
            traversal.all(from_ref(query), pairs)?;
            Answer::listed(pairs)
        }
        Verb::Count => Answer::counted(traversal.count(from_ref(query))?),
        Verb::Any => Answer::found(traversal.any(from_ref(query))?.map(|hit| hit.pair)),
    })
}

struct Asking<'a, A> {
    about: &'a A,
    pairs: &'a mut Vec<TrianglePair>,
    #[cfg(feature = "gpu")]
    mirrors: &'a mut Mirrors,
}

impl<A: About> Question for Asking<'_, A> {
    type Answer = Answer<TrianglePair>;

    #[cfg(feature = "gpu")]
    fn accuracy(&self) -> Accuracy {
        self.about.subject().accuracy
    }

    #[cfg(feature = "gpu")]
    fn is_for_cpu(&self) -> bool {
        self.about.is_for_cpu()
    }

    fn on_one_thread(
        &mut self,
        verb: Verb,
        cancel: Option<&AtomicBool>,
    ) -> Result<Self::Answer, Error> {
        let query = self.about.query()?;
        Ok(match verb {
            Verb::All => {
                self.pairs.clear();
                list(&query, cancel, self.pairs, |pair| pair)?;
                self.pairs.sort_unstable();
                Answer::listed(self.pairs)
            }
            Verb::Count => {
                let mut count = 0;
                visit(&query, cancel, |_| {
                    count += 1;
                    ControlFlow::Continue(())
                })?;
                Answer::counted(count)
            }
            Verb::Any => {
                let mut first = None;
                visit(&query, cancel, |pair| {
                    first = Some(pair);
                    ControlFlow::Break(())
                })?;
                Answer::found(first)
            }
        })
    }

    #[cfg(feature = "threads")]
    fn on_threads(&mut self, traversal: &mut Traversal, verb: Verb) -> Result<Self::Answer, Error> {
        traverse(traversal, &self.about.query()?, verb, self.pairs)
    }

    #[cfg(feature = "gpu")]
    fn meshes(&self) -> [u64; 2] {
        self.about.subject().models.map(Stamp::mesh)
    }

    #[cfg(feature = "gpu")]
    fn to_upload(&mut self) -> usize {
        self.mirrors.lack(self.about.models())
    }

    #[cfg(feature = "gpu")]
    fn on_gpu(
        &mut self,
        device: &Device,
        _: &mut Executor,
        verb: Verb,
    ) -> Result<Self::Answer, Error> {
        self.about.on_gpu(device, self.mirrors, verb, self.pairs)
    }
}
