//! Embree 3: `rtcCollide` on BVHs of the triangles' boxes, refitted to posed positions.
//!
//! Embree collides user geometries only, so it gets triangles as boxes, by a callback, and a second
//! callback tests the candidates. The declarations here are the little that is called of Embree's C
//! header; the library is Debian's libembree-dev. Embree cannot stop at the first hit.

#![expect(unsafe_code, reason = "Embree is a C library")]

use super::work::{Finder, Hit, Work};
use pfront::{Aabb, TrianglePair};
use pfront_core::Triangle;
use pfront_testkit::inexact;
use std::cell::Cell;
use std::ffi::{c_char, c_int, c_uint, c_void};
use std::sync::Mutex;

/// All hits by a plain test in f32. Triangles that share a vertex of one mesh are left out.
pub(crate) fn all(work: &Work) -> Box<dyn Finder + '_> {
    Box::new(Embree::new(work))
}

/// A scene for each body, and its box.
struct Embree<'w> {
    work: &'w Work,
    boxes: Vec<Aabb>,
    scenes: Vec<Scene>,
    device: Handle,
    bodies: Vec<Body>,
}

struct Scene {
    scene: Handle,
    geometry: Handle,
}

struct Body {
    positions: Vec<Cell<[f32; 3]>>,
    triangles: Vec<[u32; 3]>,
}

/// The meshes whose candidates are tested, and the list of hits.
struct Narrow<'e> {
    numbers: [u32; 2],
    bodies: [&'e Body; 2],
    /// Locked, for Embree does not promise to call from one thread.
    found: Mutex<&'e mut Vec<Hit>>,
}

impl Finder for Embree<'_> {
    fn place(&mut self, frame: usize) {
        for i in (0..self.bodies.len()).filter(|&i| !self.work.rests(i)) {
            self.bodies[i].place(self.work.positions(frame, i));
            self.boxes[i] = self.refit(i);
        }
    }

    fn find(&mut self, _: usize, found: &mut Vec<Hit>) {
        if self.boxes.len() == 1 {
            return self.collide([0; 2], found);
        }
        for (j, b) in self.boxes.iter().enumerate() {
            for i in (0..j).filter(|&i| self.boxes[i].overlaps(b)) {
                self.collide([i, j], found);
            }
        }
    }
}

impl<'w> Embree<'w> {
    fn new(work: &'w Work) -> Self {
        let bodies = work.meshes.iter().map(|mesh| Body {
            positions: mesh.positions.iter().copied().map(Cell::new).collect(),
            triangles: mesh.triangles.clone(),
        });
        let bodies: Vec<_> = bodies.collect();
        // SAFETY: the configuration is a C string.
        let device = unsafe { rtcNewDevice(c"threads=1".as_ptr()) };
        assert!(!device.is_null(), "no Embree device");
        let scenes = bodies.iter().map(|body| Scene::new(device, body)).collect();
        let mut embree = Self { work, boxes: Vec::new(), scenes, device, bodies };
        embree.boxes = (0..embree.bodies.len()).map(|body| embree.refit(body)).collect();
        embree
    }

    /// To be called first and when a body has moved; returns its box.
    fn refit(&self, body: usize) -> Aabb {
        let Scene { scene, geometry } = self.scenes[body];
        let mut bounds = Bounds::default();
        // SAFETY: all are alive, and so is the body whose positions the bounds callback reads.
        let error = unsafe {
            rtcCommitGeometry(geometry);
            rtcCommitScene(scene);
            rtcGetSceneBounds(scene, &mut bounds);
            rtcGetDeviceError(self.device)
        };
        assert_eq!(error, 0, "Embree's RTCError");
        let [min, max] = [bounds.lower, bounds.upper].map(|[x, y, z, _]| [x, y, z]);
        Aabb { min, max }
    }

    fn collide(&self, pair: [usize; 2], found: &mut Vec<Hit>) {
        let [a, b] = pair.map(|i| self.scenes[i].scene);
        let narrow = Narrow {
            numbers: pair.map(|i| i as u32),
            bodies: pair.map(|i| &self.bodies[i]),
            found: Mutex::new(found),
        };
        // SAFETY: the scenes are alive and committed, and `narrow` is what the callback takes it for
        // and outlives the call.
        unsafe { rtcCollide(a, b, test, (&raw const narrow).cast()) };
    }
}

impl Scene {
    fn new(device: Handle, body: &Body) -> Self {
        // SAFETY: the device is alive; the body outlives the scene and does not move, being in a
        // `Vec` that stays as it is; `bounds` is a callback of the type declared.
        unsafe {
            let geometry = rtcNewGeometry(device, USER_GEOMETRY);
            rtcSetGeometryUserPrimitiveCount(geometry, body.triangles.len() as c_uint);
            rtcSetGeometryUserData(geometry, (&raw const *body).cast());
            rtcSetGeometryBoundsFunction(geometry, bounds, std::ptr::null());
            rtcSetGeometryBuildQuality(geometry, REFIT);
            let scene = rtcNewScene(device);
            // Only both together make Embree refit; otherwise it builds anew.
            rtcSetSceneFlags(scene, DYNAMIC);
            rtcSetSceneBuildQuality(scene, LOW);
            rtcAttachGeometry(scene, geometry);
            Self { scene, geometry }
        }
    }
}

