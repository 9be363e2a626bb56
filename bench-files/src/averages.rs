//! Block averages for logs with more rows than a fit can use. They are computed while the file is
//! read, so that at most [`MOST_BLOCKS`] blocks are in memory for a file of any length.
//!
//! A block holds one row until there are too many blocks; then every two blocks are joined, as often as necessary. A
//! sensor's average belongs to the mean time of its rows. A command is held from row to row; the value of a block is the
//! one that has the same integral over time up to the next block.

/// Largest number of blocks. A million samples are a quarter of an hour at 1 kHz; a larger number does not improve a
/// fit.
pub const MOST_BLOCKS: usize = 1 << 20;

/// Averages over blocks of rows, for some columns and the time.
#[derive(Clone, Debug)]
pub(crate) struct Averages {
    /// Number of columns beside the time.
    columns: usize,
    /// Index of the column that holds a command, if there is one.
    command: Option<usize>,
    /// Number of rows per block.
    rows: usize,
    most: usize,
    blocks: Vec<Block>,
    /// For every block and column, the sum of the finite samples.
    sums: Vec<f64>,
    /// For every block and column, the number of finite samples.
    counts: Vec<u32>,
    /// Time and command of the last row, and the integral of the command up to it.
    last: Option<(f64, f64)>,
    charge: f64,
}

/// The data of a block apart from its samples.
#[derive(Clone, Copy, Debug)]
struct Block {
    rows: usize,
    time_sum: f64,
    /// Time of the block's first row, and the integral of the command up to it.
    first: (f64, f64),
    /// The same for the first row of the second half of the block.
    half: (f64, f64),
}

impl Averages {
    /// No rows yet; at most `most` blocks are kept (an even number).
    pub fn new(columns: usize, command: Option<usize>, most: usize) -> Averages {
        Averages {
            columns,
            command,
            rows: 1,
            most,
            blocks: Vec::new(),
            sums: Vec::new(),
            counts: Vec::new(),
            last: None,
            charge: 0.0,
        }
    }

    /// Number of rows per block.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Adds a row; a sample that is not finite is missing.
    pub fn push(&mut self, time_s: f64, samples: impl Iterator<Item = f64> + Clone) {
        if let Some((last_s, command)) = self.last {
            self.charge += command * (time_s - last_s);
        }
        let command = self.command.and_then(|at| samples.clone().nth(at));
        self.last = Some((time_s, command.unwrap_or(0.0)));
        let is_full = |block: &&mut Block| block.rows < self.rows;
        if self.blocks.last_mut().filter(is_full).is_none() {
            if self.blocks.len() == self.most {
                self.halve();
            }
            // After the blocks have been joined, the last one may have room again.
            let now = (time_s, self.charge);
            self.blocks.push(Block {
                rows: 0,
                time_sum: 0.0,
                first: now,
                half: now,
            });
            self.sums.resize(self.sums.len() + self.columns, 0.0);
            self.counts.resize(self.counts.len() + self.columns, 0);
        }
        let half = self.rows / 2;
        if let Some(block) = self.blocks.last_mut() {
            if block.rows == half {
                block.half = (time_s, self.charge);
            }
            block.rows += 1;
            block.time_sum += time_s;
        }
        let start = self.sums.len() - self.columns;
        let own = self.sums[start..].iter_mut().zip(&mut self.counts[start..]);
        for ((sum, count), sample) in own.zip(samples) {
            if sample.is_finite() {
                *sum += sample;
                *count += 1;
            }
        }
    }

    /// Joins every two blocks into one.
    fn halve(&mut self) {
        let columns = self.columns;
        let half = self.blocks.len() / 2;
        for at in 0..half {
            let (one, other) = (self.blocks[2 * at], self.blocks[2 * at + 1]);
            self.blocks[at] = Block {
                rows: one.rows + other.rows,
                time_sum: one.time_sum + other.time_sum,
                first: one.first,
                half: other.first,
            };
            for column in 0..columns {
                let (to, a) = (at * columns + column, 2 * at * columns + column);
                self.sums[to] = self.sums[a] + self.sums[a + columns];
                self.counts[to] = self.counts[a] + self.counts[a + columns];
            }
        }
        self.blocks.truncate(half);
        self.sums.truncate(half * columns);
        self.counts.truncate(half * columns);
        self.rows *= 2;
    }

    /// The time of every block, and its averages column by column; NaN where fewer than half of the samples are finite.
    pub fn series(mut self) -> (Vec<f64>, Vec<Vec<f64>>) {
        self.join_rest();
        let time_s: Vec<f64> = self
            .blocks
            .iter()
            .map(|block| block.time_sum / block.rows as f64)
            .collect();
        let series = (0..self.columns)
            .map(|column| {
                if self.command == Some(column) && self.rows > 1 {
                    self.commands(column, &time_s)
                } else {
                    (0..time_s.len()).map(|at| self.mean(at, column)).collect()
                }
            })
            .collect();
        (time_s, series)
    }

