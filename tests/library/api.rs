//! Promises of the types, beside what they answer.

/// `use pfront::*` takes no name from the caller: no crate of the standard library, nothing of its prelude.
mod glob {
    use pfront::*;

    #[test]
    fn a_glob_import_leaves_crates_and_the_prelude_alone() -> Result<(), Error> {
        assert_eq!(core::mem::size_of::<Pose>(), std::mem::size_of::<[f32; 12]>());
        let model = Model::new(Vec::from([[0.0; 3]; 3]), vec![[0, 1, 2]])?;
        let mut query = Some(Box::<PairQuery>::default());
        let Some(query) = query.as_mut() else { unreachable!() };
        assert_eq!(query.all(&model, &model, Pose::IDENTITY)?, [TrianglePair { a: 0, b: 0 }]);
        Ok(())
    }
}

/// Engines share what they own between threads, as bevy's resources are, and hold it in futures.
#[test]
fn everything_owned_is_send_sync_and_unpin() {
    use pfront::{
        Batch, Body, Bvh, Contact, Error, Executor, Mesh, Model, PairLists, PairQuery, SceneHit,
        SceneQuery, SelfQuery, Ticket, TrianglePair,
    };
    use pfront_core::bvtt::{Cursor, PairBvtt, SelfBvtt};
    fn holds<T: Send + Sync + Unpin + 'static>() {}
    holds::<(Model, std::sync::Arc<Model>, Body)>();
    holds::<(PairQuery, SelfQuery, SceneQuery, Executor)>();
    holds::<(Batch, Ticket<PairLists>, Ticket<Vec<u64>>, Ticket<Vec<Option<TrianglePair>>>)>();
    holds::<(Error, SceneHit, Contact)>();
    #[cfg(feature = "threads")]
    holds::<(pfront::threads::Pool, pfront::threads::Traversal, pfront::threads::Report)>();
    #[cfg(feature = "gpu")]
    {
        use pfront::gpu::{Deforming, Gpu, GpuError, GpuModel, GpuQuery, World};
        holds::<(Gpu, GpuModel, Deforming, GpuQuery, World, GpuError)>();
    }
    // Views borrow, and go to threads in a scope.
    fn lends<T: Send + Sync + Unpin>() {}
    lends::<(Mesh<'_>, Bvh<'_>, PairBvtt<'_>, SelfBvtt<'_>, Cursor)>();
}

/// Stored values come back the same, to the bit.
#[cfg(feature = "serde")]
#[test]
fn what_is_stored_comes_back() -> Result<(), Box<dyn std::error::Error>> {
    use pfront::{Adjacency, BuildOptions, Groups, Model, Pose, Pose64, SceneQuery};
    use serde::{Serialize, de::DeserializeOwned};
    use std::fmt::Debug;

    fn again<T: Serialize + DeserializeOwned + PartialEq + Debug>(value: T) {
        let text = serde_json::to_string(&value).unwrap();
        assert_eq!(serde_json::from_str::<T>(&text).unwrap(), value, "{text}");
    }
    let triangle = || Model::new(vec![[0.0; 3], [1.0, 0.0, 0.1], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]);
    let mut scene = SceneQuery::new();
    let pose = Pose::from_rotation_translation([0.6, 0.0, 0.0, 0.8], [0.1, 0.2, -0.01]);
    let body = scene.add(triangle()?, pose)?;
    scene.add(triangle()?, Pose::IDENTITY)?;
    let contacts = scene.contacts()?.to_vec();
    assert_eq!(contacts.len(), 1);
    again(contacts);
    again((pose, body, triangle()?.bvh().aabb(), scene.hits().to_vec()));
    again(Pose64::from_rotation_translation([0.6, 0.0, 0.0, 0.8], [0.1, 0.2, -1e-300]));
    again((Groups::default(), Adjacency::SkipNeighbours));

    // A build runs in parts by whoever builds, not by what was stored.
    let options = BuildOptions { leaf_size: 3, ..BuildOptions::default() };
    let text = serde_json::to_string(&options)?;
    assert_eq!(text, r#"{"leaf_size":3}"#);
    assert_eq!(serde_json::from_str::<BuildOptions>(&text)?.leaf_size, 3);
    assert_eq!(
        serde_json::from_str::<BuildOptions>("{}")?.leaf_size,
        BuildOptions::default().leaf_size
    );
    Ok(())
}
