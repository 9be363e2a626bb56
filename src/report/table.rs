//! Tables with aligned columns that fit on a terminal.

use std::sync::atomic::{AtomicBool, Ordering};

/// The alignment of a column.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Align {
    /// Texts.
    Left,
    /// Numbers.
    Right,
}

/// A table under construction.
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

    /// A table without column heads, with these alignments.
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

    /// Whether the table has no rows.
    pub fn is_empty(&self) -> bool {
        self.rows.len() <= usize::from(self.has_head)
    }

    /// The table as lines indented by two spaces, with a rule below the heads, if there are any. Texts that do not fit into
    /// [`WIDTH`] are wrapped; columns of numbers that do not fit continue in a second table below. Of a long table, the
    /// first rows are shown, unless [`show_all`] was called.
    pub fn text(&self) -> String {
        let heads = usize::from(self.has_head);
        let rows = self.rows.len() - heads.min(self.rows.len());
        let is_cut = rows > MOST_ROWS && !ALL.load(Ordering::Relaxed);
        let shown = if is_cut {
            &self.rows[..heads + MOST_ROWS]
        } else {
            &self.rows[..]
        };
        let widths = fitted(self.widths(shown), &self.align);
        let mut text = String::new();
        for part in parts(&widths) {
            if !text.is_empty() {
                text.push('\n');
            }
            self.write(shown, &part, &widths, &mut text);
        }
        if is_cut {
            let left_out = rows - MOST_ROWS;
            text.push_str(&format!("  … and {left_out} more, which --all shows\n"));
        }
        text
    }

    fn widths(&self, rows: &[Vec<String>]) -> Vec<usize> {
        let of_column = |column: usize| {
            let cells = rows.iter().filter_map(|row| row.get(column));
            cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
        };
        (0..self.align.len()).map(of_column).collect()
    }

    /// Writes some of the columns.
    fn write(&self, rows: &[Vec<String>], columns: &[usize], widths: &[usize], text: &mut String) {
        for (index, row) in rows.iter().enumerate() {
            let wrapped: Vec<Vec<String>> = columns
                .iter()
                .map(|&column| {
                    let cell = row.get(column).map_or("", String::as_str);
                    wrap(cell, widths[column])
                })
                .collect();
            let lines = wrapped.iter().map(Vec::len).max().unwrap_or(1);
            for number in 0..lines {
                let mut line = String::new();
                for (pieces, &column) in wrapped.iter().zip(columns) {
                    let (piece, width) = (
                        pieces.get(number).map_or("", String::as_str),
                        widths[column],
                    );
                    line.push_str("  ");
                    match self.align[column] {
                        Align::Left => line.push_str(&format!("{piece:<width$}")),
                        Align::Right => line.push_str(&format!("{piece:>width$}")),
                    }
                }
                text.push_str(line.trim_end());
                text.push('\n');
            }
            if index == 0 && self.has_head {
                let rule: usize = columns.iter().map(|&column| widths[column] + 2).sum();
                text.push_str(&format!("  {}\n", "─".repeat(rule.saturating_sub(2))));
            }
        }
    }
}

/// Largest width of a table, in characters.
pub const WIDTH: usize = 100;
/// Largest number of rows shown by default: two screens.
const MOST_ROWS: usize = 60;
/// Smallest width to which a column of texts is wrapped.
const LEAST_WIDTH: usize = 24;

/// Whether the rows beyond [`MOST_ROWS`] are shown. It is set once, by the command line.
static ALL: AtomicBool = AtomicBool::new(false);

/// Lets every table show all of its rows.
pub fn show_all() {
    ALL.store(true, Ordering::Relaxed);
}

fn whole(widths: &[usize]) -> usize {
    widths.iter().map(|width| width + 2).sum()
}

