//! Many bodies, on the device and as the core has them.

use crate::common::{Both, sorted};
use pfront_core::Pose;
use pfront_core::bvtt::{PairBvtt, PosedBvh, TrianglePair};
use pfront_gpu::{BodyPair, GpuError, World};
use pfront_testkit::MeshData;

/// Bodies on the device, and what they are made of beside it. Each is paired with each.
pub(crate) struct Scene<'m> {
    pub(crate) world: World,
    pub(crate) bodies: Vec<(&'m Both, Pose)>,
}

pub(crate) fn part(soup: &MeshData) -> Both {
    Both::new(&soup.positions, &soup.triangles, 4)
}

impl<'m> Scene<'m> {
    pub(crate) fn new(world: World, bodies: Vec<(&'m Both, Pose)>) -> Self {
        let mut scene = Self { world, bodies };
        scene.gather();
        scene
    }

    /// Brings all bodies there anew, each mesh once.
    pub(crate) fn gather(&mut self) {
        self.world.clear();
        let mut meshes: Vec<&Both> = Vec::new();
        for &(part, _) in &self.bodies {
            if !meshes.iter().any(|own| std::ptr::eq(*own, part)) {
                assert_eq!(self.world.add_mesh(part.bvh()).unwrap(), meshes.len() as u32);
                meshes.push(part);
            }
        }
        let mesh = |part| meshes.iter().position(|own| std::ptr::eq(*own, part)).unwrap() as u32;
        let bodies: Vec<_> = self.bodies.iter().map(|&(part, pose)| (mesh(part), pose)).collect();
        self.world.set_bodies(&bodies).unwrap();
    }

    /// Moves a body, unless the pose takes it out of range.
    pub(crate) fn set_pose(&mut self, number: usize, pose: Pose) -> Result<(), GpuError> {
        self.world.set_pose(number as u32, pose)?;
        self.bodies[number].1 = pose;
        Ok(())
    }

    pub(crate) fn pairs(&self) -> Vec<BodyPair> {
        let count = self.bodies.len() as u32;
        (0..count).flat_map(|a| (a + 1..count).map(move |b| [a, b])).collect()
    }

    fn truth(&self) -> Vec<(BodyPair, TrianglePair)> {
        let placed = |i: u32| {
            let (part, pose) = &self.bodies[i as usize];
            PosedBvh::new(part.bvh(), pose).unwrap()
        };
        let mut hits = Vec::new();
        for two in self.pairs() {
            let [a, b] = two.map(placed);
            hits.extend(sorted(&PairBvtt::in_world(a, b)).iter().map(|&pair| (two, pair)));
        }
        hits
    }

    /// Checks every verb and returns how many pairs meet.
    pub(crate) fn check(&mut self) -> usize {
        let (truth, pairs) = (self.truth(), self.pairs());
        assert!(self.world.all(&pairs).unwrap() == truth, "{} pairs", truth.len());
        let mut visited = Vec::new();
        let visit = |two, hits: &[TrianglePair]| visited.extend(hits.iter().map(|&hit| (two, hit)));
        self.world.all_each(&pairs, visit).unwrap();
        assert!(visited == truth);
        let any = self.world.any(&pairs).unwrap();
        assert!(any.map_or(truth.is_empty(), |hit| truth.binary_search(&hit).is_ok()));
        let of = |two: &BodyPair| truth.iter().filter(|(bodies, _)| bodies == two).count() as u64;
        let counts: Vec<_> = pairs.iter().map(of).collect();
        assert_eq!(self.world.count_each(&pairs).unwrap(), counts);
        let each = self.world.any_each(&pairs).unwrap().to_vec();
        for ((two, hit), count) in pairs.iter().zip(each).zip(counts) {
            let is_right = |hit| truth.binary_search(&(*two, hit)).is_ok();
            assert!(hit.map_or(count == 0, is_right), "{two:?}: {hit:?} of {count}");
        }
        truth.len()
    }
}
