//! The committed bench is what the program makes.

mod committed;
