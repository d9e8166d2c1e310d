//! Triangle pairs from the contacts of generated scenes: two posed meshes, or one deforming mesh and itself.
//!
//! A site is a place of contact. Block 0 of a set visits the sites as they are, a later one any of them,
//! moved by up to a thousandth of its size: coordinates are other ones each time, and faces that lie
//! flush along an axis often stay so, since a move may leave out axes.

use anyhow::{Result, ensure};
use glam::{DAffine3, DMat3, DVec3};
use pfront::pfront_core::bvtt::{self, Query};
use pfront::pfront_core::{Aabb, Bvh, Triangle};
use pfront::{Model, Pose};
use pfront_testkit::Rows;
use pfront_testkit::oracle::share_a_vertex;
use pfront_testkit::rng::{Rng, RngExt};
use pfront_testkit::scenes::{Kind, Scene, round};
use rayon::prelude::*;
use std::sync::Arc;

/// A body of a site.
type Body = Arc<Model>;

/// A place of contact.
#[derive(Clone, Debug)]
enum Site {
    /// Two bodies, the second in a pose.
    Pair {
        /// The first, which stays where it is.
        a: Body,
        /// The second.
        b: Body,
        /// Its pose.
        a_from_b: Pose,
    },
    /// A body and itself.
    Within(Body),
}

/// Two triangles whose boxes overlap: their indices, for one mesh in ascending order, and their corners, posed.
type Candidate = ([u32; 2], [Triangle; 2]);

/// A set of sites, of which each has candidates.
#[derive(Clone, Debug)]
pub struct Contacts {
    pub(super) name: &'static str,
    sites: Vec<Site>,
}

impl Contacts {
    /// A set called `name`. Sites without candidates are left out.
    ///
    /// # Errors
    /// If no site is left.
    fn new(name: &'static str, sites: Vec<Site>) -> Result<Self> {
        let sites: Vec<_> =
            sites.into_par_iter().filter(|site| !site.strangers().is_empty()).collect();
        ensure!(
            !sites.is_empty(),
            "'{name}' has no two triangles whose boxes overlap: leave it out"
        );
        Ok(Self { name, sites })
    }

    /// So many pairs for a block. Triangles that share a vertex of their mesh are left out: as closed
    /// triangles they always meet.
    pub(super) fn harvest(
        &self,
        block: u64,
        length: usize,
        rng: &mut impl Rng,
    ) -> Vec<(Triangle, Triangle)> {
        let mut found = Vec::with_capacity(length);
        for visit in 0.. {
            if found.len() >= length {
                break;
            }
            let as_it_is = block == 0 && visit < self.sites.len();
            let which = if as_it_is { visit } else { rng.random_range(0..self.sites.len()) };
            let site = &self.sites[which];
            let mut candidates = if as_it_is { Vec::new() } else { site.moved(rng).strangers() };
            if candidates.is_empty() {
                candidates = site.strangers();
            }
            // Several sites share the first block, and where there are more pairs than asked for, all
            // parts of the contact.
            let room = if as_it_is { length.div_ceil(self.sites.len()) } else { length };
            let room = room.min(length - found.len());
            let step = candidates.len().div_ceil(room).max(1);
            let picked = candidates.iter().skip(rng.random_range(0..step)).step_by(step);
            found.extend(picked.map(|(_, [a, b])| (*a, *b)));
        }
        found
    }
}

