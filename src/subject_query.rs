//! A query about one subject: lists whose memory is used again, and the last question, whose answer is that to the next if
//! nothing has changed.

use crate::environment::{Environment, with_default};
use crate::executor::{
    Answer, Backend, CONTACTS, CpuHistory, CpuPart, Device, Executor, Frame, History, Meeting,
    Mirrors, Plan, Verb, check, visit as search,
};
use crate::memory::{filled, push};
use crate::patches::pieces::Pieces;
use crate::patches::vertices::Vertices;
use crate::patches::{ContactPatch, assemble};
use crate::subject::{Key, Subject};
use crate::{AnyPose, Contact, Distance, Error, Model, Pose64, Scalar, Solid, TrianglePair};
use pfront_core::bvtt::{AnyBvtt, Gap};
use pfront_core::relation::{Between, RelationQuery, Seen, seen_bound};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};

/// A pair query or a self query.
#[derive(Clone, Debug, Default)]
pub(crate) struct SubjectQuery {
    history: History<()>,
    mirrors: Mirrors,
    pairs: Vec<TrianglePair>,
    contacts: Vec<(TrianglePair, Contact)>,
    /// The last question, and its answer; that to [`Verb::All`] is `pairs`.
    last: Option<(Key, Verb, Answer<TrianglePair>)>,
    /// The subject of `contacts`.
    touched: Option<Key>,
    /// The nearest pair of the last search for the smallest distance.
    nearest: Option<TrianglePair>,
}

impl SubjectQuery {
    /// The same on another executor, without what is remembered.
    pub(crate) fn on(&self, executor: &Executor) -> Self {
        Self { history: History::on(executor), ..Self::default() }
    }

    #[cfg(feature = "threads")]
    pub(crate) fn report(&self) -> Option<&crate::threads::Report> {
        self.history.report()
    }

    pub(crate) fn history(&mut self) -> &mut History<()> {
        &mut self.history
    }

    pub(crate) fn plan(&self) -> Option<&Plan> {
        self.history.plan()
    }

    pub(crate) fn forget(&mut self) {
        (self.last, self.touched) = (None, None);
    }

    pub(crate) fn set_positions<S: Scalar>(
        &mut self,
        model: &mut Model,
        positions: &[[S; 3]],
    ) -> Result<(), Error> {
        self.history.set_positions(model, positions)
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

    /// The smallest distance of two models, if it is not greater than `at_most`.
    pub(crate) fn distance(
        &mut self,
        subject: &Subject<&Model>,
        at_most: Option<Distance>,
    ) -> Result<Option<Gap>, Error> {
        with_default(|| {
            // Between a model and itself there is none.
            let AnyBvtt::Pair(tree) = subject.tree()? else { return Ok(None) };
            let gap = self.history.distance(&tree, at_most, self.nearest)?;
            self.nearest = gap.map(|gap| gap.pair).or(self.nearest);
            Ok(gap)
        })
    }

    /// The relation of two solids, whose models are those of the subject. The calling thread alone adds pairs as they are found;
    /// else one is asked for first, and then all, which several threads divide.
    pub(crate) fn relation(
        &mut self,
        subject: &Subject<&Model>,
        solids: [&Solid; 2],
        pose: AnyPose,
    ) -> Result<Between, Error> {
        let [a, b] = solids.map(Solid::view);
        let query = RelationQuery::of_pair(pose.pair([a.bvh(), b.bvh()])?, &a, &b);
        let words = seen_bound(query.patches());
        let mut lines = filled(0, words)?;
        let mut seen = Seen::new(&query, &mut lines)?;
        if self.history.is_sequential() {
            self.history.note_cpu(Backend::Sequential);
            let flag = self.history.executor().cancel_flag();
            search(query.pairs(), flag, |pair| query.add(&mut seen, pair))?;
            return Ok(query.conclude(seen));
        }
        let is_over = match self.ask(subject, Verb::Any)?.first {
            Some(pair) => query.add(&mut seen, pair).is_break(),
            None => true,
        };
        if !is_over {
            self.ask(subject, Verb::All)?;
            let (crosses, all) = (AtomicBool::new(false), Mutex::new(&mut seen));
            let add = |pairs: &[TrianglePair], _: &mut Vec<()>| {
                let mut lines = filled(0, words)?;
                let mut own = Seen::new(&query, &mut lines)?;
                for pair in pairs {
                    if crosses.load(Relaxed) || query.add(&mut own, *pair).is_break() {
                        crosses.store(true, Relaxed);
                        break;
                    }
                }
                all.lock().unwrap_or_else(PoisonError::into_inner).join(&own);
                Ok(())
            };
            self.history.by_pieces(&self.pairs, CONTACTS, add, &mut Vec::new())?;
        }
        Ok(query.conclude(seen))
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
            let Self { history, pairs, contacts, .. } = self;
            let outlines = Default::default();
            let meeting = Meeting::InTree(subject.untraversed(&outlines)?);
            contacts.clear();
            // An error gives the list back.
            let mut found = std::mem::take(contacts);
            history.contacts(pairs, |()| Ok(meeting), Meeting::contact, &mut found)?;
            *contacts = found;
        }
        // Not before: a thread may panic.
        self.touched = Some(key);
        Ok(())
    }

