//! Patch certificates: subtrees that provably do not intersect each other, since they lie side by side in one sheet.
//!
//! In a deforming mesh, most node pairs whose boxes overlap are neighbours on the surface. The BVH is divided into tiles,
//! which are subtrees of few triangles. A patch is some tile and all that share a vertex with it; one certificate decides all
//! pairs of its tiles, before any triangle of them is read.
//!
//! **Theorem** (after Volino and Magnenat-Thalmann, Efficient Self-Collision Detection on Smoothly Discretized Surface
//! Animations using Geometrical Shape Regularity, Computer Graphics Forum 13(3), 1994). Let no two triangles of a patch have an
//! edge in the same direction, and let those of its edges that only one triangle has form one closed line, the boundary. If the
//! normals of all its triangles have the same sign along one coordinate axis, and the projection of the boundary along that
//! axis does not touch itself, then two of the triangles have no point in common but those of the vertices, or the edge, that
//! they share by index.
//!
//! **Proof.** A normal of that sign means that the projection keeps the triangle's orientation. So the number of triangles
//! over a point of the plane is the winding number of the boundary around it, in absolute value; and that of a line which
//! does not touch itself is at most 1: the projected triangles have no interior points in common.
//!
//! Let x be a point of two projected triangles that is not of what they share. From either of them, go around x, from
//! triangle to triangle through the edges that contain x. As all have interior points near x, these walks either meet, and
//! the triangles share the edge or the vertex at x; or both end at two edges of the boundary, which then contains x twice.
//! Points in common in space have projections in common.
//!
//! Triangles of a certified patch are no hits under any rule of [`Adjacency`](crate::triangle::Adjacency). All conditions are
//! decided exactly, by certified signs and by comparisons; what is in no certified patch is tested as all else is.
//!
//! In f64, signs are those of the positions. The boundary is that of the shadow, with a bound that allows for how far the
//! difference of two of its coordinates may be from that of the positions.

use crate::bvh::Layout;
use crate::bvtt::NodePair;
use crate::index::{at, out_of_range, part, range, split};
use crate::one_ring::{CertifyOptions, MAX_DIFFERENCE, TURN_ERROR, uncertified_signs_of};
use crate::parallel::parts;
use crate::simd::point8::chunk_starts;
use crate::simd::{LANES, Simd, Task, widest};
use crate::vertex_set::{holds, moved_bound};
use crate::{Bvh, CapacityError, Mesh};

/// The patches of a mesh, which do not change while its BVH is only refitted: tables that the caller has made.
///
/// Nothing about them is checked: if they are not as described, a query may miss pairs. By default there are none.
#[derive(Clone, Copy, Debug, Default)]
pub struct Patches<'a> {
    /// The tile of each node of the BVH; [`NO_TILE`] for nodes above the tiles.
    pub tile_of: &'a [u32],
    /// For each tile, where its triangles begin in the order of the BVH, and how many they are.
    pub tiles: &'a [[u32; 2]],
    /// Where each tile begins in `pairs`, and where the last ends: one more than there are tiles.
    pub pair_starts: &'a [u32],
    /// For each tile, others whose index is not less, and a patch that holds both.
    pub pairs: &'a [[u32; 2]],
    /// Where each patch begins in `members`, and where the last ends: one more than there are patches.
    pub patch_starts: &'a [u32],
    /// For each patch, the number of its tiles, the tiles, and the vertices of its boundary, in the direction of the
    /// triangles.
    pub members: &'a [u32],
}

/// Stands for no tile.
pub const NO_TILE: u32 = u32::MAX;

/// The most vertices in a boundary that is certified.
pub const MAX_BOUNDARY: usize = 127;

/// Returns the number of words that [`Patches::certify`] needs.
#[must_use]
pub const fn patch_bound(tiles: usize, patches: usize) -> usize {
    tiles + patches
}

