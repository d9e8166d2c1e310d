//! Workloads on the engines of [`pfront_lab`].

use anyhow::{Context, Result};
use pfront::Model;
use pfront_lab::engine::{Engine, Objects};
use pfront_lab::workload::{Frame, Header};
use std::sync::Arc;

/// Builds each mesh's BVH, once.
///
/// # Errors
/// If a mesh is none.
pub(crate) fn objects(header: Header) -> Result<Objects> {
    let models = header.meshes.into_iter().zip(0..).map(|(mesh, number)| {
        let model = Model::new(mesh.positions, mesh.triangles);
        model.map(Arc::new).with_context(|| format!("mesh {number}"))
    });
    let models: Vec<Arc<Model>> = models.collect::<Result<_>>()?;
    let models = header.objects.iter().map(|&mesh| models[mesh as usize].clone()).collect();
    Ok(Objects::new(header.kind, models))
}

/// Moves everything to where it is in a frame.
///
/// # Errors
/// If a pose or a shape is refused.
pub(crate) fn update(engine: &mut dyn Engine, frame: Frame<'_>) -> Result<()> {
    match frame {
        Frame::Poses(poses) => {
            for (object, &pose) in poses.iter().enumerate() {
                engine.place(object, pose)?;
            }
        }
        Frame::Positions(positions) => engine.deform(positions)?,
    }
    Ok(())
}