/// Narrows the widest text columns until the table fits, or nothing can be narrowed further.
fn fitted(mut widths: Vec<usize>, align: &[Align]) -> Vec<usize> {
    while whole(&widths) > WIDTH {
        let texts =
            (0..widths.len()).filter(|&k| align[k] == Align::Left && widths[k] > LEAST_WIDTH);
        let Some(widest) = texts.max_by_key(|&k| widths[k]) else {
            break;
        };
        let over = whole(&widths) - WIDTH;
        widths[widest] = widths[widest].saturating_sub(over).max(LEAST_WIDTH);
    }
    widths
}

/// The columns of each part of a table: all if they fit, otherwise the first column together with as many
/// others as fit.
fn parts(widths: &[usize]) -> Vec<Vec<usize>> {
    let Some((first, others)) = widths.split_first() else {
        return vec![];
    };
    let mut parts: Vec<Vec<usize>> = vec![vec![0]];
    let mut room = WIDTH.saturating_sub(first + 2);
    for (index, width) in others.iter().enumerate() {
        let is_alone = parts.last().is_none_or(|part| part.len() == 1);
        if width + 2 > room && !is_alone {
            parts.push(vec![0]);
            room = WIDTH.saturating_sub(first + 2);
        }
        room = room.saturating_sub(width + 2);
        if let Some(part) = parts.last_mut() {
            part.push(index + 1);
        }
    }
    parts
}

/// A text in lines of this width, broken at spaces if there are any.
fn wrap(text: &str, width: usize) -> Vec<String> {
    if text.chars().count() <= width {
        return vec![text.to_owned()];
    }
    let mut lines = vec![];
    let mut line = String::new();
    for word in text.split_whitespace() {
        let mut word: Vec<char> = word.chars().collect();
        let length = line.chars().count();
        if length > 0 && length + 1 + word.len() > width {
            lines.push(std::mem::take(&mut line));
        } else if length > 0 {
            line.push(' ');
        }
        while word.len() > width.max(1) {
            // A name is broken behind one of its marks, if it has one.
            let longest = width.max(1);
            let mark = word[..longest].iter().rposition(|c| "/_-".contains(*c));
            let rest = word.split_off(mark.map_or(longest, |at| at + 1));
            lines.push(word.into_iter().collect());
            word = rest;
        }
        line.extend(word);
    }
    lines.push(line);
    lines
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
    #[test]
    fn a_long_name_is_broken_behind_its_marks() {
        let name = "body_presliding_stiffness";
        assert_eq!(wrap(name, 24), ["body_presliding_", "stiffness"]);
        let series = "spin-up-0.6A-reversed/wheel_speed";
        assert_eq!(wrap(series, 24), ["spin-up-0.6A-reversed/", "wheel_speed"]);
        assert_eq!(wrap("abcdefgh", 3), ["abc", "def", "gh"]);
    }

    #[test]
    fn no_table_is_wider_than_a_terminal() {
        let long = "a text of many words that says what nobody reads to its end ".repeat(4);
        let mut heads = vec![("experiment", Align::Left)];
        heads.extend([("a step with a long name", Align::Right); 12]);
        heads.push(("remark", Align::Left));
        let mut table = Table::new(&heads);
        let mut row = vec!["x".repeat(150)];
        row.extend((0..12).map(|k| format!("{k}.0 rad/s")));
        row.push(long.clone());
        table.row(row);
        let text = table.text();
        assert!(
            text.lines().all(|line| line.chars().count() <= WIDTH),
            "{text}"
        );
        // Nothing is lost.
        for word in long.split_whitespace() {
            assert!(text.contains(word), "{word}");
        }
        // Beside the name once a table, "experiment" in its head, and "text" four times.
        assert_eq!((text.matches('x').count() - 4) % 151, 0, "{text}");
        assert!(
            (0..12).all(|k| text.contains(&format!(" {k}.0 rad/s"))),
            "{text}"
        );
    }

    #[test]
    fn of_a_long_table_the_first_rows_are_shown() {
        let mut table = Table::without_head(&[Align::Right]);
        for number in 0..1000 {
            table.row([format!("row {number}")]);
        }
        let text = table.text();
        assert_eq!(text.lines().count(), MOST_ROWS + 1);
        assert!(
            text.ends_with("… and 940 more, which --all shows\n"),
            "{text}"
        );
    }
}
