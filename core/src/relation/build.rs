//! How a solid is made of a mesh.

use super::cones;
use super::fans::{Bits, Sets, edge_of, link, sort_by_edge};
use super::ray::own_winding;
use super::solid::{DEGENERATE, HEADER, MARKED, solid_bound, solid_scratch_bound};
use super::trees::write_cones;
use super::{NotSolid, Rule, Solid};
use crate::bvtt::{PairBvtt, PosedBvh, Query, SelfBvtt, TrianglePair};
use crate::exact::Exact;
use crate::triangle::projection;
use crate::{Bvh, CapacityError, Mesh};
use core::ops::ControlFlow;

impl<'a> Solid<'a> {
    /// Finds what has to be known of a mesh: once, as long as neither its triangles nor its positions change.
    ///
    /// # Errors
    /// [`NotSolid`] names the triangle; or the buffer, which [`solid_bound`] and [`solid_scratch_bound`] measure.
    ///
    /// # Complexity
    /// O(n log n), a self query, and a ray for each patch, which takes as long as what it meets is much; an edge of k triangles takes
    /// O(k²).
    pub fn new(bvh: Bvh<'a>, words: &'a mut [u32], scratch: &mut [u32]) -> Result<Self, NotSolid> {
        Self::of(bvh, words, scratch, false)
    }

    /// The same of a mesh that is asked about as a surface, open or not, and has no interior. It may meet itself.
    ///
    /// # Errors
    /// [`NotSolid::NoArea`], or [`NotSolid::Capacity`].
    ///
    /// # Complexity
    /// O(n log n).
    ///
    /// # Examples
    /// ```
    /// use pfront_core::bvh::{BuildOptions, BvhStorage, morton, node_bound};
    /// use pfront_core::relation::{Rule, Solid, solid_bound, solid_scratch_bound};
    /// use pfront_core::{Mesh, Node};
    /// let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])?;
    /// let (mut nodes, mut order) = ([Node::EMPTY; node_bound(1)], [0; 1]);
    /// let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
    /// let bvh = morton(mesh, &BuildOptions::default(), storage, &mut [0; 2])?;
    /// let (mut words, mut scratch) = ([0; solid_bound(3, 1)], [0; solid_scratch_bound(3, 1)]);
    /// assert_eq!(Solid::surface(bvh, &mut words, &mut scratch)?.rule(), Rule::Surface);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn surface(
        bvh: Bvh<'a>,
        words: &'a mut [u32],
        scratch: &mut [u32],
    ) -> Result<Self, NotSolid> {
        Self::of(bvh, words, scratch, true)
    }

    fn of(
        bvh: Bvh<'a>,
        words: &'a mut [u32],
        scratch: &mut [u32],
        is_surface: bool,
    ) -> Result<Self, NotSolid> {
        let (mesh, n) = (bvh.mesh(), bvh.mesh().triangles().len());
        let vertices = mesh.vertex_count();
        // Half-edges have numbers, and vertices 31 bits.
        CapacityError::check("triangles of a solid", n, u32::MAX as usize / 3)?;
        CapacityError::check("vertices of a solid", vertices, cones::ROOT as usize)?;
        CapacityError::check("words", solid_bound(vertices, n), words.len())?;
        CapacityError::check("scratch", solid_scratch_bound(vertices, n), scratch.len())?;
        let words = &mut words[..solid_bound(vertices, n)];
        let (first, cones) = words.split_at_mut(HEADER + 9 * n);
        let (header, lists) = first.split_at_mut(HEADER);
        let (corners, lists) = lists.split_at_mut(3 * n);
        let (next, lists) = lists.split_at_mut(3 * n);
        let (patch_of, patches) = lists.split_at_mut(n);
        let (weld, scratch) = scratch.split_at_mut(2 * vertices);
        let (half_edges, scratch) = scratch.split_at_mut(3 * n);
        let mut marks = Bits(&mut scratch[..n.div_ceil(32)]);
        marks.0.fill(0);

        let (corners, _) = corners.as_chunks_mut();
        weld_corners(mesh, weld, corners);
        let len = sort_by_edge(corners, &mut weld[..vertices], half_edges);
        let rule = if is_surface { Rule::Surface } else { rule(corners, &half_edges[..len])? };
        mark_degenerate(mesh, patch_of);
        link_fans(corners, &half_edges[..len], rule, patch_of, next, &mut marks);
        let lowest = if is_surface { None } else { mark_hits(&bvh, corners, patch_of, &mut marks) };
        let count = join_patches(corners, next, &marks, patch_of, patches);
        header[..2].copy_from_slice(&[count as u32, rule as u32]);
        let first_mark =
            || (0..n as u32).find(|&t| marks.has(t)).map(|t| TrianglePair { a: t, b: t });
        let lowest = lowest.or_else(first_mark);
        let marked = lowest.unwrap_or(TrianglePair { a: u32::MAX, b: u32::MAX });
        header[2..].copy_from_slice(&[marked.a, marked.b]);
        let mut has_volume = false;
        let itself = PairBvtt::in_world(PosedBvh::unposed(bvh), PosedBvh::unposed(bvh));
        for patch in patches[..2 * count].chunks_exact_mut(2) {
            if is_surface {
                patch[1] = 0;
            } else if patch_of[patch[0] as usize] & MARKED == 0 {
                let front = own_winding(&itself, 0, patch[0]).unwrap_or(0);
                patch[1] = front as u32;
                has_volume |= rule.is_inside(front) != rule.is_inside(front + 1);
            }
        }
        match lowest {
            _ if has_volume || is_surface && count > 0 => {}
            _ if is_surface => return Err(NotSolid::NoArea),
            Some(pair) => return Err(NotSolid::MeetsItself { pair }),
            None => return Err(NotSolid::NoVolume),
        }
        marks.0.fill(0);
        write_cones(&Solid::new_unchecked(bvh, first), cones, [weld, half_edges], &mut marks);
        Ok(Self::new_unchecked(bvh, words))
    }
}