    /// Joins a last block with less than half the rows of the others to the block before it.
    fn join_rest(&mut self) {
        let is_short = |last: &mut Block| 2 * last.rows < self.rows;
        if self.blocks.len() < 2 {
            return;
        }
        if let Some(rest) = self.blocks.pop_if(is_short)
            && let Some(last) = self.blocks.last_mut()
        {
            last.rows += rest.rows;
            last.time_sum += rest.time_sum;
            let kept = self.blocks.len() * self.columns;
            for column in 0..self.columns {
                self.sums[kept - self.columns + column] += self.sums[kept + column];
                self.counts[kept - self.columns + column] += self.counts[kept + column];
            }
        }
    }

    fn mean(&self, block: usize, column: usize) -> f64 {
        let at = block * self.columns + column;
        let count = self.counts[at] as usize;
        if 2 * count >= self.blocks[block].rows {
            self.sums[at] / count as f64
        } else {
            f64::NAN
        }
    }

    /// The command values that, held from each block's time to the next, have the integral of the logged command.
    fn commands(&self, column: usize, time_s: &[f64]) -> Vec<f64> {
        let charge = |at: usize| {
            let Block { first, half, .. } = self.blocks[at];
            let mean = if half.0 > first.0 {
                (half.1 - first.1) / (half.0 - first.0)
            } else {
                self.mean(at, column)
            };
            half.1 + mean * (time_s[at] - half.0)
        };
        let last = time_s.len().saturating_sub(1);
        (0..time_s.len())
            .map(|at| {
                if at == last {
                    return self.mean(at, column);
                }
                (charge(at + 1) - charge(at)) / (time_s[at + 1] - time_s[at])
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn averages(rows: usize, most: usize) -> Averages {
        let mut averages = Averages::new(2, Some(1), most);
        for k in 0..rows {
            let t = k as f64 * 0.001;
            let command = if (k / 37) % 2 == 0 { 0.5 } else { -0.25 };
            averages.push(t, [3.0 + 2.0 * t, command].into_iter());
        }
        averages
    }

    #[test]
    fn few_rows_stay_as_they_are() {
        let (time_s, series) = averages(16, 16).series();
        assert_eq!(time_s.len(), 16);
        for (t, value) in time_s.iter().zip(&series[0]) {
            assert_eq!(*value, 3.0 + 2.0 * t);
        }
        assert!(series[1].iter().all(|value| *value == 0.5));
    }

    #[test]
    fn blocks_double_and_keep_a_line_and_the_integral_of_the_command() {
        for rows in [17, 100, 1000, 1001, 1023, 4096, 5000] {
            let averages = averages(rows, 16);
            let length = averages.rows();
            let (time_s, series) = averages.series();
            assert!((8..=16).contains(&time_s.len()), "{rows}: {}", time_s.len());
            // The mean of a line stands on the line.
            for (t, value) in time_s.iter().zip(&series[0]) {
                assert!((value - 3.0 - 2.0 * t).abs() < 1e-12, "{rows}: {t} {value}");
            }
            let held: f64 = (1..time_s.len())
                .map(|at| series[1][at - 1] * (time_s[at] - time_s[at - 1]))
                .sum();
            let (first, last) = (time_s[0], time_s[time_s.len() - 1]);
            let logged: f64 = (0..rows)
                .map(|k| {
                    let from = (k as f64 * 0.001).clamp(first, last);
                    let to = ((k + 1) as f64 * 0.001).clamp(first, last);
                    let command = if (k / 37) % 2 == 0 { 0.5 } else { -0.25 };
                    command * (to - from)
                })
                .sum();
            // Exact up to half a row at either end.
            let allowed = 0.001 * 0.75 * (1.0 + length as f64 / 8.0);
            assert!((held - logged).abs() < allowed, "{rows}: {held} {logged}");
        }
    }

    #[test]
    fn samples_that_dropped_out_do_not_count() {
        let mut averages = Averages::new(1, None, 4);
        for k in 0..32 {
            let lost = (8..16).contains(&k) || k % 4 == 0;
            let value = if lost { f64::NAN } else { 1.0 };
            averages.push(f64::from(k), std::iter::once(value));
        }
        assert_eq!((averages.rows(), averages.blocks.len()), (8, 4));
        let (_, series) = averages.series();
        assert_eq!(series[0][0], 1.0);
        assert!(series[0][1].is_nan());
    }
}
