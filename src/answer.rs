//! The answer to a question about one model or two: its lists, kept from frame to frame, and the last question, whose
//! answer is that to the next if nothing has changed.

#[cfg(feature = "gpu")]
use crate::executor::{Device, Mirrors};
use crate::executor::{Executor, Given, Plan, Question, Run, Want};
use crate::model::Stamp;
#[cfg(feature = "threads")]
use crate::threads::{Report, Traversal};
use crate::{Accuracy, Adjacency, Contact, Error, Model, Pose, TrianglePair, core};
use pfront_core::bvtt::Query;
use std::ops::ControlFlow;
#[cfg(feature = "threads")]
use std::slice::from_ref;

/// The subject of an answer: the same answer is true of an equal subject.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Subject {
    models: [Stamp; 2],
    /// None within one mesh.
    a_from_b: Option<Pose>,
    accuracy: Accuracy,
    adjacency: Adjacency,
}

/// A question about one model or two.
pub(crate) trait About {
    /// What the CPU traverses. Fits the BVHs to the positions, if that has not been done.
    fn query(&self) -> impl Query + Sync;

    fn subject(&self) -> Subject;

    #[cfg(feature = "gpu")]
    fn models(&self) -> &[&Model];

    #[cfg(feature = "gpu")]
    fn on_gpu(
        &self,
        device: &Device,
        mirrors: &mut Mirrors,
        want: Want,
        pairs: &mut Vec<TrianglePair>,
    ) -> Result<Given<TrianglePair>, Error>;
}

/// Two models.
pub(crate) struct OfTwo<'m> {
    models: [&'m Model; 2],
    a_from_b: Pose,
    query: core::bvtt::PairQuery<'m>,
    accuracy: Accuracy,
}

impl<'m> OfTwo<'m> {
    pub(crate) fn new(
        models: [&'m Model; 2],
        a_from_b: &Pose,
        accuracy: Accuracy,
    ) -> Result<Self, Error> {
        let [a, b] = models.map(Model::bvh);
        let query = core::bvtt::PairQuery::new(a, b, *a_from_b)?.with_accuracy(accuracy);
        Ok(Self { models, a_from_b: *a_from_b, query, accuracy })
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
    fn on_gpu(
        &self,
        device: &Device,
        mirrors: &mut Mirrors,
        want: Want,
        pairs: &mut Vec<TrianglePair>,
    ) -> Result<Given<TrianglePair>, Error> {
        let models = mirrors.bring(device, &self.models, false)?;
        Ok(device.ask_pair(models, &self.a_from_b, want, pairs)?)
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
        core::bvtt::SelfQuery::new(model.bvh())
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
    fn on_gpu(
        &self,
        device: &Device,
        mirrors: &mut Mirrors,
        want: Want,
        pairs: &mut Vec<TrianglePair>,
    ) -> Result<Given<TrianglePair>, Error> {
        let [model, _] = mirrors.bring(device, &self.models, true)?;
        Ok(device.ask_within(model, self.adjacency, want, pairs)?)
    }
}

/// The memory of a query.
#[derive(Clone, Debug, Default)]
pub(crate) struct Answer {
    run: Run,
    #[cfg(feature = "gpu")]
    mirrors: Mirrors,
    pairs: Vec<TrianglePair>,
    contacts: Vec<(TrianglePair, Contact)>,
    /// What was asked last, and the answer; that to [`Want::All`] is `pairs`.
    last: Option<(Subject, Want, Given<TrianglePair>)>,
    /// What `contacts` are about.
    touched: Option<Subject>,
}

impl Answer {
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
        self.ask(about, Want::All)?;
        Ok(&self.pairs)
    }

    /// How many pairs meet.
    pub(crate) fn count(&mut self, about: &impl About) -> Result<u64, Error> {
        Ok(self.ask(about, Want::Count)?.count)
    }

    /// Some pair that meets.
    pub(crate) fn any(&mut self, about: &impl About) -> Result<Option<TrianglePair>, Error> {
        Ok(self.ask(about, Want::Any)?.first)
    }

    /// All pairs that meet, sorted, with where. A pair that only `Conservative` or `Fast` reports
    /// meets nowhere and is left out.
    pub(crate) fn contacts(
        &mut self,
        about: &impl About,
    ) -> Result<&[(TrianglePair, Contact)], Error> {
        self.ask(about, Want::All)?;
        let subject = about.subject();
        if self.touched.replace(subject) != Some(subject) {
            let Self { run, pairs, contacts, .. } = self;
            contacts.clear();
            run.contacts(&about.query(), pairs, contacts);
        }
        Ok(&self.contacts)
    }

    fn ask(&mut self, about: &impl About, want: Want) -> Result<Given<TrianglePair>, Error> {
        let subject = about.subject();
        match self.last {
            // From a list follows everything else.
            Some((asked, Want::All, given)) if asked == subject => {
                self.run.keep();
                return Ok(given);
            }
            Some((asked, verb, given)) if asked == subject && verb == want => {
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
        let given = run.ask(&mut asking, want)?;
        self.last = Some((subject, want, given));
        Ok(given)
    }
}

struct Asking<'a, A> {
    about: &'a A,
    pairs: &'a mut Vec<TrianglePair>,
    #[cfg(feature = "gpu")]
    mirrors: &'a mut Mirrors,
}

impl<A: About> Question for Asking<'_, A> {
    type Answer = Given<TrianglePair>;

    #[cfg(feature = "gpu")]
    fn accuracy(&self) -> Accuracy {
        self.about.subject().accuracy
    }

    fn on_one_thread(&mut self, want: Want) -> Result<Self::Answer, Error> {
        let query = self.about.query();
        Ok(match want {
            Want::All => {
                self.pairs.clear();
                let _ = query.visit(&mut query.start(), |pair| {
                    self.pairs.push(pair);
                    ControlFlow::Continue(())
                });
                self.pairs.sort_unstable();
                Given::listed(self.pairs)
            }
            Want::Count => Given::counted(query.count()),
            Want::Any => Given::found(query.any()),
        })
    }

    #[cfg(feature = "threads")]
    fn on_threads(&mut self, traversal: &mut Traversal, want: Want) -> Result<Self::Answer, Error> {
        let query = &self.about.query();
        Ok(match want {
            Want::All => {
                traversal.all(from_ref(query), self.pairs);
                Given::listed(self.pairs)
            }
            Want::Count => Given::counted(traversal.count(from_ref(query))),
            Want::Any => Given::found(traversal.any(from_ref(query)).map(|hit| hit.pair)),
        })
    }

    #[cfg(feature = "gpu")]
    fn to_upload(&self) -> usize {
        self.mirrors.lack(self.about.models())
    }

    #[cfg(feature = "gpu")]
    fn on_gpu(&mut self, device: &Device, want: Want) -> Result<Self::Answer, Error> {
        self.about.on_gpu(device, self.mirrors, want, self.pairs)
    }
}