    /// [`SubjectQuery::contacts`] in f64, in a list of their own.
    pub(crate) fn contacts_f64(
        &mut self,
        subject: &Subject<&Model>,
    ) -> Result<Vec<(TrianglePair, Contact<f64>)>, Error> {
        with_default(|| {
            self.ask(subject, Verb::All)?;
            let (outlines, mut contacts) = (Default::default(), Vec::new());
            let meeting = Meeting::InTree(subject.untraversed(&outlines)?);
            self.history.contacts(
                &self.pairs,
                |()| Ok(meeting),
                Meeting::contact_f64,
                &mut contacts,
            )?;
            Ok(contacts)
        })
    }

    /// All that two surfaces have in common, in patches, measured in a world. Several threads divide the pairs.
    pub(crate) fn patches(
        &mut self,
        subject: &Subject<&Model>,
        world_from_a: &Pose64,
    ) -> Result<Vec<ContactPatch>, Error> {
        self.ask(subject, Verb::All)?;
        let (outlines, mut pieces) = (Default::default(), Vec::new());
        let AnyBvtt::Pair(tree) = subject.untraversed(&outlines)? else { return Ok(Vec::new()) };
        let meshes = subject.both().map(|model| model.mesh());
        let vertices = Vertices::new(meshes, &tree, &self.pairs)?;
        let (part, flag) = (CpuPart::new(), self.history.executor().cancel_flag());
        let list = |pairs: &[TrianglePair], out: &mut Vec<Pieces>| {
            part.works();
            let mut own = Pieces::default();
            for &pair in pairs {
                check(flag)?;
                own.add(&tree, &vertices, pair, world_from_a)?;
            }
            push(out, own)
        };
        let listed = self.history.by_pieces(&self.pairs, CONTACTS, list, &mut pieces);
        self.history.note_also(part.backend());
        listed?;
        assemble(&self.pairs, pieces)
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
                self.history.keep();
                return Ok(given);
            }
            Some((asked, answered, given)) if asked == key && answered == verb => {
                self.history.keep();
                return Ok(given);
            }
            _ => self.last = None,
        }
        let Self { history, pairs, mirrors, .. } = self;
        let given = history.ask(&mut SubjectFrame { subject, pairs, mirrors }, verb)?;
        self.last = Some((key, verb, given));
        Ok(given)
    }

    /// Visits all pairs on the calling thread, in the floating-point environment of the caller, until `visit` breaks.
    ///
    /// # Errors
    /// [`Error::Cancelled`].
    pub(crate) fn visit(
        &mut self,
        tree: &AnyBvtt<'_>,
        mut visit: impl FnMut(TrianglePair) -> ControlFlow<()>,
    ) -> Result<ControlFlow<()>, Error> {
        self.history.note_cpu(Backend::Sequential);
        let (callers, mut end) = (Environment::current(), ControlFlow::Continue(()));
        with_default(|| {
            search(tree, self.history.executor().cancel_flag(), |pair| {
                end = callers.run(|| visit(pair));
                end
            })
        })?;
        Ok(end)
    }
}

/// A frame of one subject, as its executor answers it.
struct SubjectFrame<'a, 'm> {
    subject: &'a Subject<&'m Model>,
    pairs: &'a mut Vec<TrianglePair>,
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

    fn is_for_cpu(&self) -> bool {
        self.subject.is_for_cpu()
    }

    fn meshes(&self) -> [u64; 2] {
        self.subject.key().meshes()
    }

    fn to_upload(&mut self) -> usize {
        self.mirrors.lack(self.subject.models())
    }

    fn on_gpu(
        &mut self,
        device: &Device,
        cpu: &mut CpuHistory<()>,
        verb: Verb,
    ) -> Result<Answer<TrianglePair>, Error> {
        self.mirrors.ask(device, self.subject, cpu.cancel(), verb, self.pairs)
    }
}
