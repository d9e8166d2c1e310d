//! Everything public of `pfront_core` that works without std, to be linked and searched for panics other than the
//! one of `core/src/index.rs`.
//!
//! Not here are the SAH build, which selects medians as `core` does, and needs 32 bytes a triangle and
//! 64 KiB of stack; and those functions whose purpose it is to panic, `assert_well_formed`.

#![no_std]
#![no_main]

use core::hint::black_box as any;
use core::ops::ControlFlow::Continue;
use core::panic::PanicInfo;
use pfront_core::bvh::*;
use pfront_core::bvtt::*;
use pfront_core::front::*;
use pfront_core::one_ring::OneRings;
use pfront_core::triangle::*;
use pfront_core::*;

/// Anything of a type, or nothing.
fn some<T>() -> Option<T> {
    any(None)
}

/// Slices of any length.
struct Slices<'s> {
    positions: &'s [[f32; 3]],
    triangles: &'s [[u32; 3]],
    nodes: [&'s mut [Node]; 2],
    order: &'s mut [u32],
    keys: &'s mut [u64],
    words: &'s mut [u32],
    table: &'s mut [RefitRow],
    moved: &'s mut [Moved],
    history: &'s mut [u32],
    front: &'s mut [FrontNode],
    last: &'s mut [FrontNode],
    parts: &'s mut [Part],
    page: &'s mut [TrianglePair],
    bytes: &'s mut [u8],
}

fn everything(slices: Slices<'_>) -> Option<()> {
    let Slices { positions, triangles, nodes: [nodes, others], order, keys, words, .. } = slices;
    let mesh = Mesh::new(positions, triangles).ok()?;
    let mesh = mesh.with_positions(some()?).ok()?;
    let join: &Join<'_> = some()?;
    let storage = BvhStorage { nodes, order };
    let options = BuildOptions { leaf_size: some()?, join: Some(join) };
    let bvh = morton(mesh, &options, storage, keys).ok()?;
    any((Bvh::new(mesh, bvh.nodes(), bvh.order(), words).ok()?.depth(), quality(&bvh)));
    any::<Bvh<'_>>(Bvh::new_unchecked(mesh, some()?, some()?));
    baked(&bvh, slices.bytes);
    let moved = slices.moved;
    any(mark_moved(positions, mesh.shadow(), moved).is_ok());
    let options = Refit { join: Some(join), table: slices.table, moved: Some(moved) };
    any(refit(mesh, others, some()?, options).ok()?);
    let mut rings = OneRings::new(some()?, triangles, slices.history, words).ok()?;
    let certified = rings.certify(mesh, Some(join));
    any(certified.is_certified(some()?));
    let within = SelfBvtt::new(bvh).with_certificates(certified).with_adjacency(some()?);
    asked(&within.boxes_only(), slices.page)?;
    let placed: PosedBvh<'_> = PosedBvh::new(bvh, &some()?).ok()?;
    any((placed.aabb(), PairBvtt::new(bvh, bvh, some()?).ok()?));
    let pair: PairBvtt<'_> = PairBvtt::in_world(placed, some()?);
    asked(&pair, slices.page)?;
    let mut front = Front::new(slices.front);
    front.add(some()?, some()?).ok()?;
    front.refine(&some()?, slices.last, |_| &pair);
    any((front.partition(slices.parts).len(), estimate(&pair, some()?)));
    any(intersects(&some()?, &some()?));
    any(intersects_in_mesh(mesh, some()?, some()?, some()?));
    any((contact(&some()?, &some()?), mesh.shadow_triangle(some()?)));
    Some(())
}

fn baked(bvh: &Bvh<'_>, bytes: &mut [u8]) -> Option<()> {
    any(blob::write(bvh, bytes).ok()?.len());
    any(blob::Counts::of(bvh).bytes());
    let blob = Blob::new(bytes).ok()?;
    any((blob.counts(), blob.bvh(some()?).ok()?.is_depth_first()));
    any(blob.read_into(some()?, some()?).ok()?);
    Some(())
}

fn asked(query: &impl Query, page: &mut [TrianglePair]) -> Option<()> {
    let (mut cursor, n) = (Cursor::at(some::<NodePair>()?), some()?);
    let ended = query.step(&mut cursor, some()?, |pair| {
        any(pair);
        Continue(())
    });
    any((
        ended.is_break(),
        query.page(&mut cursor, page),
        query.count(),
        query.any(),
        query.contact(some()?),
    ));
    let push = &mut |n, boxes| _ = any((n, boxes));
    any((query.children(n, push), query.boxes(n)));
    any((query.triangles_below(n), query.leaf_edge()));
    Some(())
}

/// Keeps it all.
#[unsafe(no_mangle)]
#[expect(unsafe_code, reason = "the linker knows where to begin by this name")]
extern "C" fn _start() {
    any(some().and_then(everything));
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    loop {}
}
