//! No public method is forgotten: each is asked in every environment by these tests, or computes nothing in floats.

/// The sources of what computes, the methods that these tests ask, and those that compute nothing.
const SURFACE: [(&str, &str, &str, &str); 17] = [
    (
        "PairQuery",
        include_str!("../../../src/pair.rs"),
        "all any count visit contacts contacts_f64 patches distance distance_below",
        "new on within report forget plan",
    ),
    (
        "SelfQuery",
        include_str!("../../../src/itself.rs"),
        "all any count visit contacts contacts_f64 set_positions",
        "new with_adjacency on within report forget plan",
    ),
    ("Motion", include_str!("../../../src/motion.rs"), "new between", "at_rest"),
    (
        "impacts of PairQuery and SelfQuery",
        include_str!("../../../src/impacts.rs"),
        "impacts first_impact any_impact count_impacts impacts first_impact any_impact count_impacts",
        "",
    ),
    (
        "SceneQuery",
        include_str!("../../../src/scene/mod.rs"),
        "all update any count intersecting_bodies bodies_in visit contacts contacts_f64",
        "new on within report plan hits last_contacts",
    ),
    (
        "SceneQuery's distances",
        include_str!("../../../src/scene/nearest.rs"),
        "distance distance_below",
        "",
    ),
    (
        "PairQuery's relations",
        include_str!("../../../src/relation.rs"),
        "relation overlap_volume",
        "",
    ),
    ("SceneQuery's check", include_str!("../../../src/scene/check.rs"), "check", ""),
    (
        "SceneQuery's impacts",
        include_str!("../../../src/scene/impacts.rs"),
        "impacts first_impact any_impact count_impacts",
        "",
    ),
    (
        "SceneQuery's segments",
        include_str!("../../../src/scene/segment.rs"),
        "segment segment_first inside",
        "",
    ),
    (
        "Solid",
        include_str!("../../../src/solid.rs"),
        "new surface inside",
        "model rule marked_pair",
    ),
    (
        "SceneQuery's bodies",
        include_str!("../../../src/scene/edit.rs"),
        "add add_with remove set_pose set_model set_positions split",
        "set_options ignore ignored body bodies len is_empty",
    ),
    (
        "Batch",
        include_str!("../../../src/batch/mod.rs"),
        "pair itself any count all distance distance_below",
        "new len is_empty clear within",
    ),
    (
        "Ticket",
        include_str!("../../../src/ticket/mod.rs"),
        "is_ready try_read wait read",
        "cancel plan hits_buffer count_buffer",
    ),
    (
        "Model",
        concat!(
            include_str!("../../../src/model/mod.rs"),
            include_str!("../../../src/model/deform.rs"),
            include_str!("../../../src/model/in_f64.rs"),
            include_str!("../../../src/model/blob.rs"),
            include_str!("../../../src/model/segment.rs")
        ),
        "new from_f64 from_blob to_blob set_positions set_positions_unfitted fit bvh certificates sphere bytes \
         try_clone segment segment_first",
        "mesh stamp options is_f64",
    ),
    ("ContactSize", include_str!("../../../src/patches/mod.rs"), "of", ""),
    ("AnyPose", include_str!("../../../src/pose.rs"), "pair to_f64", "is_f64"),
];

#[test]
fn every_public_method_is_asked_in_every_environment_or_computes_nothing() {
    for (kind, source, asked, plain) in SURFACE {
        let mut declared: Vec<&str> = source
            .lines()
            .filter_map(|line| {
                line.strip_prefix("    pub fn ").or(line.strip_prefix("    pub const fn "))
            })
            .filter_map(|rest| rest.split(['(', '<']).next())
            .collect();
        let mut known: Vec<&str> =
            asked.split_whitespace().chain(plain.split_whitespace()).collect();
        declared.sort_unstable();
        known.sort_unstable();
        assert_eq!(declared, known, "{kind}: name new methods here, and ask those that compute");
    }
}
