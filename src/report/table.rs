//! Tables whose columns align.

/// How a column is set.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Align {
    /// Texts.
    Left,
    /// Numbers.
    Right,
}

/// A table in the making.
pub struct Table {
    align: Vec<Align>,
    rows: Vec<Vec<String>>,
    has_head: bool,
}

impl Table {
    /// A table with these column heads.
    pub fn new(heads: &[(&str, Align)]) -> Table {
        Table {
            align: heads.iter().map(|(_, align)| *align).collect(),
            rows: vec![heads.iter().map(|(head, _)| (*head).to_owned()).collect()],
            has_head: true,
        }
    }

    /// A table of which only the alignment is given.
    pub fn without_head(align: &[Align]) -> Table {
        Table {
            align: align.to_vec(),
            rows: Vec::new(),
            has_head: false,
        }
    }

    /// Adds a row.
    pub fn row<T: Into<String>>(&mut self, cells: impl IntoIterator<Item = T>) {
        self.rows.push(cells.into_iter().map(Into::into).collect());
    }

    /// Whether there is no row beside the heads.
    pub fn is_empty(&self) -> bool {
        self.rows.len() <= usize::from(self.has_head)
    }

    /// The table as lines indented by two blanks, under a rule where it has heads.
    pub fn text(&self) -> String {
        let widths: Vec<usize> = (0..self.align.len())
            .map(|column| {
                self.rows
                    .iter()
                    .filter_map(|row| row.get(column))
                    .map(|cell| cell.chars().count())
                    .max()
                    .unwrap_or(0)
            })
            .collect();
        let mut text = String::new();
        for (index, row) in self.rows.iter().enumerate() {
            let mut line = String::new();
            for ((cell, &width), align) in row.iter().zip(&widths).zip(&self.align) {
                line.push_str("  ");
                match align {
                    Align::Left => line.push_str(&format!("{cell:<width$}")),
                    Align::Right => line.push_str(&format!("{cell:>width$}")),
                }
            }
            text.push_str(line.trim_end());
            text.push('\n');
            if index == 0 && self.has_head {
                let rule: usize = widths.iter().sum::<usize>() + 2 * widths.len().saturating_sub(1);
                text.push_str(&format!("  {}\n", "─".repeat(rule)));
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_align_by_characters_not_bytes() {
        let mut table = Table::new(&[
            ("name", Align::Left),
            ("value", Align::Right),
            ("unit", Align::Left),
        ]);
        assert!(table.is_empty());
        table.row(["Θ", "1 ± 2", "kg m2"]);
        table.row(["torque", "3", ""]);
        assert_eq!(
            table.text(),
            "  name    value  unit\n  ────────────────────\n  Θ       1 ± 2  kg m2\n  torque      3\n"
        );
        assert!(!table.is_empty());
    }
}
