//! Figure: the probability of each suspected effect.

use crate::page::Page;
use crate::style::{self, LineRole};
use crate::svg::{Anchor, Path, Stroke, Text};
use crate::text;

/// The suspects in the order in which they are to appear.
#[derive(Debug, Clone, Copy, Default)]
pub struct Suspects<'a> {
    /// The title: a sentence that says what the figure shows.
    pub title: &'a str,
    /// A second line below the title; may be empty.
    pub subtitle: &'a str,
    /// The suspects.
    pub suspects: &'a [SuspectBar<'a>],
}

/// One suspected effect.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SuspectBar<'a> {
    /// Name of the effect, or a sentence such as "none in the library".
    pub name: &'a str,
    /// Probability, 0 to 1.
    pub probability: f64,
    /// One sentence of evidence; may be empty.
    pub evidence: &'a str,
}

/// Draws a horizontal bar for each suspect, its probability in percent at the
/// right, and the evidence below the bar.
pub fn suspects(figure: &Suspects) -> String {
    let mut page = Page::new(figure.title, figure.subtitle);
    if figure.suspects.is_empty() {
        // Without suspects, a sentence replaces the axes.
        let at = Text::new(
            style::PAGE_MARGIN,
            page.y + 18.0,
            style::LABEL_SIZE,
            style::TEXT,
        );
        page.svg
            .text(at, "No suspects: no effect promises to take anything away.");
        page.y += 30.0;
        return page.finish();
    }
    let names = figure.suspects.iter();
    let widest = names
        .map(|s| text::width(s.name, style::LABEL_SIZE))
        .fold(60.0, f64::max)
        .min(250.0);
    let left = style::PAGE_MARGIN + widest + 12.0;
    let percent = 50.0;
    let width = style::PAGE_WIDTH - style::PAGE_MARGIN - percent - left;
    let top = page.y + 10.0;
    let mut y = top;
    let mut rows = Vec::new();
    for suspect in figure.suspects {
        let room = width + percent;
        let lines = text::wrap(suspect.evidence, style::NOTE_SIZE, room, 2);
        let height = 24.0 + 13.0 * lines.len() as f64;
        rows.push((suspect, lines, y));
        y += height + 6.0;
    }
    let bottom = y;
    let mut grid = Path::default();
    for quarter in 0..=4 {
        let x = left + width * f64::from(quarter) / 4.0;
        grid.move_to(x, top - 4.0);
        grid.line_to(x, bottom);
        let at = Text::new(x, bottom + 14.0, style::TICK_SIZE, style::TEXT);
        let label = format!("{}", quarter * 25);
        page.svg.text(at.anchor(Anchor::Middle), &label);
    }
    page.svg.path(&grid, Stroke::solid(style::GRID, 1.0));
    for (suspect, lines, y) in rows {
        let probability = if suspect.probability.is_finite() {
            suspect.probability.clamp(0.0, 1.0)
        } else {
            0.0
        };
        page.svg.begin_series("suspect", suspect.name);
        let name = text::shorten(suspect.name, style::LABEL_SIZE, widest);
        let at = Text::new(left - 8.0, y + 13.0, style::LABEL_SIZE, style::TEXT);
        page.svg.text(at.anchor(Anchor::End), &name);
        let bar = width * probability;
        page.svg
            .rect(left, y + 2.0, bar, 15.0, LineRole::Model.color());
        let right = style::PAGE_WIDTH - style::PAGE_MARGIN;
        let at = Text::new(right, y + 13.5, style::LABEL_SIZE, style::TEXT).bold();
        page.svg
            .text(at.anchor(Anchor::End), &percent_label(suspect.probability));
        for (index, line) in lines.iter().enumerate() {
            let baseline = y + 28.0 + 13.0 * index as f64;
            let text_width = text::width(line, style::NOTE_SIZE);
            // Grid lines must not run through the words.
            page.svg
                .rect(left + 1.0, baseline - 9.5, text_width, 12.5, "#FFFFFF");
            let at = Text::new(left + 2.0, baseline, style::NOTE_SIZE, style::TEXT_MUTED);
            page.svg.text(at, line);
        }
        page.svg.end();
    }
    let axis = Stroke::solid(style::AXIS, 1.0);
    page.svg.line((left, top - 4.0), (left, bottom), axis);
    let at = Text::new(
        left + width / 2.0,
        bottom + 30.0,
        style::LABEL_SIZE,
        style::TEXT,
    );
    page.svg
        .text(at.anchor(Anchor::Middle), "probability of the effect (%)");
    page.y = bottom + 36.0;
    page.finish()
}

/// A probability in percent. Values below 0.5 and above 99.5 are given as bounds, because no effect is certain or
/// impossible.
fn percent_label(probability: f64) -> String {
    let percent = probability * 100.0;
    match percent {
        p if !p.is_finite() => "–".into(),
        p if p < 0.5 => "<1 %".into(),
        p if p > 99.5 => ">99 %".into(),
        p => format!("{p:.0} %"),
    }
}