impl Drop for Scene {
    fn drop(&mut self) {
        // SAFETY: each was made once and is released once.
        unsafe {
            rtcReleaseGeometry(self.geometry);
            rtcReleaseScene(self.scene);
        }
    }
}

impl Drop for Embree<'_> {
    fn drop(&mut self) {
        // They point to the bodies, which are about to go.
        self.scenes.clear();
        // SAFETY: made once and released once.
        unsafe { rtcReleaseDevice(self.device) };
    }
}

impl Body {
    fn place(&self, positions: impl Iterator<Item = [f32; 3]>) {
        self.positions.iter().zip(positions).for_each(|(own, p)| own.set(p));
    }

    fn triangle(&self, i: u32) -> Triangle {
        self.triangles[i as usize].map(|vertex| self.positions[vertex as usize].get())
    }
}

impl Narrow<'_> {
    fn meet(&self, a: u32, b: u32) -> bool {
        let [of_a, of_b] = self.bodies;
        if self.numbers[0] == self.numbers[1] {
            // Embree names each pair both ways.
            let [own, other] = [a, b].map(|i| of_a.triangles[i as usize]);
            if a >= b || own.iter().any(|vertex| other.contains(vertex)) {
                return false;
            }
        }
        let [a, b] = [of_a.triangle(a), of_b.triangle(b)];
        // Embree tests boxes of leaves only, and these hold several triangles.
        Aabb::of(&a).overlaps(&Aabb::of(&b)) && inexact::fast(&a, &b)
    }
}

/// The box of a triangle.
extern "C" fn bounds(arguments: *const BoundsArguments) {
    // SAFETY: Embree passes valid arguments, and the user data is that of `Scene::new`.
    let (arguments, body) = unsafe { (&*arguments, &*(*arguments).user.cast::<Body>()) };
    let Aabb { min, max } = Aabb::of(&body.triangle(arguments.primitive));
    let pad = |[x, y, z]: [f32; 3]| [x, y, z, 0.0];
    // SAFETY: it points to where Embree wants the box.
    unsafe { *arguments.out = Bounds { lower: pad(min), upper: pad(max) } };
}

/// Tests some candidates.
extern "C" fn test(narrow: *const c_void, candidates: *const Collision, count: c_uint) {
    // SAFETY: the pointer is that of `Embree::collide`, and Embree passes so many candidates. Nobody
    // writes to positions meanwhile, whatever thread this is.
    let (narrow, candidates) = unsafe {
        (&*narrow.cast::<Narrow<'_>>(), std::slice::from_raw_parts(candidates, count as usize))
    };
    let mut found = narrow.found.lock().unwrap();
    for [a, b] in candidates.iter().map(|c| c.primitives.map(|p| p.number)) {
        if narrow.meet(a, b) {
            found.push((narrow.numbers, TrianglePair { a, b }));
        }
    }
}

type Handle = *mut c_void;
const USER_GEOMETRY: c_int = 120;
const REFIT: c_int = 3;
const LOW: c_int = 0;
const DYNAMIC: c_int = 1;

#[derive(Default)]
#[repr(C, align(16))]
struct Bounds {
    lower: [f32; 4],
    upper: [f32; 4],
}

#[repr(C)]
struct BoundsArguments {
    user: *const c_void,
    primitive: c_uint,
    time_step: c_uint,
    out: *mut Bounds,
}

/// Geometry and primitive of each.
#[repr(C)]
struct Collision {
    primitives: [Primitive; 2],
}

#[derive(Clone, Copy)]
#[repr(C)]
struct Primitive {
    geometry: c_uint,
    number: c_uint,
}

type BoundsCallback = extern "C" fn(*const BoundsArguments);
type CollideCallback = extern "C" fn(*const c_void, *const Collision, c_uint);

#[link(name = "embree3")]
unsafe extern "C" {
    fn rtcNewDevice(config: *const c_char) -> Handle;
    fn rtcGetDeviceError(device: Handle) -> c_int;
    fn rtcReleaseDevice(device: Handle);
    fn rtcNewGeometry(device: Handle, kind: c_int) -> Handle;
    fn rtcSetGeometryUserPrimitiveCount(geometry: Handle, count: c_uint);
    fn rtcSetGeometryUserData(geometry: Handle, data: *const c_void);
    fn rtcSetGeometryBoundsFunction(geometry: Handle, f: BoundsCallback, data: *const c_void);
    fn rtcSetGeometryBuildQuality(geometry: Handle, quality: c_int);
    fn rtcCommitGeometry(geometry: Handle);
    fn rtcReleaseGeometry(geometry: Handle);
    fn rtcNewScene(device: Handle) -> Handle;
    fn rtcSetSceneFlags(scene: Handle, flags: c_int);
    fn rtcSetSceneBuildQuality(scene: Handle, quality: c_int);
    fn rtcAttachGeometry(scene: Handle, geometry: Handle) -> c_uint;
    fn rtcCommitScene(scene: Handle);
    fn rtcGetSceneBounds(scene: Handle, out: *mut Bounds);
    fn rtcCollide(a: Handle, b: Handle, f: CollideCallback, data: *const c_void);
    fn rtcReleaseScene(scene: Handle);
}
