//! Contacts, and their segments joined to polylines.

use pfront::Contact;
use pfront_files::{TriangleMesh, write_polylines};
use std::io::{self, Write};

/// Ends of segments that are nearer than this, as a part of the largest coordinate, are one point: neighbouring
/// contacts compute it from different triangles. In f64, it is a part of how far they reach.
const NEAR: f64 = 1e-6;

/// A contact in the precision of the query.
#[derive(Clone, Copy)]
pub(crate) enum AnyContact {
    F32(Contact),
    F64(Contact<f64>),
}

impl AnyContact {
    /// In f64, to which every f32 widens.
    pub(crate) fn widened(self) -> Contact<f64> {
        match self {
            Self::F32(contact) => contact.into(),
            Self::F64(contact) => contact,
        }
    }
}

/// Points, and the indices of those along each polyline, the first again at the end of one that is closed.
pub(crate) struct Curves {
    points: Vec<[f64; 3]>,
    lines: Vec<Vec<u32>>,
    is_f64: bool,
}

impl Curves {
    /// Joins the segments of contacts. Points in which more than two end, end polylines.
    pub(crate) fn of(contacts: impl Iterator<Item = AnyContact>) -> Self {
        let contacts: Vec<_> = contacts.collect();
        let is_f64 = contacts.iter().any(|contact| matches!(contact, AnyContact::F64(_)));
        let segments: Vec<_> = contacts.iter().map(|contact| contact.widened().segment).collect();
        let from =
            segments.first().map_or([0.0; 3], |[end, _]| if is_f64 { *end } else { [0.0; 3] });
        let reach = |p: &[f64; 3]| (0..3).map(|k| (p[k] - from[k]).abs()).fold(0.0, f64::max);
        let largest = segments.as_flattened().iter().map(reach).fold(0.0, f64::max);
        // As triangles of two corners, ends that are near are joined as vertices are.
        let triangles = (0..segments.len() as u32).map(|i| [2 * i, 2 * i + 1, 2 * i + 1]).collect();
        let positions = segments.as_flattened().to_vec();
        let mut joined = TriangleMesh { positions, triangles };
        joined.weld_within(NEAR * largest);
        let TriangleMesh { positions: points, triangles } = joined;
        let ends = triangles.iter().filter(|[a, b, _]| a != b);
        let mut ends: Vec<[u32; 2]> = ends.map(|[a, b, _]| [*a.min(b), *a.max(b)]).collect();
        ends.sort_unstable();
        ends.dedup();
        let mut around = vec![Vec::new(); points.len()];
        for (segment, [a, b]) in ends.iter().enumerate() {
            around[*a as usize].push(segment);
            around[*b as usize].push(segment);
        }
        let mut is_used = vec![false; ends.len()];
        let mut lines = Vec::new();
        // From where polylines end; then what is left is closed.
        for closed in [false, true] {
            for start in 0..around.len() {
                if closed || around[start].len() != 2 {
                    for &segment in &around[start] {
                        lines.extend(follow(start as u32, segment, &ends, &around, &mut is_used));
                    }
                }
            }
        }
        Self { points, lines, is_f64 }
    }

    /// Writes them as OBJ.
    pub(crate) fn write(&self, to: &mut impl Write) -> io::Result<()> {
        write_polylines(to, &self.points, &self.lines, !self.is_f64)
    }

    pub(crate) fn len(&self) -> usize {
        self.lines.len()
    }
}

/// The polyline that leaves `start` by a segment, up to where other than two segments end.
fn follow(
    start: u32,
    mut segment: usize,
    ends: &[[u32; 2]],
    around: &[Vec<usize>],
    is_used: &mut [bool],
) -> Option<Vec<u32>> {
    let mut line = vec![start];
    let mut at = start;
    while !std::mem::replace(&mut is_used[segment], true) {
        let [a, b] = ends[segment];
        at = if at == a { b } else { a };
        line.push(at);
        match around[at as usize][..] {
            [one, other] => segment = if one == segment { other } else { one },
            _ => break,
        }
    }
    (line.len() > 1).then_some(line)
}
