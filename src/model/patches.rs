//! The patches of a model, for its self-collision.

use super::moves::Moves;
use super::passes::Parallel;
use super::tree::Tree;
use crate::Error;
use crate::memory::{extend, filled, push, reserve};
use pfront_core::bvh::MAX_LEAF_SIZE;
use pfront_core::one_ring::CertifyOptions;
use pfront_core::patch::{CertifiedPatches, MAX_BOUNDARY, NO_TILE, Patches, patch_bound};
use pfront_core::{Bvh, Mesh};

/// Patches that hold all pairs of neighbouring tiles between them, if their triangles are connected so, and which of them are
/// certified.
///
/// [`Renewed`](super::renewed::Renewed) holds it; they are found anew for a tree that was built anew.
#[derive(Clone, Debug, Default)]
pub(super) struct OwnPatches {
    /// The tree whose patches these are.
    tree: Option<u64>,
    tile_of: Vec<u32>,
    tiles: Vec<[u32; 2]>,
    pair_starts: Vec<u32>,
    pairs: Vec<[u32; 2]>,
    patch_starts: Vec<u32>,
    members: Vec<u32>,
    state: Vec<u32>,
    /// More has moved since the last certification than since the tree fitted.
    behind: bool,
}

/// The most triangles in a tile: two full leaves. Larger tiles make fewer patches, of which fewer can be certified.
const TILE: u32 = 2 * MAX_LEAF_SIZE;

/// The refits of a tree after which its patches are found. To find them takes as long as they save in about as many frames;
/// so whenever the deformation ends, no more than twice the time was spent that would have been best (Karlin, Manasse,
/// Rudolph & Sleator, *Competitive Snoopy Caching*, 1988). Meshes that do not deform are not divided.
const REFITS: u32 = 8;

/// An edge and its direction are packed into 64 bits.
const MOST_VERTICES: usize = 1 << 31;

impl OwnPatches {
    /// Certifies the patches for positions that have changed; finds them first, if it is time.
    pub(super) fn renew(&mut self, tree: &Tree, mesh: Mesh<'_>, moves: &Moves, parallel: Parallel) {
        let mut moved = moves.few().filter(|_| !self.behind);
        let bvh = tree.bvh(mesh);
        if self.tree != Some(tree.id()) {
            if tree.refits() < REFITS || mesh.vertex_count() > MOST_VERTICES {
                return;
            }
            // There are none without memory for them.
            if self.find(&bvh).is_err() {
                *self = Self::default();
                return;
            }
            self.tree = Some(tree.id());
            moved = None;
        }
        self.certify(&bvh, CertifyOptions { join: parallel, moved });
        self.behind = false;
    }

    /// To be called when the tree fits and the patches are not up to date, before anything moves.
    pub(super) fn fall_behind(&mut self) {
        self.behind = true;
    }

