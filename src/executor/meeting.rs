//! The places where two subjects of a frame meet.

use crate::{AnyPose, Contact, TrianglePair};
use pfront_core::bvtt::{AnyBvtt, Query};

/// A subject whose triangles are known to meet.
#[derive(Clone, Copy)]
pub(crate) struct Meeting<'q> {
    tree: AnyBvtt<'q>,
    /// The pose in which contacts are told, if it is not that of the tree.
    pose: Option<AnyPose>,
}

impl<'q> Meeting<'q> {
    pub(crate) fn new(tree: AnyBvtt<'q>, pose: Option<AnyPose>) -> Self {
        Self { tree, pose }
    }

    /// Where two triangles meet.
    pub(crate) fn contact(&self, pair: TrianglePair) -> Option<Contact> {
        match self.pose {
            None => self.tree.contact(pair),
            Some(_) => self.contact_f64(pair).map(Contact::from),
        }
    }

    /// The same in f64.
    pub(crate) fn contact_f64(&self, pair: TrianglePair) -> Option<Contact<f64>> {
        let contact = self.tree.contact_f64(pair)?;
        Some(self.pose.map_or(contact, |pose| pose.contact(contact)))
    }
}