impl Rule {
    /// The rule of a mesh that is closed, whatever else there is to know of it before it is a [`Solid`]. Takes 2 words of scratch memory a
    /// vertex and 6 a triangle.
    ///
    /// # Errors
    /// [`NotSolid::OpenEdge`], or [`NotSolid::Capacity`].
    ///
    /// # Complexity
    /// O(n log n).
    ///
    /// # Examples
    /// ```
    /// use pfront_core::relation::{NotSolid, Rule};
    /// use pfront_core::Mesh;
    /// let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// let triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    /// let mut scratch = [0; 2 * 4 + 6 * 4];
    /// assert_eq!(Rule::of(Mesh::new(&corners, &triangles)?, &mut scratch), Ok(Rule::NonZero));
    /// let open = Rule::of(Mesh::new(&corners, &triangles[..3])?, &mut scratch);
    /// assert_eq!(open, Err(NotSolid::OpenEdge { triangle: 0, edge: 1 }));
    /// # Ok::<(), pfront_core::MeshError>(())
    /// ```
    pub fn of(mesh: Mesh<'_>, scratch: &mut [u32]) -> Result<Self, NotSolid> {
        let (vertices, n) = (mesh.vertex_count(), mesh.triangles().len());
        CapacityError::check("triangles of a solid", n, u32::MAX as usize / 3)?;
        CapacityError::check("scratch", 2 * vertices + 6 * n, scratch.len())?;
        let (weld, scratch) = scratch.split_at_mut(2 * vertices);
        let (corners, scratch) = scratch.split_at_mut(3 * n);
        let (corners, _) = corners.as_chunks_mut();
        weld_corners(mesh, weld, corners);
        let half_edges = &mut scratch[..3 * n];
        let len = sort_by_edge(corners, &mut weld[..vertices], half_edges);
        rule(corners, &half_edges[..len])
    }
}

/// Writes the corners with each position's lowest vertex.
fn weld_corners(mesh: Mesh<'_>, scratch: &mut [u32], corners: &mut [[u32; 3]]) {
    let (order, lowest) = scratch.split_at_mut(mesh.vertex_count());
    (0..).zip(&mut *order).for_each(|(vertex, slot)| *slot = vertex);
    // Adding 0 makes −0 and 0 the same to the bit, and so in a total order.
    let key = |vertex: u32| mesh.position_f64(vertex).map(|x| x + 0.0);
    let compare = |p: &[f64; 3], q: &[f64; 3]| {
        p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])).then(p[2].total_cmp(&q[2]))
    };
    order.sort_unstable_by(|&v, &w| compare(&key(v), &key(w)).then(v.cmp(&w)));
    for alike in order.chunk_by(|&v, &w| key(v) == key(w)) {
        alike.iter().for_each(|&vertex| lowest[vertex as usize] = alike[0]);
    }
    for (own, triangle) in corners.iter_mut().zip(mesh.triangles()) {
        *own = triangle.map(|vertex| lowest[vertex as usize]);
    }
}

/// Half-edges of one edge after another.
fn by_edge<'s>(corners: &'s [[u32; 3]], half_edges: &'s [u32]) -> impl Iterator<Item = &'s [u32]> {
    half_edges.chunk_by(|&x, &y| edge_of(corners, x).0 == edge_of(corners, y).0)
}

/// By how much more half-edges run from the lower vertex to the higher than the other way.
fn excess(corners: &[[u32; 3]], half_edges: impl Iterator<Item = u32>) -> i32 {
    half_edges.map(|half_edge| if edge_of(corners, half_edge).1 { 1 } else { -1 }).sum()
}

