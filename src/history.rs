//! The history of a query about one model or two: lists whose memory is used again, and the last question, whose
//! answer is that to the next if nothing has changed.

#[cfg(feature = "gpu")]
use crate::Pose;
use crate::executor::{Answer, Executor, Plan, Question, Run, Verb, visit};
#[cfg(feature = "gpu")]
use crate::executor::{Device, Mirrors};
#[cfg(feature = "gpu")]
use crate::gpu::GpuQuestion;
use crate::model::Stamp;
#[cfg(feature = "threads")]
use crate::threads::{Report, Traversal};
use crate::{Accuracy, Adjacency, AnyPose, Contact, Error, Model, TrianglePair};
use pfront_core::bvtt::Query;
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
    fn query(&self) -> impl Query + Sync;

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
    query: pfront_core::bvtt::PairBvtt<'m>,
    accuracy: Accuracy,
}

impl<'m> OfTwo<'m> {
    pub(crate) fn new(
        models: [&'m Model; 2],
        a_from_b: AnyPose,
        accuracy: Accuracy,
    ) -> Result<Self, Error> {
        let query = a_from_b.pair(models.map(Model::bvh))?.with_accuracy(accuracy);
        Ok(Self { models, a_from_b, query, accuracy })
    }
}

impl About for OfTwo<'_> {
    fn query(&self) -> impl Query + Sync {
        self.query
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
        let question = match (self.query.shadows(), &self.a_from_b) {
            (Some(shadows), _) => GpuQuestion::shadows(a, b, &shadows),
            (None, AnyPose::F32(a_from_b)) => GpuQuestion::pair(a, b, a_from_b),
            // One of them is empty.
            (None, AnyPose::F64(_)) => GpuQuestion::pair(a, b, &Pose::IDENTITY),
        };
        Ok(device.ask(&question, verb, pairs, |pair| self.query.intersects(pair))?)
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
}

impl About for OfOne<'_> {
    fn query(&self) -> impl Query + Sync {
        let [model] = self.models;
        pfront_core::bvtt::SelfBvtt::new(model.bvh())
            .with_accuracy(self.accuracy)
            .with_adjacency(self.adjacency)
            .with_certificates(model.certificates())
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
        Ok(device.ask(&question, verb, pairs, |_| false)?)
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
        self.ask(about, Verb::All)?;
        Ok(&self.pairs)
    }

    /// How many pairs meet.
    pub(crate) fn count(&mut self, about: &impl About) -> Result<u64, Error> {
        Ok(self.ask(about, Verb::Count)?.count)
    }

    /// Some pair that meets.
    pub(crate) fn any(&mut self, about: &impl About) -> Result<Option<TrianglePair>, Error> {
        Ok(self.ask(about, Verb::Any)?.first)
    }

    /// All pairs that meet, sorted, with where. A pair that only `Conservative` or `Fast` reports
    /// meets nowhere and is left out.
    pub(crate) fn contacts(
        &mut self,
        about: &impl About,
    ) -> Result<&[(TrianglePair, Contact)], Error> {
        self.ask(about, Verb::All)?;
        let subject = about.subject();
        if self.touched.take() != Some(subject) {
            let Self { run, pairs, contacts, .. } = self;
            contacts.clear();
            let query = about.query();
            run.contacts(pairs, |pair| query.contact(pair), contacts);
        }
        // Not before: a visitor of the pool may panic.
        self.touched = Some(subject);
        Ok(&self.contacts)
    }

    /// [`History::contacts`] in f64, in a list of their own.
    pub(crate) fn contacts_f64(
        &mut self,
        about: &impl About,
    ) -> Result<Vec<(TrianglePair, Contact<f64>)>, Error> {
        self.ask(about, Verb::All)?;
        let (query, mut contacts) = (about.query(), Vec::with_capacity(self.pairs.len()));
        self.run.contacts(&self.pairs, |pair| query.contact_f64(pair), &mut contacts);
        Ok(contacts)
    }

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

/// Answers a question on threads; `pairs` are replaced under [`Verb::All`].
#[cfg(feature = "threads")]
pub(crate) fn traverse(
    traversal: &mut Traversal,
    query: &(impl Query + Sync),
    verb: Verb,
    pairs: &mut Vec<TrianglePair>,
) -> Answer<TrianglePair> {
    match verb {
        Verb::All => {
            traversal.all(from_ref(query), pairs);
            Answer::listed(pairs)
        }
        Verb::Count => Answer::counted(traversal.count(from_ref(query))),
        Verb::Any => Answer::found(traversal.any(from_ref(query)).map(|hit| hit.pair)),
    }
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
        let query = self.about.query();
        Ok(match verb {
            Verb::All => {
                self.pairs.clear();
                visit(&query, cancel, |pair| {
                    self.pairs.push(pair);
                    ControlFlow::Continue(())
                })?;
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
        Ok(traverse(traversal, &self.about.query(), verb, self.pairs))
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
    fn on_gpu(&mut self, device: &Device, verb: Verb) -> Result<Self::Answer, Error> {
        self.about.on_gpu(device, self.mirrors, verb, self.pairs)
    }
}
