//! The attitude that the emitted filter reports as upright.

use crate::claims::functions::Functions;
use crate::domains::machine::Machine;
use crate::language::module::Module;

/// Directions about the pivot axis that are tried.
const DIRECTIONS: u32 = 3_600;

/// The reading of the accelerometer when the body is upright.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Upright {
    /// Counts along the three axes, by the calibration's scale but not its bias.
    pub(crate) counts: [f64; 3],
}

impl Upright {
    /// Tries gravity from all sides across the pivot axis; `None` where no direction can be used.
    pub(crate) fn find(module: &Module) -> Option<Upright> {
        let shortest = module
            .constant_words("constants", "FILTER")?
            .into_iter()
            .find(|(name, _)| name.ends_with(".gravity_squared_min"))?;
        // The shortest usable vector is an eighth of gravity; its square counts 2³², and a count is
        // about 2¹³ units.
        let length = 8.0 * (shortest.1 as f64).sqrt() * 2f64.powi(16 - 13);
        let start = Machine::new(module.function("Attitude::new")?)
            .call(&[])
            .ok()?
            .to_vec();
        let mut align = Machine::new(module.function("Attitude::align")?);
        let mut angle = Machine::new(module.function("Attitude::angle")?);
        let mut best: Option<(i128, [f64; 3])> = None;
        for part in 0..DIRECTIONS {
            let turn = f64::from(part) / f64::from(DIRECTIONS) * std::f64::consts::TAU;
            let counts = [length * turn.cos(), length * turn.sin(), 0.0];
            let words = counts.map(|count| count.round() as i128);
            let Ok(result) = align.call(&[&start[..], &words].concat()) else {
                continue;
            };
            let is_usable = result[0] != 0;
            // A method that does not return its receiver has another signature than an emitted one.
            let at = result.len().checked_sub(start.len())?;
            let state = result[at..].to_vec();
            let Ok(found) = angle.call(&state) else {
                continue;
            };
            let size = found[0].abs();
            if is_usable && best.as_ref().is_none_or(|(least, _)| size < *least) {
                best = Some((size, counts));
            }
        }
        best.map(|(_, counts)| Upright { counts })
    }

    /// Counts of a body that leans by `lean` rad about the pivot axis.
    pub(crate) fn leaning(&self, lean: f64) -> [f64; 3] {
        let (sin, cos) = lean.sin_cos();
        let [x, y, z] = self.counts;
        [cos * x - sin * y, sin * x + cos * y, z]
    }

    /// Words of the quaternion that alignment gives for such counts.
    pub(crate) fn attitude(&self, f: &Functions, lean: f64) -> Result<Vec<i128>, String> {
        let start = f.call("Attitude::new", &[])?;
        let counts = self.leaning(lean).map(|count| count.round() as i128);
        let result = f.call("Attitude::align", &[&start[..], &counts].concat())?;
        let words = result.get(1..5).map(<[i128]>::to_vec);
        words.ok_or_else(|| "Attitude::align gives no attitude back".to_owned())
    }
}