impl<'p> Patches<'p> {
    /// Certifies the patches for the positions of the BVH's mesh. Its boxes are not looked at.
    ///
    /// `state` must hold [`patch_bound`] words; with [`CertifyOptions::moved`], those that the last certification left. With
    /// `join`, parts of both passes, over tiles and over patches, run side by side.
    ///
    /// # Errors
    /// [`CapacityError`] if `state` is too small.
    ///
    /// # Complexity
    /// O(triangles) and O(edges²) for the boundary of each patch, which has few.
    ///
    /// # Examples
    /// ```
    /// use pfront_core::{Bvh, Mesh, Node, bvtt::*, one_ring::CertifyOptions, patch::*};
    /// // Two triangles with an edge in common, in one leaf.
    /// let points = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5]];
    /// let mesh = Mesh::new(&points, &[[0, 1, 2], [0, 2, 3]])?;
    /// let root = [Node { min: [0.0; 3], first: 0, max: [1.0, 1.0, 0.5], count: 2 }];
    /// let bvh = Bvh::new(mesh, &root, &[0, 1], &mut [0])?;
    /// let patches = Patches {
    ///     tile_of: &[0],
    ///     tiles: &[[0, 2]],
    ///     pair_starts: &[0, 1],
    ///     pairs: &[[0, 0]],
    ///     patch_starts: &[0, 6],
    ///     members: &[1, 0, 0, 1, 2, 3],
    /// };
    /// let mut state = [0; patch_bound(1, 1)];
    /// let certified = patches.certify(&bvh, &mut state, &CertifyOptions::default())?;
    /// assert!(certified.is_certified(0));
    /// assert_eq!(SelfBvtt::new(bvh).with_patches(certified).count(), 0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn certify<'m>(
        self,
        bvh: &Bvh<'m>,
        state: &'m mut [u32],
        options: &CertifyOptions<'_>,
    ) -> Result<CertifiedPatches<'m>, CapacityError>
    where
        'p: 'm,
    {
        let (tiles, patches) = (self.tiles, self.patch_starts.len().saturating_sub(1));
        CapacityError::check("state", patch_bound(tiles.len(), patches), state.len())?;
        let (signs, rest) = split(state, tiles.len());
        let (certified, _) = split(rest, patches);
        let (mesh, join) = (bvh.mesh(), options.join);
        let vertices = mesh.vertex_count();
        let moved = options.moved.filter(|moved| moved.len() >= moved_bound(vertices));
        parts(join, 0, signs, &|first, signs| {
            for (&[start, count], signs) in part(tiles, first..).iter().zip(signs) {
                let triangles = range(bvh.order(), start, count);
                let holds =
                    |moved, &t: &u32| at(mesh.triangles(), t).iter().any(|&v| holds(moved, v));
                if moved.is_some_and(|moved| !triangles.iter().any(|t| holds(moved, t))) {
                    *signs &= !MOVED;
                    continue;
                }
                let all = triangles.iter().map(|&t| uncertified_signs_of(mesh, t));
                *signs = all.fold(MOVED, |signs, other| signs | other);
            }
        });
        let signs = &*signs;
        parts(join, 0, certified, &|first, certified| {
            widest(Certification { patches: self, mesh, signs, first, certified });
        });
        Ok(CertifiedPatches { mesh, order: bvh.order(), patches: self, certified })
    }
}

/// The certificates of the patches of a mesh, for its positions.
#[derive(Clone, Copy, Debug)]
pub struct CertifiedPatches<'m> {
    mesh: Mesh<'m>,
    order: &'m [u32],
    patches: Patches<'m>,
    certified: &'m [u32],
}

impl<'m> CertifiedPatches<'m> {
    /// Borrows again what [`Patches::certify`] has left in `state`.
    ///
    /// Nothing is checked: with another state, or a mesh in other positions, a query may miss pairs.
    #[must_use]
    pub fn new_unchecked(bvh: &Bvh<'m>, patches: Patches<'m>, state: &'m [u32]) -> Self {
        let certified = state.get(patches.tiles.len()..).unwrap_or_default();
        Self { mesh: bvh.mesh(), order: bvh.order(), patches, certified }
    }

    /// How many patches there are.
    #[must_use]
    pub fn count(&self) -> u32 {
        self.certified.len() as u32
    }

    /// Whether no two triangles in the tiles of a patch intersect in more than what they share by index.
    #[inline]
    #[must_use]
    pub fn is_certified(&self, patch: u32) -> bool {
        self.certified.get(patch as usize) == Some(&1)
    }

    /// Whether these are patches of the very BVH. Both borrow their slices, so slices in the same place hold the same.
    pub(crate) fn are_of<L: Layout>(&self, bvh: &Bvh<'_, L>) -> bool {
        core::ptr::eq(self.mesh.shadow(), bvh.mesh().shadow())
            && core::ptr::eq(self.mesh.triangles(), bvh.mesh().triangles())
            && core::ptr::eq(self.order, bvh.order())
    }

