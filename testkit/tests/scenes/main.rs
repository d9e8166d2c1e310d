//! Every scene: sound meshes, the sizes the paper names, the same bits everywhere.

#[cfg(test)]
mod meshes;
#[cfg(test)]
mod oracle;
