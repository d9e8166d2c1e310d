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
        assert_eq!(query.all(&model, &model, &Pose::IDENTITY)?, [TrianglePair { a: 0, b: 0 }]);
        Ok(())
    }
}
