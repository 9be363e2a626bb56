//! The constants of the emitted filter as numbers.

use crate::claims::filter_accurate::equations::dot3;
use crate::claims::functions::number;
use crate::language::module::Module;

/// The constants of the filter as numbers.
#[derive(Clone, Debug)]
pub(crate) struct Filter {
    pub(crate) words: Vec<(String, i128)>,
    pub(crate) gyro: Sensor,
    pub(crate) accel: Sensor,
    pub(crate) mag: Sensor,
    pub(crate) beta_step: f64,
    pub(crate) centripetal: [f64; 2],
    pub(crate) tangential: [f64; 2],
}

/// M (raw − bias), in the units of the words.
#[derive(Clone, Debug)]
pub(crate) struct Sensor {
    pub(crate) bias: [f64; 3],
    pub(crate) matrix: [[f64; 3]; 3],
    /// Counts at or beyond which an axis shows nothing; infinite for a gyroscope, which the filter always believes.
    clip: [f64; 3],
}

impl Sensor {
    pub(crate) fn read(words: &[(String, i128)], name: &str) -> Result<Sensor, String> {
        let get = |field: String| number(words, &format!(".{name}.{field}"));
        let mut bias = [0.0; 3];
        let mut matrix = [[0.0; 3]; 3];
        let shift = get("shift".to_owned())?;
        for i in 0..3 {
            bias[i] = get(format!("bias[{i}]"))? / 32_768.0;
            for (row, letter) in ["x", "y", "z"].into_iter().enumerate() {
                matrix[row][i] = get(format!("{letter}[{i}]"))? / 2f64.powf(17.0 + shift);
            }
        }
        let clip_of = |i: usize| number(words, &format!(".{name}_clip[{i}]"));
        let clip = if name == "gyro" {
            [f64::INFINITY; 3]
        } else {
            [clip_of(0)?, clip_of(1)?, clip_of(2)?]
        };
        Ok(Sensor { bias, matrix, clip })
    }

    /// Whether no axis is at or beyond the end of its range.
    pub(crate) fn shows(&self, raw: [i128; 3]) -> bool {
        (0..3).all(|i| (raw[i] as f64).abs() < self.clip[i])
    }

    pub(crate) fn calibrated(&self, raw: [i128; 3]) -> [f64; 3] {
        let v = [0, 1, 2].map(|i| raw[i] as f64 - self.bias[i]);
        self.matrix.map(|row| dot3(row, v))
    }
}

impl Filter {
    pub(crate) fn of(module: &Module) -> Result<Filter, String> {
        let words = module
            .constant_words("constants", "FILTER")
            .ok_or("src/constants.rs has no FILTER")?;
        Filter::new(words)
    }

    pub(crate) fn new(words: Vec<(String, i128)>) -> Result<Filter, String> {
        let get = |name: &str| number(&words, name);
        Ok(Filter {
            gyro: Sensor::read(&words, "gyro")?,
            accel: Sensor::read(&words, "accel")?,
            mag: Sensor::read(&words, "mag")?,
            beta_step: get(".beta")? / 2f64.powi(35),
            centripetal: [
                get(".lever_arm.centripetal[0]")?,
                get(".lever_arm.centripetal[1]")?,
            ],
            tangential: [
                get(".lever_arm.tangential[0]")?,
                get(".lever_arm.tangential[1]")?,
            ],
            words,
        })
    }

    /// The constants with a lever arm, which many benches do not have.
    pub(crate) fn with_lever_arm(&self) -> Result<Filter, String> {
        let mut words = self.words.clone();
        let values = [
            (".lever_arm.centripetal[0]", 91_000),
            (".lever_arm.centripetal[1]", -57_000),
            (".lever_arm.tangential[0]", 13_000_000),
            (".lever_arm.tangential[1]", -9_000_000),
        ];
        for (name, value) in values {
            for (known, word) in &mut words {
                if known.ends_with(name) {
                    *word = value;
                }
            }
        }
        Filter::new(words)
    }

    pub(crate) fn flat(&self) -> impl Iterator<Item = i128> + '_ {
        self.words.iter().map(|(_, word)| *word)
    }
}
