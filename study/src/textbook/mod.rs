//! Triangle tests of the literature, as printed.
