//! Surfaces beside solids, on every executor; core's tests have the truth about them.

use super::cube;
use crate::each_executor;
use pfront::{Error, Model, NotSolid, PairQuery, Pose, Pose64, Relation, Solid};

#[test]
fn a_surface_is_apart_touching_crossing_or_inside() {
    let corners = vec![[0.25, 0.25, 0.5], [0.75, 0.25, 0.5], [0.25, 0.75, 0.5]];
    let surface = Solid::surface(Model::new(corners, vec![[0, 1, 2]]).unwrap()).unwrap();
    let cube = Solid::new(cube()).unwrap();
    let (s, c) = 0.3_f32.sin_cos();
    for executor in each_executor(&[2]) {
        let mut query = PairQuery::new().within(0.25).unwrap().on(&executor);
        for (z, relation) in [
            (0.0, Relation::AInB),
            (0.5, Relation::Touching),
            (0.75, Relation::Near),
            (1.0, Relation::Apart),
        ] {
            let pose = Pose::from_translation([0.0, 0.0, z]);
            let back = Pose::from_translation([0.0, 0.0, -z]);
            let found = query.relation(&cube, &surface, pose).unwrap();
            assert_eq!(found.relation, Some(relation.swapped()), "{executor:?} {z}");
            let found = query.relation(&surface, &cube, Pose64::from(back)).unwrap();
            assert_eq!(found.relation, Some(relation), "{executor:?} {z}");
        }
        // Turned about the third axis, so that positions are rounded.
        let turned = Pose::new([[c, -s, 0.0, 0.9], [s, c, 0.0, 0.1], [0.0, 0.0, 1.0, 0.0]]);
        let crossing = query.relation(&cube, &surface, turned).unwrap();
        assert_eq!(crossing.relation, Some(Relation::Crossing));
        assert_eq!(query.overlap_volume(&cube, &surface, turned).unwrap()[0], 0.0);
    }
    let flat = Model::new(vec![[0.0; 3]; 3], vec![[0, 1, 2]]).unwrap();
    assert!(matches!(Solid::surface(flat), Err(Error::Solid(NotSolid::NoArea))));
}
