//! Where the bodies of a scene meet: the segments of triangles that are known to.

use super::bodies::Bodies;
use super::hit::SceneHit;
use super::id::BodyId;
use super::pairs::meeting;
use crate::executor::{CpuPart, Run, check};
use crate::memory::reserve;
use crate::{Error, TrianglePair};
use pfront_core::bvtt::PairBvtt;

/// Contacts between two looks at the flag of the executor: some 0.1 ms.
const BLOCK: usize = 256;

/// The most hits of two bodies that one thread takes at once, for each of which it prepares a query.
#[cfg(feature = "threads")]
const PIECE: usize = 16;

/// Adds to `out`, in order, the contacts of those hits whose bodies are `asked` about, on the threads of the executor, if it has
/// some, and takes note of who has worked. A hit without a contact is left out.
///
/// # Errors
/// [`Error::Cancelled`] once the flag of the executor is set, [`Error::Memory`].
pub(super) fn contacts<C: Send>(
    run: &mut Run<[BodyId; 2]>,
    bodies: &Bodies,
    hits: &[SceneHit],
    is_asked: impl Fn([BodyId; 2]) -> bool,
    contact: impl Fn(&PairBvtt<'_>, TrianglePair) -> Option<C> + Sync,
    out: &mut Vec<(SceneHit, C)>,
) -> Result<(), Error> {
    let mut asked = hits
        .chunk_by(|x, y| x.bodies == y.bodies)
        .filter(|of_two| is_asked(of_two[0].bodies))
        .peekable();
    if asked.peek().is_none() {
        return Ok(());
    }
    let (part, flag) = (CpuPart::new(), run.executor().cancel_flag());
    let list = |hits: &[SceneHit], out: &mut Vec<(SceneHit, C)>| -> Result<(), Error> {
        part.works();
        let [a, b] = hits[0].bodies;
        let query = meeting(bodies.get(a)?, bodies.get(b)?);
        for block in hits.chunks(BLOCK) {
            check(flag)?;
            reserve(out, block.len())?;
            out.extend(block.iter().filter_map(|&hit| Some((hit, contact(&query, hit.pair)?))));
        }
        Ok(())
    };
    #[cfg(feature = "threads")]
    let listed = match run.executor().pool {
        Some(_) => listed_by_pieces(run, asked.flat_map(|of_two| of_two.chunks(PIECE)), list, out),
        None => asked.try_for_each(|of_two| list(of_two, out)),
    };
    #[cfg(not(feature = "threads"))]
    let listed = asked.try_for_each(|of_two| list(of_two, out));
    run.note_also(part.backend());
    listed
}

/// Lists each piece by itself, on any thread, and then all in order.
#[cfg(feature = "threads")]
fn listed_by_pieces<'h, C: Send>(
    run: &Run<[BodyId; 2]>,
    pieces: impl Iterator<Item = &'h [SceneHit]>,
    list: impl Fn(&[SceneHit], &mut Vec<(SceneHit, C)>) -> Result<(), Error> + Sync,
    out: &mut Vec<(SceneHit, C)>,
) -> Result<(), Error> {
    let (mut all, mut lists) = (Vec::new(), Vec::new());
    for piece in pieces {
        crate::memory::push(&mut all, piece)?;
    }
    let own = |piece: &&[SceneHit]| {
        let mut own = Vec::new();
        Some(list(piece, &mut own).map(|()| own))
    };
    run.filter_map(&all, own, &mut lists)?;
    reserve(out, lists.iter().flatten().map(Vec::len).sum())?;
    lists.into_iter().try_for_each(|own| own.map(|mut own| out.append(&mut own)))
}
