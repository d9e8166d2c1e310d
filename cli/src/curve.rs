//! Segments of contacts, joined to polylines.

use std::collections::HashMap;
use std::io::{self, Write};

/// Ends of segments that are nearer than this, as a part of the largest coordinate, are one point: neighbouring
/// contacts compute it from different triangles.
const NEAR: f32 = 1e-6;

/// Points, and the indices of those along each polyline, the first again at the end of one that is closed.
pub(crate) struct Curves {
    points: Vec<[f32; 3]>,
    lines: Vec<Vec<u32>>,
}

impl Curves {
    /// Joins segments. Points in which more than two end, end polylines.
    pub(crate) fn of(segments: impl Iterator<Item = [[f32; 3]; 2]>) -> Self {
        let segments: Vec<_> = segments.collect();
        let largest =
            segments.as_flattened().as_flattened().iter().fold(0.0, |m: f32, x| m.max(x.abs()));
        let mut points = Points {
            cell: f64::from((NEAR * largest).max(f32::MIN_POSITIVE)),
            ..Points::default()
        };
        let mut ends: Vec<[u32; 2]> = segments
            .iter()
            .map(|segment| segment.map(|point| points.number(point)))
            .filter(|[a, b]| a != b)
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        ends.sort_unstable();
        ends.dedup();
        let mut around = vec![Vec::new(); points.points.len()];
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
        Self { points: points.points, lines }
    }

    /// Writes them as OBJ.
    pub(crate) fn write(&self, to: &mut impl Write) -> io::Result<()> {
        self.points.iter().try_for_each(|[x, y, z]| writeln!(to, "v {x} {y} {z}"))?;
        for line in &self.lines {
            write!(to, "l")?;
            line.iter().try_for_each(|point| write!(to, " {}", point + 1))?;
            writeln!(to)?;
        }
        Ok(())
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

/// Points by the cells of a grid.
#[derive(Default)]
struct Points {
    cell: f64,
    points: Vec<[f32; 3]>,
    numbers: HashMap<[i64; 3], u32>,
}

impl Points {
    /// The number of a point, which is that of another in the same cell or in one beside it.
    fn number(&mut self, point: [f32; 3]) -> u32 {
        let at = point.map(|x| (f64::from(x) / self.cell).floor() as i64);
        let cells = (0..27).map(|i| [at[0] + i % 3 - 1, at[1] + i / 3 % 3 - 1, at[2] + i / 9 - 1]);
        if let Some(&number) = cells.filter_map(|cell| self.numbers.get(&cell)).next() {
            return number;
        }
        let number = self.points.len() as u32;
        self.points.push(point);
        self.numbers.insert(at, number);
        number
    }
}
