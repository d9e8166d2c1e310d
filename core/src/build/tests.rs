//! Tests of every build.
