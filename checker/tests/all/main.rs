//! The checker from outside: what it proves, what it refuses, and who notices damage.

mod attacks;
mod attacks_on_folders;
mod attacks_on_numbers;
mod attraction;
mod certificate;
mod closed_loop;
mod document;
mod folders;
mod from_rest;
mod harnesses;
mod held_input;
mod interpreter;
mod intervals;
mod length;
mod mutants;
mod nested;
mod observer;
mod physical_signs;
mod pivot;
mod refusals;
mod shipped;
mod stability;
mod windows;
