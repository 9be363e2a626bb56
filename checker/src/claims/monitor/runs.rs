//! Claim `monitor-silent` in random runs: the emitted monitor and a second statement of it give the same sums and
//! answers.

use crate::claims::functions::{Functions, same};
use crate::claims::random::Random;
use crate::language::module::Module;

/// Largest magnitude of a sum.
const SUM_MAX: i128 = 1 << 28;

/// Number of words of a monitor: whether the controller was running (1), the last motion (4), sums and widths (4).
const WORDS: usize = 9;

/// A second statement of the monitor, in integers that cannot overflow.
struct Second {
    words: Vec<(String, i128)>,
    zero: i128,
}

impl Second {
    fn limit(&self, name: &str) -> Result<i128, String> {
        let name = format!("MOTION_LIMITS.{name}");
        let found = self.words.iter().find(|(known, _)| *known == name);
        found
            .map(|(_, word)| *word)
            .ok_or_else(|| format!("there is no {name}"))
    }

    fn row(&self, name: &str) -> Result<[i128; 4], String> {
        let word = |column: &str| self.limit(&format!("{name}.{column}"));
        Ok([
            word("angle")?,
            word("rate")?,
            word("wheel_speed")?,
            word("duty")?,
        ])
    }

    /// The answer of `Monitor::allows` followed by the monitor's next words, for its words `own` and the words of the
    /// arguments.
    fn allows(&self, own: &[i128], arguments: &[i128]) -> Result<Vec<i128>, String> {
        let (is_running, duty) = (arguments[0], arguments[4] - self.zero);
        let after = [arguments[1], arguments[2], arguments[3], duty];
        let before = &own[1..5];
        let dot = |row: [i128; 4]| -> i128 { row.iter().zip(before).map(|(a, b)| a * b).sum() };
        let size =
            |row: [i128; 4]| -> i128 { row.iter().zip(before).map(|(a, b)| a * b.abs()).sum() };
        let rate = (after[1] - before[1]) * self.limit("rate")?;
        let speed = (after[2] - before[2]) * self.limit("wheel_speed")?;
        let rests = [
            (rate + speed - dot(self.row("wheel")?), -SUM_MAX),
            (size(self.row("wheel_width")?), 0),
            (rate - dot(self.row("body")?), -SUM_MAX),
            (size(self.row("body_width")?), 0),
        ];
        let (leak, shift) = (self.limit("leak")?, self.limit("shift")?);
        let both = own[0] == 1 && is_running == 1;
        let sums: Vec<i128> = (0..4)
            .map(|at| {
                if !both {
                    return 0;
                }
                let (products, low) = rests[at];
                // The products are rounded to the nearest, halves upward; the leak is rounded downward.
                let more = (products + (1 << (shift - 1))).div_euclid(1 << shift);
                let kept = own[5 + at].clamp(-SUM_MAX, SUM_MAX);
                let next = kept - kept.div_euclid(1 << leak) + more.clamp(-SUM_MAX, SUM_MAX);
                next.clamp(low, SUM_MAX)
            })
            .collect();
        let is_allowed = sums[0].abs() <= self.limit("wheel_limit")? + sums[1]
            && sums[2].abs() <= self.limit("body_limit")? + sums[3];
        let mut words = vec![i128::from(is_allowed), is_running];
        words.extend(after);
        words.extend(sums);
        Ok(words)
    }
}

/// Runs `cases` steps, in runs of random length from random words.
///
/// # Errors
/// The first step in which source and second statement differ.
pub fn run(module: &Module, cases: usize, seed: u64) -> Result<usize, String> {
    let f = Functions(module);
    let second = Second {
        words: module
            .constant_words("monitor_words", "MOTION_LIMITS")
            .ok_or("src/monitor_words.rs has no MOTION_LIMITS")?,
        zero: f.constant("constants", "ZERO_CURRENT")?[0],
    };
    let start = f.call("Monitor::new", &[])?;
    if start != [0; WORDS] {
        return Err("Monitor::new gives words that are not all zero".to_owned());
    }
    let default = f.call("Monitor::default", &[])?;
    same("Monitor::default", &[], &default, &start)?;
    let mut random = Random::new(seed);
    let mut own = start.clone();
    for case in 0..cases {
        if random.choice(16) == 0 {
            own = if random.choice(2) == 0 {
                start.clone()
            } else {
                let mut words: Vec<i128> = (0..WORDS).map(|_| random.word()).collect();
                words[0] = random.choice(2).into();
                // The stored duty minus that of zero current is a difference of two counts, but any word is tried.
                words
            };
        }
        let arguments = [
            i128::from(random.choice(8) > 0),
            random.word(),
            random.word(),
            random.word(),
            random.choice(1 << 16).into(),
        ];
        let all = [&own[..], &arguments].concat();
        let found = f.call("Monitor::allows", &all)?;
        let wanted = second.allows(&own, &arguments)?;
        same("Monitor::allows", &all, &found, &wanted)
            .map_err(|why| format!("case {case}: {why}"))?;
        own = found[1..].to_vec();
    }
    Ok(cases)
}
