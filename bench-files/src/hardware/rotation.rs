//! How a sensor is mounted: the matrix that takes its axes to the body's, from `axes` or `rotation`.

use crate::error::{Error, Problem};
use crate::toml_section::Section;

/// A matrix, row by row.
pub(super) type Rotation = [[f64; 3]; 3];

/// Largest deviation of an entry of R Rᵀ from that of the identity matrix: numbers with three
/// digits are accepted.
const ROTATION_ERROR_MAX: f64 = 2e-3;

/// From `axes` or `rotation` to the matrix that takes the sensor's axes to the body's.
pub(super) fn rotation(table: &Section) -> Result<Option<Rotation>, Error> {
    if let Some(axes) = table.texts("axes")? {
        if table.has("rotation") {
            return Err(table.error_at("rotation", Problem::AxesAndRotation));
        }
        let names: Vec<&str> = axes.iter().map(|axis| axis.value.as_str()).collect();
        let matrix = <[&str; 3]>::try_from(names.as_slice())
            .ok()
            .and_then(|names| by_axes(&names));
        let Some(matrix) = matrix else {
            return Err(table.error_at("axes", Problem::NotAxes));
        };
        return right_handed(table, "axes", matrix).map(Some);
    }
    let expected = "three rows of three numbers, [[1, 0, 0], [0, 1, 0], [0, 0, 1]]";
    let Some(numbers) = table.numbers("rotation", &[3, 3], expected)? else {
        return Ok(None);
    };
    let matrix = [0, 1, 2].map(|row| [0, 1, 2].map(|column| numbers[3 * row + column]));
    let turned_back = product(&matrix, &transposed(&matrix));
    for (row, entries) in turned_back.iter().enumerate() {
        for (column, entry) in entries.iter().enumerate() {
            let wanted = f64::from(u8::from(row == column));
            if (entry - wanted).abs() > ROTATION_ERROR_MAX {
                return Err(table.error_at("rotation", Problem::NotARotation));
            }
        }
    }
    right_handed(table, "rotation", matrix).map(Some)
}

/// The matrix whose columns are the body axes of the sensor's axes; `None` if these are
/// not three different axes.
pub(super) fn by_axes(axes: &[&str; 3]) -> Option<Rotation> {
    let mut matrix = [[0.0; 3]; 3];
    let mut taken = [false; 3];
    for (column, axis) in axes.iter().enumerate() {
        let (sign, name) = match axis.strip_prefix('-') {
            Some(name) => (-1.0, name),
            None => (1.0, axis.strip_prefix('+').unwrap_or(axis)),
        };
        let row = ["x", "y", "z"].iter().position(|known| *known == name)?;
        if std::mem::replace(&mut taken[row], true) {
            return None;
        }
        matrix[row][column] = sign;
    }
    Some(matrix)
}

fn right_handed(table: &Section, key: &'static str, matrix: Rotation) -> Result<Rotation, Error> {
    if determinant(&matrix) > 0.0 {
        Ok(matrix)
    } else {
        Err(table.error_at(key, Problem::LeftHanded { key }))
    }
}

fn transposed(m: &Rotation) -> Rotation {
    [0, 1, 2].map(|row| [0, 1, 2].map(|column| m[column][row]))
}

/// The product of two matrices.
pub(super) fn product(a: &Rotation, b: &Rotation) -> Rotation {
    [0, 1, 2].map(|row| [0, 1, 2].map(|column| (0..3).map(|k| a[row][k] * b[k][column]).sum()))
}

fn determinant(m: &Rotation) -> f64 {
    m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
        - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
        + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
}
