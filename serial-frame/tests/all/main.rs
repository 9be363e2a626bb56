//! Tests of the public interface of the crate: frames that are written to a line and read from it.

mod frames;
