//! The frames as a reader and a writer of the line see them.

mod frames;
