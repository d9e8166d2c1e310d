//! The places where two subjects of a frame meet.

use crate::{AnyPose, Contact, TrianglePair};
use pfront_core::bvtt::{AnyBvtt, Query, SelfBvtt};

/// A subject whose triangles are known to meet.
#[derive(Clone, Copy)]
pub(crate) enum Meeting<'q> {
    /// Contacts are told of the meshes as the tree takes them.
    InTree(AnyBvtt<'q>),
    /// The contacts of a mesh with itself are told of the posed mesh.
    Posed(SelfBvtt<'q>, AnyPose),
}

impl Meeting<'_> {
    /// Where two triangles meet.
    pub(crate) fn contact(&self, pair: TrianglePair) -> Option<Contact> {
        match self {
            Self::InTree(tree) => tree.contact(pair),
            Self::Posed(..) => self.contact_f64(pair).map(Contact::from),
        }
    }

    /// The same in f64.
    pub(crate) fn contact_f64(&self, pair: TrianglePair) -> Option<Contact<f64>> {
        match self {
            Self::InTree(tree) => tree.contact_f64(pair),
            Self::Posed(tree, pose) => tree.posed_contact(pair, &pose.to_f64()),
        }
    }
}
