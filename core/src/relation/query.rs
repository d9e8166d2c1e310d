//! The query for the relation of two solids.

use super::fans::{Bits, edge_of, fan};
use super::picture::{HalfPlane, Picture, Run, run};
use super::ray::{Posed, own_winding, winding};
use super::seen::{BOTH, ONLY_A, ONLY_B, Seen, relation_of, seen_bound};
use super::solid::{DEGENERATE, MARKED};
use super::{Between, Relation, Rule, Solid};
use crate::bvtt::{PairBvtt, Query, TrianglePair};
use crate::exact::Exact;
use crate::exact::orientation::sides;
use crate::pose::PoseError;
use crate::scalar::Scalar;
use crate::triangle::{arrange, intersects_as_in_mesh, projection};
use crate::{Aabb, CapacityError, Pose};
use core::ops::ControlFlow;
use core::sync::atomic::{AtomicU8, Ordering::Relaxed};
use glam::{DVec3, Vec3A};

/// The query for the relation of two solids, the second posed into the frame of the first.
///
/// # Examples
/// ```
/// use pfront_core::bvh::{BuildOptions, BvhStorage, morton, node_bound};
/// use pfront_core::relation::*;
/// use pfront_core::{Mesh, Node, Pose};
/// let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let mesh = Mesh::new(&corners, &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])?;
/// let (mut nodes, mut order) = ([Node::EMPTY; node_bound(4)], [0; 4]);
/// let storage = BvhStorage { nodes: &mut nodes, order: &mut order };
/// let bvh = morton(mesh, &BuildOptions::default(), storage, &mut [0; 8])?;
/// let (mut words, mut scratch) = ([0; solid_bound(4, 4)], [0; solid_scratch_bound(4, 4)]);
/// let solid = Solid::new(bvh, &mut words, &mut scratch)?;
/// let relation = |x| {
///     let query = RelationQuery::new(&solid, &solid, Pose::from_translation([x, 0.0, 0.0]))?;
///     let between = query.relation(&mut [0; 1])?;
///     Ok::<_, Box<dyn std::error::Error>>(between.relation.expect("no triangle meets its own mesh"))
/// };
/// assert_eq!(relation(0.0)?, Relation::Equal);
/// assert_eq!(relation(0.5)?, Relation::Crossing);
/// assert_eq!(relation(1.0)?, Relation::Touching);
/// assert_eq!(relation(1.5)?, Relation::Apart);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct RelationQuery<'a> {
    pub(super) query: PairBvtt<'a>,
    pub(super) solids: [Solid<'a>; 2],
    /// Whether the pose rounds no position of the second mesh, so that all that is known of its solid holds where it is posed:
    /// 0 if that has not been looked at, then 1 or 2.
    exactness: AtomicU8,
}

impl<'a> RelationQuery<'a> {
    /// Asks for the relation of `a` and `b` posed by `a_from_b`.
    ///
    /// # Errors
    /// [`PoseError`] if the pose is not finite or takes `b` out of range.
    pub fn new(a: &Solid<'a>, b: &Solid<'a>, a_from_b: Pose) -> Result<Self, PoseError> {
        Ok(Self::of_pair(PairBvtt::new(a.bvh(), b.bvh(), a_from_b)?, a, b))
    }

    /// The same of a query about the meshes of both, the first of which is not posed: [`PairBvtt::new`] or `PairBvtt::in_f64`.
    #[must_use]
    pub fn of_pair(query: PairBvtt<'a>, a: &Solid<'a>, b: &Solid<'a>) -> Self {
        Self { query, solids: [*a, *b], exactness: AtomicU8::new(0) }
    }

