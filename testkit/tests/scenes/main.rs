//! Every scene: sound meshes, the sizes the paper names, the same bits everywhere, real contact.

#[cfg(test)]
mod meshes;
#[cfg(test)]
mod motion;
#[cfg(test)]
mod oracle;
