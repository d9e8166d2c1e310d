//! The report about the bodies of a scene, and the relations that are allowed in it.

use super::id::BodyId;
use crate::{ContactSize, NotSolid, Relation, TrianglePair};

/// The relations of two bodies that are allowed. By default they may be apart or touch, and overlap by nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct Allowed {
    /// The relations.
    pub relations: Vec<Relation>,
    /// The largest volume by which two bodies that cross may overlap: flush parts cross by what rounding makes of them.
    pub overlap_volume: f64,
    /// Whether the contact of bodies that meet is measured too, which takes as long as all their pairs and more.
    pub with_contacts: bool,
}

impl Default for Allowed {
    fn default() -> Self {
        let relations = vec![Relation::Apart, Relation::Touching];
        Self { relations, overlap_volume: 0.0, with_contacts: false }
    }
}

/// Two bodies that are not surely apart.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckedPair {
    /// The bodies, that which was added first before the other.
    pub bodies: [BodyId; 2],
    /// The relation; `None` if it is undetermined, a body is no solid, or the pose of the first has no inverse.
    pub relation: Option<Relation>,
    /// Whether the surfaces meet.
    pub meets: bool,
    /// An interval that holds the common volume, in the world, of bodies that cross, if neither meets itself where they do.
    pub overlap_volume: Option<[f64; 2]>,
    /// The contact, in the world, of bodies whose surfaces meet, if [that is asked](Allowed::with_contacts).
    pub contact: Option<ContactSize>,
    /// An interval that holds the smallest distance in the world of bodies that are near.
    pub gap: Option<[f64; 2]>,
    /// A pair of triangles that shows the relation; the nearest of bodies that are near.
    pub pair: Option<TrianglePair>,
    /// A point in the world where they meet.
    pub place: Option<[f64; 3]>,
    /// Whether that is allowed. An undetermined relation is not.
    pub is_allowed: bool,
}

/// The relations of the bodies of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckReport {
    /// Bodies whose boxes overlap others and that are no solids, and why.
    pub refused: Vec<(BodyId, NotSolid)>,
    /// All pairs of bodies whose boxes and enclosing spheres overlap and that are not [ignored](crate::SceneQuery::ignore), sorted.
    pub pairs: Vec<CheckedPair>,
}

impl CheckReport {
    /// Whether every pair is allowed.
    #[must_use]
    pub fn is_allowed(&self) -> bool {
        self.pairs.iter().all(|pair| pair.is_allowed)
    }
}
