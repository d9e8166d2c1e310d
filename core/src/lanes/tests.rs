//! What is done side by side against the same done one by one, at the widest and in halves.

use super::simd::Halves;
use super::{Block, Blocks, LANES, Simd, Task, widest};
use crate::fans::{self, Fan, link_scratch_bound};
use crate::place::InPlace;
use crate::triangle::{Accuracy, Adjacency, intersects, intersects_in_mesh};
use crate::{Aabb, Mesh};

const VERTICES: usize = 9;

/// Two leaves of a mesh against each other.
struct Two<'m> {
    mesh: Mesh<'m>,
    leaves: [&'m [u32]; 2],
    fans: &'m [Fan],
}

/// A bit for each pair: boxes overlap, no certified vertex in common, may have one in common, undecided
/// with and without regard to that; and what f32 says of each.
#[derive(Debug, PartialEq)]
struct Found {
    overlapping: u64,
    strangers: u64,
    doubtful: u64,
    undecided: [u64; 2],
    meet: [Option<bool>; LANES * LANES],
}

impl Task for Two<'_> {
    type Output = Found;

    #[inline(always)]
    fn run<S: Simd>(self) -> Found {
        let Self { mesh, leaves: [own, others], fans } = self;
        let mut kept = [Blocks::EMPTY; 2];
        let [first, second] = &mut kept;
        let a: &Block = first.get::<S>(1, mesh, own, &InPlace, fans);
        let b: &Block = second.get::<S>(2, mesh, others, &InPlace, fans);
        let bounds = own.iter().map(|t| Aabb::of(&mesh.triangle(*t)));
        let bounds = bounds.fold(Aabb::EMPTY, |x, y| x.union(&y));
        let overlapping = a.overlapping::<S>(b, &crate::aabb::Bounds::new(&bounds));
        let strangers = a.strangers::<S>(b, overlapping);
        let mut meet = [None; LANES * LANES];
        for (bit, meet) in meet.iter_mut().enumerate() {
            if overlapping >> bit & 1 != 0 {
                *meet = a.meets(bit % LANES, b, bit / LANES);
            }
        }
        Found {
            overlapping,
            strangers,
            doubtful: a.doubtful(b, strangers),
            undecided: [
                a.undecided::<S, false>(b, overlapping),
                a.undecided::<S, true>(b, overlapping),
            ],
            meet,
        }
    }
}

/// Small whole coordinates, mostly, on which planes and corners coincide.
fn mesh(next: &mut impl FnMut(u32) -> u32) -> ([[f32; 3]; VERTICES], [[u32; 3]; 2 * LANES]) {
    let scale = [1.0, 1.0, 0.1, 1e-12, 1e-36, 1e11, 1e13, 1e37][next(8) as usize];
    let offset = [0.0, 0.0, 1e3, 3e7][next(4) as usize] * f32::min(scale, 1e20);
    let mut positions = [[0.0; 3]; VERTICES];
    for x in positions.as_flattened_mut() {
        let nudge = [0.0, 0.0, 1e-7, 1e-3][next(4) as usize] * next(3) as f32;
        *x = (next(4) as f32 + nudge) * scale + offset;
    }
    let mut triangles = [[0; 3]; 2 * LANES];
    for t in &mut triangles {
        // Neighbours of a ring, mostly.
        let i = next(VERTICES as u32 - 1);
        *t = [0, i + 1, (i + 1) % (VERTICES as u32 - 1) + 1];
        if next(4) == 0 {
            *t = [next(VERTICES as u32), next(VERTICES as u32), next(VERTICES as u32)];
        }
    }
    (positions, triangles)
}

#[test]
fn side_by_side_as_one_by_one() {
    let mut state = 11_u64;
    let mut next = move |below: u32| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) as u32) % below
    };
    let (mut rejected, mut known, mut certified) = (0, 0, 0);
    for round in 0..if cfg!(miri) { 4 } else { 20_000 } {
        let (positions, triangles) = mesh(&mut next);
        let mesh = Mesh::new(&positions, &triangles).unwrap();
        let mut known_fans = [Fan::default(); VERTICES];
        let mut scratch = [0; link_scratch_bound(VERTICES, 2 * LANES)];
        // As many triangles as make a fan.
        let few = Mesh::new(&positions, &triangles[..next(2 * LANES as u32) as usize + 1]).unwrap();
        fans::link(few, &mut scratch, &mut known_fans).unwrap();
        fans::certify(few, &mut known_fans).unwrap();
        let n = few.triangles().len() as u32;
        let ids: [u32; 2 * LANES] = core::array::from_fn(|i| i as u32 % n);
        let leaves = [&ids[..next(8) as usize + 1], &ids[8..][..next(8) as usize + 1]];
        let fans: &[Fan] = if round % 3 == 0 { &[] } else { &known_fans };
        let two = || Two { mesh: few, leaves, fans };
        let found = widest(two());
        assert_eq!(found, two().run::<Halves>());
        for (j, &tb) in leaves[1].iter().enumerate() {
            for (i, &ta) in leaves[0].iter().enumerate() {
                let is = |pairs: u64| pairs >> (LANES * j + i) & 1 != 0;
                let [a, b] = [ta, tb].map(|t| few.triangle(t));
                assert_eq!(is(found.overlapping), Aabb::of(&a).overlaps(&Aabb::of(&b)));
                if !is(found.overlapping) {
                    continue;
                }
                let in_mesh = ta == tb
                    || intersects_in_mesh(
                        mesh,
                        ta,
                        tb,
                        Adjacency::SharedIndexRule,
                        Accuracy::Exact,
                    );
                let shares = few.triangles()[ta as usize]
                    .iter()
                    .any(|v| few.triangles()[tb as usize].contains(v));
                let meet = intersects(&a, &b, Accuracy::Exact);
                if ta != tb {
                    assert!(is(found.strangers) || !in_mesh, "certified, but {ta} meets {tb}");
                    assert!(!is(found.strangers) || !shares || is(found.doubtful));
                }
                assert!(is(found.undecided[0]) || !meet);
                assert!(is(found.undecided[1]) || !in_mesh);
                let said = found.meet[LANES * j + i];
                assert!(said.is_none_or(|said| said == meet), "{a:?} {b:?}");
                rejected += u32::from(!is(found.undecided[1]));
                certified += u32::from(!is(found.strangers));
                known += u32::from(said == Some(true));
            }
        }
    }
    let least = if cfg!(miri) { 0 } else { 1_000 };
    assert!(
        rejected > least && known > least && certified > least,
        "{rejected} {known} {certified}"
    );
}
