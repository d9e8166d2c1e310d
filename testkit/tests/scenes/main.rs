//! Every scene: sound meshes, the sizes the paper names, the same bits everywhere, real contact.

mod meshes;
mod motion;
mod oracle;
