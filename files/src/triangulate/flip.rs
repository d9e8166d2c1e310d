//! Flips edges within a triangulated face, so that few of its triangles are around any corner.

use super::blockers::{Point, area};
use std::collections::{HashMap, HashSet};

/// The triangles around a corner, unless the outline of the face asks for more.
const MOST: usize = 12;

/// Triangles that may be looked at for each corner of the face: a bound for outlines that leave nothing to flip.
const TRIES: usize = 8;

/// Flips edges of corners with more triangles than [`MOST`], each to two corners that have fewer. The triangles cover the same
/// before and after, and turn left.
pub(super) fn lower_valence(triangles: &mut [[u32; 3]], points: &[Point]) {
    let mut valence = vec![0; points.len()];
    triangles.as_flattened().iter().for_each(|&corner| valence[corner as usize] += 1);
    let is_crowded = |corner: &u32| valence[*corner as usize] > MOST;
    let crowded: Vec<u32> = (0..points.len() as u32).filter(is_crowded).collect();
    // The triangles around these corners; some no longer are.
    let mut around: HashMap<u32, Vec<usize>> = HashMap::new();
    for (number, triangle) in triangles.iter().enumerate() {
        for corner in triangle.iter().filter(|corner| is_crowded(corner)) {
            around.entry(*corner).or_default().push(number);
        }
    }
    let mut looked_at = 0;
    for centre in crowded {
        let mut flips = true;
        while flips && looked_at < TRIES * points.len() && valence[centre as usize] > MOST {
            let spokes = spokes(centre, &around[&centre], triangles);
            looked_at += spokes.len();
            flips = false;
            let mut at = 0;
            while let [[a, w, first], [_, b, second], ..] = spokes[at..] {
                at += 1;
                let has_room = [a, b].iter().all(|&end| valence[end as usize] < MOST);
                let [v, p, q, r] = [centre, a, w, b].map(|corner| points[corner as usize]);
                if !has_room || area(v, p, r) <= 0.0 || area(p, q, r) <= 0.0 {
                    continue;
                }
                triangles[first as usize] = [centre, a, b];
                triangles[second as usize] = [a, w, b];
                for (corner, triangle) in [(b, first), (a, second)] {
                    valence[corner as usize] += 1;
                    if let Some(own) = around.get_mut(&corner) {
                        own.push(triangle as usize);
                    }
                }
                [centre, w].iter().for_each(|&corner| valence[corner as usize] -= 1);
                flips = true;
                // The next but one, or one end would get them all.
                at += 1;
            }
        }
    }
}

/// The triangles around a corner, one beside the other: the corners before and after, and the number.
fn spokes(centre: u32, around: &[usize], triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let turned = around.iter().filter_map(|&number| {
        let triangle = triangles[number];
        let at = triangle.iter().position(|&corner| corner == centre)?;
        Some((triangle[(at + 1) % 3], [triangle[(at + 2) % 3], number as u32]))
    });
    let mut beside: HashMap<u32, [u32; 2]> = turned.collect();
    let after: HashSet<u32> = beside.values().map(|[after, _]| *after).collect();
    let first = beside.keys().copied().filter(|before| !after.contains(before)).min();
    let mut spokes = Vec::new();
    let mut before = first;
    while let Some((at, [after, number])) = before.and_then(|at| Some((at, beside.remove(&at)?))) {
        spokes.push([at, after, number]);
        before = Some(after);
    }
    spokes
}
