//! Without the feature `gpu` no body is on a GPU: what others use of `device.rs`.

use super::bodies::Bodies;
use super::hit::SceneHit;
use super::pairs::BodyPairs;
use crate::Error;
use crate::executor::{Answer, Device, Verb};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Has no body.
#[derive(Clone, Debug, Default)]
pub(super) struct NoDeviceScene(());

pub(super) type DeviceScene = NoDeviceScene;

impl NoDeviceScene {
    pub(super) fn lacks(&mut self, _: &Bodies) -> usize {
        0
    }

    pub(super) fn ask(
        &mut self,
        device: &Device,
        _: &BodyPairs<'_>,
        _: Option<&Arc<AtomicBool>>,
        _: Verb,
        _: &mut Vec<SceneHit>,
    ) -> Result<Answer<SceneHit>, Error> {
        match *device {}
    }
}