impl Site {
    /// All triangle pairs whose boxes overlap and that share no vertex of one mesh, ordered by their indices.
    fn strangers(&self) -> Vec<Candidate> {
        let is_meant = |i: u32, j: u32| match self {
            Self::Pair { .. } => true,
            Self::Within(body) => {
                let [s, t] = [i, j].map(|t| body.mesh().triangles()[t as usize]);
                i < j && !share_a_vertex(s, t)
            }
        };
        let (a, b, pose) = match self {
            Self::Pair { a, b, a_from_b } => (a.bvh(), b.bvh(), *a_from_b),
            Self::Within(body) => (body.bvh(), body.bvh(), Pose::IDENTITY),
        };
        let Ok(query) = bvtt::PairBvtt::new(a, b, pose) else { return Vec::new() };
        let placed = |bvh: &Bvh<'_>, node: u32, pose: &Pose| -> Vec<(u32, Triangle, Aabb)> {
            let leaf = bvh.nodes()[node as usize];
            let run = &bvh.order()[leaf.first as usize..][..leaf.count as usize];
            let triangle = |t: u32| bvh.mesh().shadow_triangle(t).map(|p| pose.apply(p));
            run.iter().map(|&t| (t, triangle(t))).map(|(t, at)| (t, at, Aabb::of(&at))).collect()
        };
        let mut found = Vec::new();
        let mut pending: Vec<_> = query.root().into_iter().collect();
        while let Some(pair) = pending.pop() {
            if query.children(pair, &mut |child, _| pending.push(child)) > 0 {
                continue;
            }
            let others = placed(&b, pair.b, &pose);
            for (i, ta, box_a) in placed(&a, pair.a, &Pose::IDENTITY) {
                for &(j, tb, box_b) in &others {
                    if box_a.overlaps(&box_b) && is_meant(i, j) {
                        found.push(([i, j], [ta, tb]));
                    }
                }
            }
        }
        found.sort_unstable_by_key(|candidate| candidate.0);
        found
    }

    /// The site moved a little, along some of the axes at least; as it is if that takes it out of range.
    fn moved(&self, rng: &mut impl Rng) -> Self {
        let aabb = |body: &Body| body.bvh().aabb().unwrap_or(Aabb::EMPTY);
        let mut along = |bounds: &Aabb| {
            let size = [0, 1, 2].map(|k| bounds.max[k] - bounds.min[k]);
            let most = 1e-3 * size.into_iter().fold(0.0, f32::max);
            let axes = rng.random_range(1..8u32);
            [0, 1, 2].map(|k| {
                let by = rng.random_range(-1.0..=1.0f32) * most;
                if axes >> k & 1 == 1 { by } else { 0.0 }
            })
        };
        match self {
            Self::Pair { a, b, a_from_b } => {
                let by = along(&aabb(a));
                let mut rows = a_from_b.rows;
                rows.iter_mut().zip(by).for_each(|(row, by)| row[3] += by);
                Self::Pair { a: a.clone(), b: b.clone(), a_from_b: Pose::new(rows) }
            }
            // A mesh that moves as a whole is rounded anew.
            Self::Within(body) => {
                let by = Pose::from_translation(along(&aabb(body)));
                let positions: Vec<_> = body.mesh().shadow().iter().map(|&p| by.apply(p)).collect();
                let mut moved = Model::clone(body);
                let done = moved.set_positions(&positions);
                if done.is_ok() { Self::Within(Arc::new(moved)) } else { self.clone() }
            }
        }
    }
}

/// The scenes, and the frames of each that are harvested: some in which its bodies touch.
const SCENES: [(&str, &[usize]); 4] = [
    ("worm-gear", &[0, 17, 34, 51, 68, 85, 102]),
    ("swarm", &[0, 31, 62]),
    ("torus-knots", &[35, 45, 55, 65, 75, 85]),
    ("sheet", &[60, 80, 100]),
];

/// All sets, each in about `size` triangles.
pub(super) fn all(size: Option<usize>) -> Result<Vec<Contacts>> {
    SCENES.map(|(name, frames)| contacts(name, frames, size)).into_iter().collect()
}

fn contacts(name: &'static str, frames: &[usize], size: Option<usize>) -> Result<Contacts> {
    let scene = Scene::by_name(name, size)?;
    let model = |positions: &[[f32; 3]], triangles: &[[u32; 3]]| {
        Model::new(positions.to_vec(), triangles.to_vec()).map(Arc::new)
    };
    let bodies = scene.meshes.iter().map(|mesh| model(&mesh.positions, &mesh.triangles));
    let bodies = bodies.collect::<Result<Vec<Body>, _>>()?;
    let (mut sites, mut poses, mut positions) = (Vec::new(), Vec::new(), Vec::new());
    for &frame in frames {
        if scene.kind() == Kind::SelfMesh {
            scene.positions(frame, &mut positions);
            sites.push(Site::Within(model(&positions, &scene.meshes[0].triangles)?));
            continue;
        }
        scene.poses(frame, &mut poses);
        for (i, pose_a) in poses.iter().enumerate() {
            for (j, pose_b) in poses.iter().enumerate().skip(i + 1) {
                let [a, b] = [i, j].map(|object| bodies[scene.objects[object]].clone());
                let a_from_b = Pose::new(round(affine(pose_a).inverse() * affine(pose_b)));
                sites.push(Site::Pair { a, b, a_from_b });
            }
        }
    }
    Contacts::new(name, sites)
}

fn affine(rows: &Rows) -> DAffine3 {
    let [x, y, z] = rows.map(|row| row.map(f64::from));
    let linear = [x, y, z].map(|[u, v, w, _]| DVec3::new(u, v, w));
    let linear = DMat3::from_cols(linear[0], linear[1], linear[2]).transpose();
    DAffine3::from_mat3_translation(linear, DVec3::new(x[3], y[3], z[3]))
}