    /// Whether a certified patch holds both nodes, so that no triangle below one is a hit with one below the other.
    #[inline]
    pub(crate) fn hold(&self, n: NodePair) -> bool {
        let Patches { tile_of, pair_starts, pairs, .. } = self.patches;
        let [Some(&a), Some(&b)] = [n.a, n.b].map(|node| tile_of.get(node as usize)) else {
            return false;
        };
        let (first, second) = (a.min(b) as usize, a.max(b));
        if second == NO_TILE {
            return false;
        }
        let [Some(&start), Some(&end)] = [first, first + 1].map(|i| pair_starts.get(i)) else {
            return false;
        };
        let of_first = pairs.get(start as usize..end as usize).unwrap_or_default();
        let patch = of_first.iter().find(|[tile, _]| *tile == second);
        patch.is_some_and(|&[_, patch]| self.is_certified(patch))
    }
}

/// Set beside the signs of a tile if one of its vertices has moved.
const MOVED: u32 = 1 << 31;

/// Certifies the patches from `first` on that have moved.
struct Certification<'c> {
    patches: Patches<'c>,
    mesh: Mesh<'c>,
    /// The [`uncertified_signs_of`] the triangles of each tile together, and [`MOVED`].
    signs: &'c [u32],
    first: usize,
    certified: &'c mut [u32],
}

impl Task for Certification<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { patches, mesh, signs, first, certified } = self;
        let starts = part(patches.patch_starts, first..);
        for (certified, ends) in certified.iter_mut().zip(starts.windows(2)) {
            let members = part(patches.members, ends[0] as usize..ends[1] as usize);
            let tiles = *at(members, 0) as usize;
            let mut uncertified = 0;
            for &tile in part(members, 1..=tiles) {
                uncertified |= *at(signs, tile);
            }
            if uncertified & MOVED == 0 {
                continue;
            }
            // Along which axis, upwards or downwards.
            let direction = (!uncertified & 0x3f).trailing_zeros();
            *certified = 0;
            if direction < 6 {
                let mut line = Line::new();
                let [x, y] = [(direction + 1) % 3, (direction + 2) % 3];
                for &vertex in part(members, tiles + 1..) {
                    let position = at(mesh.shadow(), vertex);
                    line.push([position[x as usize], position[y as usize]]);
                }
                line.close(mesh.is_f64());
                *certified = u32::from(line.is_simple::<S>());
            }
        }
    }
}

/// A closed line in a plane.
struct Line {
    /// The coordinates of its points, then the first again, and room to load lanes.
    points: [[f32; ROOM]; 2],
    len: usize,
    /// How far the difference of two coordinates may be from that of what they stand for.
    error: [f32; 2],
}

const ROOM: usize = MAX_BOUNDARY + 1 + LANES;
const CHUNKS: usize = MAX_BOUNDARY.div_ceil(LANES);

impl Line {
    fn new() -> Self {
        Self { points: [[0.0; ROOM]; 2], len: 0, error: [0.0; 2] }
    }

    /// Appends a point; more than [`MAX_BOUNDARY`] are only counted.
    #[inline(always)]
    fn push(&mut self, point: [f32; 2]) {
        if self.len < MAX_BOUNDARY {
            self.set(self.len, point);
        }
        self.len += 1;
    }

    #[inline(always)]
    fn set(&mut self, index: usize, [x, y]: [f32; 2]) {
        (self.points[0][index % ROOM], self.points[1][index % ROOM]) = (x, y);
    }

    fn point(&self, index: usize) -> [f32; 2] {
        [self.points[0][index % ROOM], self.points[1][index % ROOM]]
    }

    /// The points from `index` on, side by side, in the lanes from `at` on.
    #[inline(always)]
    fn points<S: Simd>(&self, index: usize, at: usize) -> [S; 2] {
        let [x, y] = &self.points;
        match (part(x, index..).first_chunk(), part(y, index..).first_chunk()) {
            (Some(x), Some(y)) => [S::load(x, at), S::load(y, at)],
            _ => out_of_range(),
        }
    }

    /// Has to be called when all points are there, which may be those of a shadow.
    #[inline(always)]
    fn close(&mut self, is_shadow: bool) {
        self.set(self.len, self.point(0));
        if is_shadow {
            // A coordinate of a shadow is off by half a step, and little more: 2^-23 of the largest for a difference. The
            // rest is for what is subnormal, and for rounding here and below.
            self.error = self.points.each_ref().map(|coordinates| {
                let largest = coordinates.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
                2.0 * f32::EPSILON * largest + f32::MIN_POSITIVE
            });
        }
    }

