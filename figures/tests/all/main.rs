//! Every figure is well-formed XML and a small file, contains every series, has no coordinates that are not numbers,
//! and keeps its labels intact.

mod any_numbers;
mod scales;
mod svg;
mod time_series;
mod whole;
