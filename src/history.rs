//! The history of a query subject one subject: lists whose memory is used again, and the last question, whose answer is
//! that to the next if nothing has changed.

use crate::environment::{Environment, with_default};
use crate::executor::{Answer, Backend, CpuHistory, Executor, Frame, Plan, Run, Verb};
#[cfg(feature = "gpu")]
use crate::executor::{Device, Mirrors};
use crate::subject::{AnyBvtt, Key, Subject};
#[cfg(feature = "threads")]
use crate::threads::Report;
use crate::{Contact, Error, Model, Scalar, TrianglePair};
use pfront_core::bvtt::Query;
use std::ops::ControlFlow;

/// The memory of a query.
#[derive(Clone, Debug, Default)]
pub(crate) struct History {
    run: Run<()>,
    #[cfg(feature = "gpu")]
    mirrors: Mirrors,
    pairs: Vec<TrianglePair>,
    contacts: Vec<(TrianglePair, Contact)>,
    /// The last question, and its answer; that to [`Verb::All`] is `pairs`.
    last: Option<(Key, Verb, Answer<TrianglePair>)>,
    /// The subject of `contacts`.
    touched: Option<Key>,
}

impl History {
    /// A history of its own, on another executor.
    pub(crate) fn on(&self, executor: &Executor) -> Self {
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

    pub(crate) fn set_positions<S: Scalar>(
        &mut self,
        model: &mut Model,
        positions: &[[S; 3]],
    ) -> Result<(), Error> {
        self.run.set_positions(model, positions)
    }

    /// All pairs, sorted. Allocates only when there are more than ever before.
    pub(crate) fn all(&mut self, subject: &Subject<&Model>) -> Result<&[TrianglePair], Error> {
        with_default(|| self.ask(subject, Verb::All))?;
        Ok(&self.pairs)
    }

    /// How many pairs meet.
    pub(crate) fn count(&mut self, subject: &Subject<&Model>) -> Result<u64, Error> {
        Ok(with_default(|| self.ask(subject, Verb::Count))?.count)
    }

    /// Some pair that meets.
    pub(crate) fn any(&mut self, subject: &Subject<&Model>) -> Result<Option<TrianglePair>, Error> {
        Ok(with_default(|| self.ask(subject, Verb::Any))?.first)
    }

    /// All pairs that meet, sorted, with where.
    pub(crate) fn contacts(
        &mut self,
        subject: &Subject<&Model>,
    ) -> Result<&[(TrianglePair, Contact)], Error> {
        with_default(|| self.find_contacts(subject))?;
        Ok(&self.contacts)
    }

    fn find_contacts(&mut self, subject: &Subject<&Model>) -> Result<(), Error> {
        self.ask(subject, Verb::All)?;
        let key = subject.key();
        if self.touched.take() != Some(key) {
            let Self { run, pairs, contacts, .. } = self;
            let outlines = Default::default();
            let tree = &subject.untraversed(&outlines)?;
            contacts.clear();
            // An error gives the list back.
            let mut found = std::mem::take(contacts);
            run.contacts(pairs, |()| Ok(Some(tree)), |tree, pair| tree.contact(pair), &mut found)?;
            *contacts = found;
        }
        // Not before: a thread may panic.
        self.touched = Some(key);
        Ok(())
    }

    /// [`History::contacts`] in f64, in a list of their own.
    pub(crate) fn contacts_f64(
        &mut self,
        subject: &Subject<&Model>,
    ) -> Result<Vec<(TrianglePair, Contact<f64>)>, Error> {
        with_default(|| {
            self.ask(subject, Verb::All)?;
            let (outlines, mut contacts) = (Default::default(), Vec::new());
            let tree = &subject.untraversed(&outlines)?;
            let contact = |tree: &&AnyBvtt<'_>, pair| tree.contact_f64(pair);
            self.run.contacts(&self.pairs, |()| Ok(Some(tree)), contact, &mut contacts)?;
            Ok(contacts)
        })
    }

    /// Answers in the default floating-point environment, in which it is called.
    fn ask(
        &mut self,
        subject: &Subject<&Model>,
        verb: Verb,
    ) -> Result<Answer<TrianglePair>, Error> {
        let key = subject.key();
        match self.last {
            // From a list follows everything else.
            Some((asked, Verb::All, given)) if asked == key => {
                self.run.keep();
                return Ok(given);
            }
            Some((asked, answered, given)) if asked == key && answered == verb => {
                self.run.keep();
                return Ok(given);
            }
            _ => self.last = None,
        }
        let Self { run, pairs, .. } = self;
        let mut frame = SubjectFrame {
            subject,
            pairs,
            #[cfg(feature = "gpu")]
            mirrors: &mut self.mirrors,
        };
        let given = run.ask(&mut frame, verb)?;
        self.last = Some((key, verb, given));
        Ok(given)
    }

    /// Visits all pairs on the calling thread, in the floating-point environment of the caller, until `visit` breaks.
    pub(crate) fn visit(
        &mut self,
        tree: &AnyBvtt<'_>,
        mut visit: impl FnMut(TrianglePair) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        self.run.note_cpu(Backend::Sequential);
        let callers = Environment::current();
        with_default(|| tree.visit(&mut tree.start(), |pair| callers.run(|| visit(pair))))
    }
}

/// A frame of one subject, as its executor answers it.
struct SubjectFrame<'a, 'm> {
    subject: &'a Subject<&'m Model>,
    pairs: &'a mut Vec<TrianglePair>,
    #[cfg(feature = "gpu")]
    mirrors: &'a mut Mirrors,
}

impl Frame for SubjectFrame<'_, '_> {
    type Hit = TrianglePair;

    fn on_cpu(
        &mut self,
        cpu: &mut CpuHistory<()>,
        verb: Verb,
    ) -> (Backend, Result<Answer<TrianglePair>, Error>) {
        // A tree is some 1,300 bytes, which are not to be moved about.
        match &self.subject.tree() {
            Ok(tree) => cpu.ask((), tree, verb, self.pairs),
            Err(error) => (Backend::Sequential, Err(error.clone())),
        }
    }

    #[cfg(feature = "gpu")]
    fn is_for_cpu(&self) -> bool {
        self.subject.is_for_cpu()
    }

    #[cfg(feature = "gpu")]
    fn meshes(&self) -> [u64; 2] {
        self.subject.key().meshes()
    }

    #[cfg(feature = "gpu")]
    fn to_upload(&mut self) -> usize {
        self.mirrors.lack(self.subject.models())
    }

    #[cfg(feature = "gpu")]
    fn on_gpu(
        &mut self,
        device: &Device,
        _: &mut CpuHistory<()>,
        verb: Verb,
    ) -> Result<Answer<TrianglePair>, Error> {
        let Self { subject, mirrors, pairs, .. } = self;
        let is_within = matches!(subject, Subject::Within { .. });
        let models = mirrors.bring(device, subject.models(), is_within)?;
        let outlines = Default::default();
        let in_f64 = subject.in_f64(&outlines)?;
        let question = subject.question(models, in_f64.as_ref());
        let intersects = |pair| in_f64.as_ref().is_some_and(|tree| tree.intersects(pair));
        device.ask(&question, verb, pairs, intersects)
    }
}
