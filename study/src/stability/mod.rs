//! Scenes in which a p-partition front could fail, run over frames.
