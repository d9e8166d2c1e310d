//! Triangle pairs with their truth.