    /// The certificates, after [`OwnPatches::renew`] for the positions of `mesh`; none if these are patches of another tree.
    pub(super) fn certified<'a>(&'a self, tree: &'a Tree, mesh: Mesh<'a>) -> CertifiedPatches<'a> {
        let bvh = tree.bvh(mesh);
        let is_own = self.tree == Some(tree.id());
        let patches = if is_own { self.patches() } else { Patches::default() };
        CertifiedPatches::new_unchecked(&bvh, patches, &self.state)
    }

    pub(super) fn bytes(&self) -> usize {
        let Self { tile_of, pair_starts, patch_starts, members, state, tiles, pairs, .. } = self;
        let words = [tile_of, pair_starts, patch_starts, members, state];
        let words: usize = words.iter().map(|words| words.capacity()).sum();
        4 * words + 8 * (tiles.capacity() + pairs.capacity())
    }

    fn patches(&self) -> Patches<'_> {
        Patches {
            tile_of: &self.tile_of,
            tiles: &self.tiles,
            pair_starts: &self.pair_starts,
            pairs: &self.pairs,
            patch_starts: &self.patch_starts,
            members: &self.members,
        }
    }

    fn certify(&mut self, bvh: &Bvh<'_>, options: CertifyOptions<'_>) {
        let mut state = std::mem::take(&mut self.state);
        let certified = self.patches().certify(bvh, &mut state, &options);
        debug_assert!(certified.is_ok(), "the state has its size");
        self.state = state;
    }

    /// Finds tiles of a tree, and patches of them.
    ///
    /// # Errors
    /// [`Error::Memory`].
    fn find(&mut self, bvh: &Bvh<'_>) -> Result<(), Error> {
        // In case this does not come to its end.
        self.tree = None;
        self.divide(bvh)?;
        let near = Neighbours::new(bvh, &self.tiles)?;
        let mut patch_of = filled(NO_PATCH, near.tiles.len())?;
        self.members.clear();
        self.patch_starts.clear();
        push(&mut self.patch_starts, 0)?;
        // The pairs around each tile that no patch holds, or more.
        let mut most = filled(usize::MAX, self.tiles.len())?;
        let (mut free, mut edges) = (Vec::new(), Vec::new());
        // Patches that hold many pairs come first, so that few are needed. Half of them are about as good as the best.
        for least in [16, 8, 4, 2, 1] {
            for (tile, most) in most.iter_mut().enumerate() {
                if *most < least {
                    continue;
                }
                free.clear();
                near.for_each_pair_around(tile, |entry| {
                    if patch_of[entry] == NO_PATCH {
                        free.push(entry);
                    }
                });
                *most = free.len();
                if free.len() < least {
                    continue;
                }
                *most = 0;
                let tiles = near.of(tile);
                let triangles = tiles.iter().map(|&tile| triangles(bvh, self.tiles[tile as usize]));
                if let Some(boundary) = boundary(bvh, triangles.flatten(), &mut edges) {
                    let patch = self.patch_starts.len() as u32 - 1;
                    free.iter().for_each(|&entry| patch_of[entry] = patch);
                    push(&mut self.members, tiles.len() as u32)?;
                    extend(&mut self.members, tiles.iter().copied())?;
                    extend(&mut self.members, boundary.into_iter())?;
                    push(&mut self.patch_starts, self.members.len() as u32)?;
                }
            }
        }
        self.pairs.clear();
        self.pair_starts.clear();
        push(&mut self.pair_starts, 0)?;
        for entries in near.starts.windows(2) {
            for entry in (entries[0]..entries[1]).filter(|&entry| patch_of[entry] != NO_PATCH) {
                push(&mut self.pairs, [near.tiles[entry], patch_of[entry]])?;
            }
            push(&mut self.pair_starts, self.pairs.len() as u32)?;
        }
        self.pairs.shrink_to_fit();
        self.patch_starts.shrink_to_fit();
        self.members.shrink_to_fit();
        self.state = filled(0, patch_bound(self.tiles.len(), self.patch_starts.len() - 1))?;
        Ok(())
    }

    /// Divides a tree into tiles: the largest subtrees of at most [`TILE`] triangles.
    fn divide(&mut self, bvh: &Bvh<'_>) -> Result<(), Error> {
        let nodes = bvh.nodes();
        // The triangles below each node: children come after their parents.
        let mut ranges = filled([0, 0], nodes.len())?;
        for (index, node) in nodes.iter().enumerate().rev().filter(|&(index, _)| index != 1) {
            let first = node.first as usize;
            ranges[index] = if node.is_leaf() {
                [node.first, node.count]
            } else {
                let [[start, count], [_, other]] = [ranges[first], ranges[first + 1]];
                [start, count + other]
            };
        }
        self.tiles.clear();
        self.tile_of.clear();
        reserve(&mut self.tile_of, nodes.len())?;
        self.tile_of.resize(nodes.len(), NO_TILE);
        let mut stack: Vec<usize> = nodes.first().map(|_| 0).into_iter().collect();
        while let Some(index) = stack.pop() {
            let node = &nodes[index];
            if self.tile_of[index] == NO_TILE && (ranges[index][1] <= TILE || node.is_leaf()) {
                self.tile_of[index] = self.tiles.len() as u32;
                push(&mut self.tiles, ranges[index])?;
            }
            if !node.is_leaf() {
                for child in [node.first as usize, node.first as usize + 1] {
                    self.tile_of[child] = self.tile_of[index];
                    stack.push(child);
                }
            }
        }
        Ok(())
    }
}

/// Stands for no patch.
const NO_PATCH: u32 = u32::MAX;

/// For each tile, those that share a vertex with it, itself included, in ascending order.
///
/// Vertices of more than [`MAX_BOUNDARY`] triangles are left out, and tiles with more neighbours than that: such patches
/// would have too long a boundary, and there would be too many pairs.
struct Neighbours {
    starts: Vec<usize>,
    tiles: Vec<u32>,
}