fn rule(corners: &[[u32; 3]], half_edges: &[u32]) -> Result<Rule, NotSolid> {
    let mut rule = Rule::NonZero;
    let mut open: Option<u32> = None;
    for fan in by_edge(corners, half_edges) {
        if fan.len() % 2 != 0 {
            open = Some(open.map_or(fan[0], |open| open.min(fan[0])));
        } else if excess(corners, fan.iter().copied()) != 0 {
            rule = Rule::Odd;
        }
    }
    match open {
        Some(half_edge) => Err(NotSolid::OpenEdge { triangle: half_edge / 3, edge: half_edge % 3 }),
        None => Ok(rule),
    }
}

/// Writes [`DEGENERATE`] for triangles of no area, and 0 for others.
fn mark_degenerate(mesh: Mesh<'_>, patch_of: &mut [u32]) {
    for (triangle, patch) in (0..).zip(patch_of) {
        let has_area = match mesh.is_f64() {
            false => projection::<Exact<f32>>(&mesh.shadow_triangle(triangle)).flatten().is_some(),
            true => projection::<Exact<f64>>(&mesh.triangle_f64(triangle)).flatten().is_some(),
        };
        *patch = if has_area { 0 } else { DEGENERATE };
    }
}

/// Links the fans of triangles with areas, and marks those at edges that are open without the others.
fn link_fans(
    corners: &[[u32; 3]],
    half_edges: &[u32],
    rule: Rule,
    patch_of: &[u32],
    next: &mut [u32],
    marks: &mut Bits<'_>,
) {
    (0..).zip(&mut *next).for_each(|(half_edge, next)| *next = half_edge);
    for fan in by_edge(corners, half_edges) {
        let with_area =
            fan.iter().copied().filter(|&half_edge| patch_of[half_edge as usize / 3] == 0);
        link(with_area.clone(), next);
        let is_balanced = match rule {
            Rule::NonZero => excess(corners, with_area.clone()) == 0,
            Rule::Odd => with_area.clone().count() % 2 == 0,
            Rule::Surface => true,
        };
        if !is_balanced {
            with_area.for_each(|half_edge| marks.set(half_edge / 3));
        }
    }
}

/// Marks triangles that meet their mesh beyond the corners that they share. Returns the lowest pair.
fn mark_hits(
    bvh: &Bvh<'_>,
    corners: &[[u32; 3]],
    patch_of: &[u32],
    marks: &mut Bits<'_>,
) -> Option<TrianglePair> {
    let welded = Bvh::new_unchecked(bvh.mesh().with_triangles(corners), bvh.nodes(), bvh.order());
    let (query, mut lowest) = (SelfBvtt::new(welded), None);
    let _ = query.visit(&mut query.start(), |pair| {
        if patch_of[pair.a as usize] == 0 && patch_of[pair.b as usize] == 0 {
            marks.set_pair(pair);
            lowest = Some(lowest.map_or(pair, |lowest: TrianglePair| lowest.min(pair)));
        }
        ControlFlow::Continue(())
    });
    lowest
}

/// Joins triangles to patches, numbers these, and writes a triangle of each. Returns how many there are.
///
/// Unmarked triangles are joined where two share an edge alone, and are oriented alike; marked ones over all edges.
fn join_patches(
    corners: &[[u32; 3]],
    next: &[u32],
    marks: &Bits<'_>,
    patch_of: &mut [u32],
    patches: &mut [u32],
) -> usize {
    let n = corners.len();
    // Parents overlap neither with numbers nor with what is degenerate.
    let mut sets = Sets(&mut patches[..n]);
    (0..).zip(&mut *sets.0).for_each(|(triangle, parent)| *parent = triangle);
    for half_edge in 0..3 * n as u32 {
        let own = half_edge / 3;
        if patch_of[own as usize] == DEGENERATE {
            continue;
        }
        let other = next[half_edge as usize];
        let is_joined = if marks.has(own) {
            marks.has(other / 3)
        } else {
            let is_alike = edge_of(corners, half_edge).1 != edge_of(corners, other).1;
            let is_pair = next[other as usize] == half_edge && other != half_edge;
            is_pair && is_alike && !marks.has(other / 3)
        };
        if is_joined {
            sets.join(own, other / 3);
        }
    }
    let mut count = 0;
    for triangle in 0..n as u32 {
        let root = sets.root(triangle);
        if patch_of[triangle as usize] == DEGENERATE {
            continue;
        }
        // Roots are the lowest of their sets, and have their numbers already.
        patch_of[triangle as usize] = if root == triangle {
            count += 1;
            (count - 1) | if marks.has(triangle) { MARKED } else { 0 }
        } else {
            patch_of[root as usize]
        };
    }
    for triangle in (0..n as u32).rev() {
        let patch = patch_of[triangle as usize];
        if patch != DEGENERATE {
            patches[2 * (patch & !MARKED) as usize] = triangle;
        }
    }
    count as usize
}
