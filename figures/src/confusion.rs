//! Figure: a confusion matrix of truths and answers.

use crate::error::{FigureError, check_length};
use crate::page::Page;
use crate::style;
use crate::svg::{Anchor, Path, Stroke, Text};
use crate::text;

/// A confusion matrix.
#[derive(Debug, Clone, Copy, Default)]
pub struct Confusion<'a> {
    /// The message of the figure, as a sentence.
    pub title: &'a str,
    /// A second line; may be empty.
    pub subtitle: &'a str,
    /// Names of the rows: the truths.
    pub truths: &'a [&'a str],
    /// Names of the columns: the answers.
    pub answers: &'a [&'a str],
    /// Counts, row after row: truths × answers values.
    pub counts: &'a [usize],
}

/// Draws the matrix. The shade of a cell is its share of the row, the number
/// in it the count. A cell whose row and column have the same name is framed.
///
/// # Errors
/// [`FigureError::Length`] unless there is one count for each cell.
pub fn confusion(figure: &Confusion) -> Result<String, FigureError> {
    let (rows, columns) = (figure.truths.len(), figure.answers.len());
    let found = figure.counts.len();
    check_length(figure.title, || "the matrix".into(), rows * columns, found)?;
    let mut page = Page::new(figure.title, figure.subtitle);
    let widest = |names: &[&str]| {
        let widths = names.iter().map(|n| text::width(n, style::TICK_SIZE));
        widths.fold(40.0, f64::max).min(230.0)
    };
    let (row_labels, column_labels) = (widest(figure.truths), widest(figure.answers));
    // Column names lean to the right by 45°.
    let lean = std::f64::consts::FRAC_1_SQRT_2;
    let left = style::PAGE_MARGIN + row_labels + 10.0;
    let room = style::PAGE_WIDTH - style::PAGE_MARGIN - left - column_labels * lean;
    let cell = (room / columns.max(1) as f64).clamp(14.0, 40.0);
    let top = page.y + 40.0 + column_labels * lean;
    let muted = |x, y| Text::new(x, y, style::LABEL_SIZE, style::TEXT_MUTED);
    let answered = muted(left, page.y + 16.0);
    page.svg.text(answered, "answered →");
    let truth = muted(left - 8.0, top - 8.0).anchor(Anchor::End);
    page.svg.text(truth, "true ↓");

    for (column, name) in figure.answers.iter().enumerate() {
        let x = left + (column as f64 + 0.5) * cell;
        let at = Text::new(x, top - 6.0, style::TICK_SIZE, style::TEXT).angle_deg(-45.0);
        page.svg
            .text(at, &text::shorten(name, style::TICK_SIZE, column_labels));
    }
    for (row, truth) in figure.truths.iter().enumerate() {
        let counts = &figure.counts[row * columns..(row + 1) * columns];
        let total: usize = counts.iter().sum();
        let y = top + row as f64 * cell;
        page.svg.begin_series("truth", truth);
        let baseline = y + cell / 2.0 + 3.8;
        let at = Text::new(left - 8.0, baseline, style::TICK_SIZE, style::TEXT);
        let name = text::shorten(truth, style::TICK_SIZE, row_labels);
        page.svg.text(at.anchor(Anchor::End), &name);
        for (column, &count) in counts.iter().enumerate() {
            let x = left + column as f64 * cell;
            let share = count as f64 / total.max(1) as f64;
            page.svg
                .rect(x + 0.5, y + 0.5, cell - 1.0, cell - 1.0, &shade(share));
            if figure.answers[column] == *truth {
                let mut path = Path::default();
                path.move_to(x + 0.5, y + 0.5);
                path.line_to(x + cell - 0.5, y + 0.5);
                path.line_to(x + cell - 0.5, y + cell - 0.5);
                path.line_to(x + 0.5, y + cell - 0.5);
                path.close();
                page.svg.path(&path, Stroke::solid(style::AXIS, 1.0));
            }
            if count > 0 {
                let ink = if share > 0.45 { "#FFFFFF" } else { style::TEXT };
                let content = count.to_string();
                let size = (cell * 0.9 / text::width(&content, 1.0)).min(style::NOTE_SIZE);
                let at = Text::new(x + cell / 2.0, y + cell / 2.0 + size * 0.36, size, ink);
                page.svg.text(at.anchor(Anchor::Middle), &content);
            }
        }
        page.svg.end();
    }
    page.y = top + rows as f64 * cell + 8.0;
    page.note("Shade: share of the row. Number: count. Framed: the right answer.");
    Ok(page.finish())
}

/// From nearly white to the dark blue of the model.
fn shade(share: f64) -> String {
    let from = [0xF4, 0xF6, 0xF8];
    let to = [0x00, 0x50, 0x8C];
    // The square root makes rare answers visible.
    let weight = share.clamp(0.0, 1.0).sqrt();
    let mix = |i: usize| {
        let (a, b) = (f64::from(from[i]), f64::from(to[i]));
        (a + (b - a) * weight).round() as u8
    };
    format!("#{:02X}{:02X}{:02X}", mix(0), mix(1), mix(2))
}
