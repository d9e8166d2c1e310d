//! The models of a query on a GPU, brought there when it is first asked and kept up to date from then on.

use super::{Device, Hidden};
use crate::executor::{Answer, Verb};
use crate::gpu::{Deforming, GpuError, GpuModel};
use crate::subject::Subject;
use crate::{Error, Model, Stamp, TrianglePair};
use pfront_core::bvh::BuildOptions;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// One model or two, of which the second may be the first.
#[derive(Debug, Default)]
pub(crate) struct Mirrors([Option<Hidden<Mirror>>; 2]);

/// A clone has to bring its models there by itself.
impl Clone for Mirrors {
    fn clone(&self) -> Self {
        Self::default()
    }
}

/// A model as it was brought there.
#[derive(Debug)]
struct Mirror {
    stamp: Stamp,
    model: Mirrored,
}

#[derive(Debug)]
enum Mirrored {
    Rigid(Arc<GpuModel>),
    Moving(Box<Deforming>),
}

impl Mirrors {
    /// Triangles of models that are not there.
    pub(crate) fn lack(&self, models: &[&Model]) -> usize {
        let lacks = |(own, model): (&Option<Hidden<Mirror>>, &&Model)| match own {
            Some(own) if own.stamp.mesh() == model.stamp().mesh() => 0,
            _ => model.mesh().triangles().len(),
        };
        self.0.iter().zip(distinct(models)).map(lacks).sum()
    }

    /// Brings the models of a subject there and asks about them; `pairs` is replaced, by the list under [`Verb::All`]. Pairs
    /// that the device leaves open are decided here.
    pub(crate) fn ask(
        &mut self,
        device: &Device,
        subject: &Subject<&Model>,
        cancel: Option<&Arc<AtomicBool>>,
        verb: Verb,
        pairs: &mut Vec<TrianglePair>,
    ) -> Result<Answer<TrianglePair>, Error> {
        let models = self.bring(device, subject.models())?;
        let outlines = Default::default();
        let left_open = subject.left_open(&outlines)?;
        let question = subject.question(models, left_open.as_ref())?;
        let intersects = |pair| left_open.as_ref().is_some_and(|tree| tree.intersects(pair));
        device.ask(&question, cancel, verb, pairs, intersects)
    }

    /// Brings models there, and returns them.
    fn bring(&mut self, device: &Device, models: &[&Model]) -> Result<[&GpuModel; 2], GpuError> {
        let distinct = distinct(models);
        for (own, model) in self.0.iter_mut().zip(distinct) {
            Mirror::bring(own, device, model)?;
        }
        let [first, second] = &self.0;
        let first = first.as_ref().map(|own| own.model()).ok_or(GpuError::OtherDevice)?;
        let second = if distinct.len() == 1 { None } else { second.as_ref() };
        Ok([first, second.map_or(first, |own| own.model())])
    }
}

/// A model that is both of two is brought there once.
fn distinct<'m, 's>(models: &'s [&'m Model]) -> &'s [&'m Model] {
    match models {
        [a, b] if a.stamp() == b.stamp() => &models[..1],
        _ => models,
    }
}

impl Mirror {
    fn model(&self) -> &GpuModel {
        match &self.model {
            Mirrored::Rigid(model) => model,
            Mirrored::Moving(model) => model,
        }
    }

    /// Makes it that of a model: uploads it, or its positions if it is the same mesh that has moved. A mesh counts as rigid, and is
    /// shared with whoever asks about it, until it has moved once; one without a fitted BVH has a tree of the device's own.
    fn bring(
        own: &mut Option<Hidden<Self>>,
        device: &Device,
        model: &Model,
    ) -> Result<(), GpuError> {
        let stamp = model.stamp();
        // After an error nothing is known of what is there.
        let before = own.take().map(Hidden::into_inner);
        let same_mesh = before.as_ref().is_some_and(|own| own.stamp.mesh() == stamp.mesh());
        match before {
            Some(mut before) if before.stamp == stamp => {
                if let Mirrored::Moving(moving) = &mut before.model
                    && moving.is_worn()
                {
                    moving.rebuild()?;
                }
                *own = Some(Hidden::new(before));
                return Ok(());
            }
            Some(Self { model: Mirrored::Moving(mut moving), .. }) if same_mesh => {
                let positions = model.mesh().shadow();
                // The tree of the CPU may be another, and worn or not.
                match moving.is_worn() {
                    true => moving.rebuild_at(positions)?,
                    false => moving.set_positions(positions)?,
                }
                *own = Some(Hidden::new(Self { stamp, model: Mirrored::Moving(moving) }));
                return Ok(());
            }
            _ => {}
        }
        // A device has the shadow of a mesh in f64 alone, which moves on the CPU.
        let moves = same_mesh || !model.is_fitted();
        let model = match moves && !model.is_f64() {
            true => {
                let options = BuildOptions { leaf_size: Deforming::LEAF_SIZE, join: None };
                Mirrored::Moving(Box::new(Deforming::build(&device.gpu, model.mesh(), &options)?))
            }
            false => Mirrored::Rigid(device.model(model)?),
        };
        *own = Some(Hidden::new(Self { stamp, model }));
        Ok(())
    }
}
