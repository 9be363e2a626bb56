//! Emitted source, run and compared.

mod arduino;
mod arithmetic;
mod benches;
mod c99;
mod emission;
mod files;
mod modes;
mod monitor;
mod refusals;
mod runtime_body;
mod runtime_drift;
mod runtime_encoder;
mod runtime_filter;
mod runtime_primitives;
mod runtime_step;
mod thesis;