    /// Whether the line certainly does not touch itself: no edge another but the next.
    ///
    /// If an edge turned back along the one before, the end of the shorter would touch the longer, and with it the edge
    /// beyond. Three edges around an area cannot do so.
    #[inline(always)]
    fn is_simple<S: Simd>(&self) -> bool {
        let len = self.len;
        if !(3..=MAX_BOUNDARY).contains(&len) {
            return false;
        }
        // The boxes of all edges, side by side.
        let [mut low, mut high] = [[[0.0; CHUNKS * LANES]; 2]; 2];
        for (chunk, first) in (0..len).step_by(LANES).enumerate() {
            for at in chunk_starts::<S>() {
                let (p, q) = (self.points::<S>(first, at), self.points::<S>(first + 1, at));
                for k in 0..2 {
                    let min = p[k].min(q[k]) - S::splat(self.error[k]);
                    min.store(lanes_mut(&mut low[k], chunk), at);
                    p[k].max(q[k]).store(lanes_mut(&mut high[k], chunk), at);
                }
            }
        }
        for (chunk, first) in (0..len).step_by(LANES).enumerate() {
            let [low_x, low_y] = [lanes(&low[0], chunk), lanes(&low[1], chunk)];
            let [high_x, high_y] = [lanes(&high[0], chunk), lanes(&high[1], chunk)];
            let valid = below(len - first);
            for edge in 0..(first + LANES).min(len) {
                let index = edge % (CHUNKS * LANES);
                let [x, y] = [low[0][index], low[1][index]];
                let [z, w] = [high[0][index], high[1][index]];
                let mut near = 0;
                for at in chunk_starts::<S>() {
                    let along_x =
                        S::splat(x).le(S::load(high_x, at)) & S::load(low_x, at).le(S::splat(z));
                    let along_y =
                        S::splat(y).le(S::load(high_y, at)) & S::load(low_y, at).le(S::splat(w));
                    near |= S::bits(along_x & along_y) << at;
                }
                // The next edge begins where this one ends.
                near &= valid & u32::MAX << (edge + 2).saturating_sub(first);
                while near != 0 {
                    let other = first + near.trailing_zeros() as usize;
                    near &= near - 1;
                    // And the first where the last ends.
                    let are_neighbours = edge == 0 && other + 1 == len;
                    if !are_neighbours && !self.are_apart(edge, other) {
                        return false;
                    }
                }
            }
        }
        true
    }

    /// Whether one edge is certainly on one side of another, strictly.
    #[inline(always)]
    fn are_apart(&self, edge: usize, other: usize) -> bool {
        let (p, q) = (self.point(edge), self.point(edge + 1));
        let (r, s) = (self.point(other), self.point(other + 1));
        let on_one_side = |[left, right]: [bool; 2], [second_left, second_right]: [bool; 2]| {
            left & second_left | right & second_right
        };
        on_one_side(self.turn(p, q, r), self.turn(p, q, s))
            || on_one_side(self.turn(r, s, p), self.turn(r, s, q))
    }

    /// Whether three points certainly make a turn to the left, and to the right, by the bound of one-rings.
    fn turn(&self, p: [f32; 2], q: [f32; 2], r: [f32; 2]) -> [bool; 2] {
        let (u, v) = ([q[0] - p[0], q[1] - p[1]], [r[0] - p[0], r[1] - p[1]]);
        let (x, y) = (u[0].abs().max(v[0].abs()), u[1].abs().max(v[1].abs()));
        let [of_x, of_y] = self.error;
        let bound = x * y * TURN_ERROR + f32::MIN_POSITIVE + 2.0 * (x * of_y + (y + of_y) * of_x);
        let holds = x.max(y) <= MAX_DIFFERENCE;
        let turn = u[0] * v[1] - u[1] * v[0];
        [holds && turn > bound, holds && turn < -bound]
    }
}

/// The lanes of a chunk.
#[inline(always)]
fn lanes(of: &[f32; CHUNKS * LANES], chunk: usize) -> &[f32; LANES] {
    &of.as_chunks().0[chunk % CHUNKS]
}

#[inline(always)]
fn lanes_mut(of: &mut [f32; CHUNKS * LANES], chunk: usize) -> &mut [f32; LANES] {
    &mut of.as_chunks_mut().0[chunk % CHUNKS]
}

/// The lowest bits, as many as there are items, at most [`LANES`].
fn below(items: usize) -> u32 {
    (1 << items.min(LANES)) - 1
}