impl Neighbours {
    /// # Errors
    /// [`Error::Memory`].
    fn new(bvh: &Bvh<'_>, tiles: &[[u32; 2]]) -> Result<Self, Error> {
        let mesh = bvh.mesh();
        let corners = mesh.triangles().as_flattened();
        let mut tile_of = filled(0, mesh.triangles().len())?;
        for (tile, &range) in (0..).zip(tiles) {
            triangles(bvh, range).iter().for_each(|&t| tile_of[t as usize] = tile);
        }
        // The tiles around each vertex, by counting.
        let mut ends = filled(0, mesh.vertex_count() + 1)?;
        corners.iter().for_each(|&vertex| ends[vertex as usize + 1] += 1);
        let mut sum = 0;
        for end in &mut ends {
            sum += *end;
            *end = sum;
        }
        let mut around = filled(0, corners.len())?;
        for (corner, &vertex) in corners.iter().enumerate() {
            let end = &mut ends[vertex as usize];
            around[*end] = tile_of[corner / 3];
            *end += 1;
        }
        // Each end has moved to that of its vertex.
        let start_of = |vertex: usize| if vertex == 0 { 0 } else { ends[vertex - 1] };
        let (mut starts, mut near) = (Vec::new(), Vec::new());
        reserve(&mut starts, tiles.len() + 1)?;
        starts.push(0);
        // The last tile that each tile was found to be near to.
        let mut last = filled(NO_TILE, tiles.len())?;
        for (tile, &range) in (0..).zip(tiles) {
            let first = near.len();
            for vertex in triangles(bvh, range).iter().flat_map(|&t| mesh.triangles()[t as usize]) {
                let vertex = vertex as usize;
                let around = &around[start_of(vertex)..ends[vertex]];
                for &other in around.iter().filter(|_| around.len() <= MAX_BOUNDARY) {
                    if std::mem::replace(&mut last[other as usize], tile) != tile {
                        push(&mut near, other)?;
                    }
                }
            }
            if near.len() - first > MAX_BOUNDARY {
                near.truncate(first);
            }
            near[first..].sort_unstable();
            starts.push(near.len());
        }
        Ok(Self { starts, tiles: near })
    }

    fn of(&self, tile: usize) -> &[u32] {
        &self.tiles[self.starts[tile]..self.starts[tile + 1]]
    }

    /// Calls `visit` for each pair of neighbours among the neighbours of a tile: the place in `tiles` of the second among
    /// the neighbours of the first, whose index is not greater.
    fn for_each_pair_around(&self, tile: usize, mut visit: impl FnMut(usize)) {
        let near = self.of(tile);
        for (i, &first) in near.iter().enumerate() {
            let start = self.starts[first as usize];
            let mut seconds = near[i..].iter().peekable();
            for (k, &second) in self.of(first as usize).iter().enumerate() {
                while seconds.next_if(|&&other| other < second).is_some() {}
                if seconds.next_if(|&&other| other == second).is_some() {
                    visit(start + k);
                }
            }
        }
    }
}

fn triangles<'a>(bvh: &Bvh<'a>, [start, count]: [u32; 2]) -> &'a [u32] {
    &bvh.order()[start as usize..(start + count) as usize]
}

/// The vertices of the boundary of some triangles, if it is one line and no edge is twice there. `edges` is scratch.
fn boundary<'t>(
    bvh: &Bvh<'_>,
    triangles: impl Iterator<Item = &'t u32>,
    edges: &mut Vec<u64>,
) -> Option<Vec<u32>> {
    // The lesser vertex, the other, and which of them comes first.
    let packed = |from: u32, to: u32| {
        u64::from(from.min(to)) << 32 | u64::from(from.max(to)) << 1 | u64::from(from > to)
    };
    edges.clear();
    for &t in triangles {
        let [a, b, c] = bvh.mesh().triangles()[t as usize];
        edges.extend([packed(a, b), packed(b, c), packed(c, a)]);
    }
    edges.sort_unstable();
    let mut open = Vec::new();
    for sides in edges.chunk_by(|one, other| one >> 1 == other >> 1) {
        match *sides {
            [edge] => {
                let [less, more] = [(edge >> 32) as u32, edge as u32 >> 1];
                open.push(if edge & 1 == 0 { [less, more] } else { [more, less] });
            }
            [one, other] if one != other => {}
            _ => return None,
        }
    }
    open.sort_unstable();
    let first = open.first()?[0];
    if open.len() > MAX_BOUNDARY || open.windows(2).any(|two| two[0][0] == two[1][0]) {
        return None;
    }
    let (mut line, mut last) = (Vec::with_capacity(open.len()), first);
    loop {
        line.push(last);
        let next = open.binary_search_by_key(&last, |edge| edge[0]).ok()?;
        last = open[next][1];
        if last == first || line.len() == open.len() {
            break;
        }
    }
    (last == first && line.len() == open.len()).then_some(line)
}