    /// The query for the pairs that are to be [added](RelationQuery::add).
    #[must_use]
    pub fn pairs(&self) -> &PairBvtt<'a> {
        &self.query
    }

    /// The number of patches of both solids.
    #[must_use]
    pub fn patches(&self) -> usize {
        self.solids[0].patches() + self.solids[1].patches()
    }

    /// The relation, on the calling thread; `lines` has [`seen_bound`] words for the patches of both.
    ///
    /// # Errors
    /// [`CapacityError`] if it has fewer.
    ///
    /// # Complexity
    /// As [`Query::any`](crate::bvtt::Query::any) if the solids cross where they are first found to meet; else of all pairs, with
    /// about a microsecond for each, and a ray for each patch that meets the other along no line.
    pub fn relation(&self, lines: &mut [u32]) -> Result<Between, CapacityError> {
        let mut seen = Seen::new(self, lines)?;
        let _ = self.query.visit(&mut self.query.start(), |pair| self.add(&mut seen, pair));
        Ok(self.conclude(seen))
    }

    /// Adds what a pair of triangles shows that intersect. Breaks when the solids are known to cross.
    pub fn add(&self, seen: &mut Seen<'_>, pair: TrianglePair) -> ControlFlow<()> {
        seen.meets = true;
        seen.pair = Some(seen.pair.map_or(pair, |own| own.min(pair)));
        match self.query.is_f64() {
            false => self.add_posed::<f32>(seen, pair),
            true => self.add_posed::<f64>(seen, pair),
        }
        if !seen.is_crossing() {
            return ControlFlow::Continue(());
        }
        seen.pair = Some(pair);
        ControlFlow::Break(())
    }

    /// The relation, when all pairs have been added or the solids are known to cross.
    #[must_use]
    pub fn conclude(&self, mut seen: Seen<'_>) -> Between {
        let (meets, mut pair) = (seen.meets, seen.pair);
        if seen.is_crossing() {
            return Between { relation: Some(Relation::Crossing), meets, pair, is_rounded: false };
        }
        let doubtful = self.look_from_patches(&mut seen);
        let relation = relation_of(seen.classes, meets);
        let is_open = seen.undetermined.is_some() && relation != Relation::Crossing;
        if is_open || seen.is_rounded || relation_of(seen.classes | doubtful, meets) != relation {
            let is_rounded = seen.is_rounded && seen.undetermined.is_none();
            return Between { relation: None, meets, pair: seen.undetermined.or(pair), is_rounded };
        }
        if relation != Relation::Crossing && !meets {
            pair = None;
        }
        Between { relation: Some(relation), meets, pair, is_rounded: false }
    }

    /// Adds the classes on both sides of each patch that meets the other mesh along no line. Returns those that may occur at marked
    /// patches.
    fn look_from_patches(&self, seen: &mut Seen<'_>) -> u8 {
        let mut doubtful = 0;
        for mesh in 0..2 {
            // Points of the surface are looked at, if one of both is a surface.
            if self.is_surface(1 - mesh) {
                continue;
            }
            for patch in 0..self.solids[mesh].patches() as u32 {
                if seen.is_on_line(patch + self.first_patch(mesh)) {
                    continue;
                }
                let (triangle, mut front) = self.solids[mesh].patch(patch);
                let is_marked = self.solids[mesh].patch_of(triangle) & MARKED != 0;
                let of = [mesh, 1 - mesh];
                let other = match self.query.is_f64() {
                    false => winding::<f32>(&self.query, of, triangle),
                    true => winding::<f64>(&self.query, of, triangle),
                };
                let Ok(other) = other else {
                    seen.is_rounded = true;
                    continue;
                };
                if mesh == 1 && !is_marked && !self.is_surface(1) && !self.is_exact() {
                    let Ok(posed) = own_winding(&self.query, 1, triangle) else {
                        seen.is_rounded = true;
                        continue;
                    };
                    front = posed;
                    let rule = self.solids[1].rule();
                    // Rounding may have made a patch that bounds nothing one that does.
                    seen.is_rounded |= rule.is_inside(front) == rule.is_inside(front + 1);
                }
                let sides = if is_marked { [0, 1] } else { [front, front + 1] };
                let mut classes = 0;
                for own in sides {
                    let mut windings = [own, other];
                    windings.rotate_right(mesh);
                    classes |= self.class(windings);
                }
                match is_marked {
                    false => seen.classes |= classes,
                    true => doubtful |= classes,
                }
            }
        }
        doubtful
    }

    /// A point near the middle of what the boxes of both have in common.
    pub(super) fn middle(&self) -> DVec3 {
        let [a, b] = self.query.sides().map(|side| side.aabb().unwrap_or(Aabb::EMPTY));
        let [low, high] = [
            Vec3A::from_array(a.min).max(Vec3A::from_array(b.min)),
            Vec3A::from_array(a.max).min(Vec3A::from_array(b.max)),
        ];
        let centre = (low * 0.5 + high * 0.5).as_dvec3();
        let centre = if centre.is_finite() { centre } else { DVec3::ZERO };
        centre + DVec3::from_array(self.query.sides()[0].bvh.mesh().origin())
    }

    /// The number of the first patch of a mesh among those of both.
    fn first_patch(&self, mesh: usize) -> u32 {
        if mesh == 0 { 0 } else { self.solids[0].patches() as u32 }
    }

    /// The class of points with these winding numbers; of a surface only its own points are looked at.
    fn class(&self, windings: [i32; 2]) -> u8 {
        let [a, b] = [0, 1].map(|mesh| {
            let rule = self.solids[mesh].rule();
            rule == Rule::Surface || rule.is_inside(windings[mesh])
        });
        match (a, b) {
            (true, true) => BOTH,
            (true, false) => ONLY_A,
            (false, true) => ONLY_B,
            (false, false) => 0,
        }
    }

    #[inline(never)]
    fn add_posed<C: Posed>(&self, seen: &mut Seen<'_>, pair: TrianglePair) {
        let faces = [pair.a, pair.b];
        let patches = [0, 1].map(|mesh| self.solids[mesh].patch_of(faces[mesh]));
        if patches.contains(&DEGENERATE) {
            // Rounding may have given it an area.
            seen.is_rounded |= !self.is_exact();
            return;
        }
        let corners = [0, 1].map(|mesh| C::corners(self.query.sides()[mesh], faces[mesh]));
        let sides = [
            sides(corners[1].each_ref(), corners[0].each_ref()),
            sides(corners[0].each_ref(), corners[1].each_ref()),
        ];
        if patches.iter().any(|patch| patch & MARKED != 0) {
            seen.undetermined = Some(seen.undetermined.map_or(pair, |own| own.min(pair)));
            self.note_line(seen, 0, pair.a);
            self.note_line(seen, 1, pair.b);
            return;
        }
        if cross_inside(&corners, &sides) {
            self.add_crossing::<C>(seen, pair);
        } else if !self.is_exact() {
            seen.is_rounded = true;
        } else {
            self.add_edges(seen, faces, &corners, &sides);
        }
    }

    /// Adds the classes around a point in which the interiors of two triangles cross.
    fn add_crossing<C: Posed>(&self, seen: &mut Seen<'_>, pair: TrianglePair) {
        let mut fronts = [self.front(0, pair.a), self.front(1, pair.b)];
        if !self.is_surface(1) && !self.is_exact_or_unknown() {
            let front = own_winding(&self.query, 1, pair.b);
            let Some(front) = front.ok().filter(|_| !self.meets_itself::<C>(pair.b)) else {
                seen.is_rounded = true;
                return;
            };
            fronts[1] = front;
        }
        for a in [fronts[0], fronts[0] + 1] {
            for b in [fronts[1], fronts[1] + 1] {
                seen.classes |= self.class([a, b]);
            }
        }
        self.note_line(seen, 0, pair.a);
        self.note_line(seen, 1, pair.b);
    }

    /// The winding number in front of an unmarked triangle, unposed.
    fn front(&self, mesh: usize, triangle: u32) -> i32 {
        self.solids[mesh].patch(self.solids[mesh].patch_of(triangle)).1
    }

    /// Notes that the patch of a triangle meets the other mesh along a line.
    fn note_line(&self, seen: &mut Seen<'_>, mesh: usize, triangle: u32) {
        let patch = self.solids[mesh].patch_of(triangle);
        if patch != DEGENERATE {
            Bits(seen.lines).set((patch & !MARKED) + self.first_patch(mesh));
        }
    }

    /// Adds the classes around the lines along which an edge of one triangle meets the other.
    fn add_edges<C: Posed>(
        &self,
        seen: &mut Seen<'_>,
        faces: [u32; 2],
        corners: &[[[C; 3]; 3]; 2],
        sides: &[[i32; 3]; 2],
    ) {
        for mesh in 0..2 {
            let (own, other) = (&corners[mesh], &corners[1 - mesh]);
            for k in 0..3 {
                let ends = [k, (k + 1) % 3];
                let half_edge = 3 * faces[mesh] + k as u32;
                if ends.iter().any(|&end| sides[mesh][end] != 0) || !self.is_lowest(mesh, half_edge)
                {
                    continue;
                }
                let line = ends.map(|end| own[end]);
                let Some(Some(seen_from)) = projection::<Exact<C>>(other) else { return };
                let mut picture = Picture::new(line);
                let is_whole = match run(&line, other, &seen_from) {
                    Run::Not => continue,
                    Run::Along(_) if mesh == 1 => continue,
                    Run::Along(edge) => {
                        let along = 3 * faces[1] + edge as u32;
                        if !self.is_lowest(1, along) {
                            continue;
                        }
                        self.push_fan(seen, &mut picture, 0, half_edge).zip(self.push_fan(
                            seen,
                            &mut picture,
                            1,
                            along,
                        ))
                    }
                    Run::Through(halves) => {
                        self.note_line(seen, 1 - mesh, faces[1 - mesh]);
                        let fan = self.push_fan(seen, &mut picture, mesh, half_edge);
                        let front = self.front(1 - mesh, faces[1 - mesh]);
                        let at = picture.len();
                        let all = halves.iter().all(|&(point, is_forward)| {
                            picture.push(half_plane(point, 1 - mesh, is_forward))
                        });
                        let after = if halves[0].1 { front } else { front + 1 };
                        let known = all.then_some((at, after));
                        if mesh == 0 { fan.zip(known) } else { known.zip(fan) }
                    }
                };
                match is_whole.filter(|_| self.are_surfaces() != [true; 2]) {
                    Some((a, b)) => picture.visit([a, b], |before, meshes, after| {
                        let class = self.class(after);
                        // A part of a surface that lies on the boundary of a solid is neither inside nor outside.
                        let is_seen = |mesh: usize| meshes[mesh] && self.class(before) == class;
                        if (0..2).all(|mesh| !self.is_surface(mesh) || is_seen(mesh)) {
                            seen.classes |= class;
                        }
                    }),
                    None => {
                        let pair = TrianglePair { a: faces[0], b: faces[1] };
                        seen.undetermined =
                            Some(seen.undetermined.map_or(pair, |own| own.min(pair)));
                    }
                }
            }
        }
    }

    /// Adds the half-planes of the fan of a half-edge on the line of a picture. Returns the place of that of the half-edge and the
    /// winding number after it; `None` if there was no room.
    fn push_fan<C: Posed>(
        &self,
        seen: &mut Seen<'_>,
        picture: &mut Picture<C>,
        mesh: usize,
        half_edge: u32,
    ) -> Option<(usize, i32)> {
        let (solid, place) = (&self.solids[mesh], picture.len());
        let is_reversed = picture.is_against(&self.ends::<C>(mesh, half_edge));
        let is_first_forward = edge_of(solid.corners(), half_edge).1;
        for other in fan(solid.next(), half_edge) {
            let triangle = other / 3;
            self.note_line(seen, mesh, triangle);
            let corners = C::corners(self.query.sides()[mesh], triangle);
            let is_alike = edge_of(solid.corners(), other).1 == is_first_forward;
            let half = half_plane(corners[(other as usize + 2) % 3], mesh, is_alike != is_reversed);
            if !picture.push(half) {
                return None;
            }
        }
        let front = self.front(mesh, half_edge / 3);
        Some((place, if is_reversed { front + 1 } else { front }))
    }

    /// The posed ends of a half-edge.
    fn ends<C: Posed>(&self, mesh: usize, half_edge: u32) -> [[C; 3]; 2] {
        let corners = C::corners(self.query.sides()[mesh], half_edge / 3);
        let k = half_edge as usize % 3;
        [corners[k], corners[(k + 1) % 3]]
    }

    fn is_surface(&self, mesh: usize) -> bool {
        self.solids[mesh].rule() == Rule::Surface
    }

    /// Whether each mesh is a surface.
    pub(super) fn are_surfaces(&self) -> [bool; 2] {
        [0, 1].map(|mesh| self.is_surface(mesh))
    }

    /// Whether a half-edge is the lowest of its edge: the line of an edge is looked at once for each triangle that it meets.
    pub(super) fn is_lowest(&self, mesh: usize, half_edge: u32) -> bool {
        fan(self.solids[mesh].next(), half_edge).all(|other| half_edge <= other)
    }

    /// Whether the posed second mesh is the second solid without any rounding.
    pub(super) fn is_exact(&self) -> bool {
        if self.exactness.load(Relaxed) == 0 {
            let is_exact = self.query.sides()[1].is_exact();
            self.exactness.store(if is_exact { 1 } else { 2 }, Relaxed);
        }
        self.is_exact_or_unknown()
    }

    /// Whether it has been found to be, or is not posed.
    fn is_exact_or_unknown(&self) -> bool {
        self.exactness.load(Relaxed) == 1 || self.query.sides()[1].is_unposed()
    }

    /// Whether a triangle of the second mesh meets its own mesh, where they are posed, beyond the corners that they share.
    fn meets_itself<C: Posed>(&self, triangle: u32) -> bool {
        let (side, solid) = (self.query.sides()[1], &self.solids[1]);
        let corners =
            |triangle: u32| (solid.corners()[triangle as usize], C::corners(side, triangle));
        let (own, near) = (corners(triangle), self.query.box_of_triangle(1, triangle));
        let found = self.query.visit_overlapping(1, &near, |other| {
            let is_hit = other != triangle
                && solid.patch_of(other) != DEGENERATE
                && intersects_as_in_mesh(&own, &corners(other));
            if is_hit { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        found.is_break()
    }
}

impl<'s> Seen<'s> {
    /// Nothing seen yet.
    ///
    /// # Errors
    /// [`CapacityError`] if `lines` has fewer words than [`seen_bound`] of the patches of both solids together.
    pub fn new(query: &RelationQuery<'_>, lines: &'s mut [u32]) -> Result<Self, CapacityError> {
        let needed = seen_bound(query.patches());
        CapacityError::check("lines", needed, lines.len())?;
        let lines = &mut lines[..needed];
        lines.fill(0);
        let (pair, undetermined) = (None, None);
        // Points of a surface alone are looked at, so those that only the other has are taken for granted.
        let [is_a, is_b] = query.are_surfaces();
        let classes = (u8::from(is_a) * ONLY_B) | (u8::from(is_b) * ONLY_A);
        Ok(Self { classes, meets: false, pair, undetermined, is_rounded: false, lines })
    }
}

fn half_plane<C>(point: [C; 3], mesh: usize, is_forward: bool) -> HalfPlane<C> {
    HalfPlane { point, mesh, step: if is_forward { -1 } else { 1 } }
}

/// Whether the interiors of two triangles that intersect cross: each reaches beyond the plane of the other on both sides, and on the
/// line common to both planes their intervals have more than a point in common.
fn cross_inside<C: Scalar>([a, b]: &[[[C; 3]; 3]; 2], [a_sides, b_sides]: &[[i32; 3]; 2]) -> bool {
    let reaches_beyond = |sides: &[i32; 3]| sides.contains(&1) && sides.contains(&-1);
    if !reaches_beyond(a_sides) || !reaches_beyond(b_sides) {
        return false;
    }
    let ([a0, a1, a2], [b0, b1, b2], side) = arrange(a, a_sides, b, b_sides);
    let [first] = sides([a0, a1, b0], [b1]);
    let [second] = sides([a0, a2, b0], [b2]);
    first == -side && second == side
}
