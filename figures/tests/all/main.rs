//! What must hold of every figure: well-formed XML, every series there, no
//! value that is not a number, small files, labels intact.

mod any_numbers;
mod scales;
mod svg;
mod time_series;
mod whole;
