//! A page: title, legend, panels from top to bottom, notes at the foot.

use crate::style::{self, LineRole};
use crate::svg::{Anchor, Path, Stroke, Svg, Text};
use crate::text;

/// The drawing of an entry of the legend.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Mark {
    Line {
        color: &'static str,
        width: f64,
    },
    Dashed {
        color: &'static str,
    },
    Band {
        fill: &'static str,
        edge: &'static str,
    },
    Dot {
        color: &'static str,
    },
    Ring {
        color: &'static str,
    },
    Cross {
        color: &'static str,
    },
    Patch {
        color: &'static str,
    },
}

/// An entry of the legend.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Key {
    pub mark: Mark,
    pub name: String,
}

impl Key {
    pub fn new(mark: Mark, name: impl Into<String>) -> Key {
        Key {
            mark,
            name: name.into(),
        }
    }

    pub fn line(role: LineRole, name: &str) -> Key {
        let mark = Mark::Line {
            color: role.color(),
            width: role.line_width().max(1.6),
        };
        Key::new(mark, name)
    }
}

/// A page under construction. `y` is the height down to which it is filled.
#[derive(Debug)]
pub(crate) struct Page {
    pub svg: Svg,
    pub y: f64,
    title: String,
    notes: Vec<String>,
}

/// The note at the foot if points of a long series share a pixel.
pub(crate) const REDUCED: &str = "Long series are drawn with the first, lowest, highest and last value of each \
                                  pixel column; no peak is lost.";

/// The widest that a line of text may be.
const TEXT_WIDTH: f64 = style::PAGE_WIDTH - 2.0 * style::PAGE_MARGIN;

impl Page {
    pub fn new(title: &str, subtitle: &str) -> Page {
        let mut page = Page {
            svg: Svg::default(),
            y: style::PAGE_MARGIN,
            title: title.to_owned(),
            notes: Vec::new(),
        };
        // Bold letters are wider than the estimate by about a tenth.
        for line in text::wrap(title, style::TITLE_SIZE * 1.1, TEXT_WIDTH, 3) {
            page.y += style::TITLE_SIZE + 2.0;
            let at = Text::new(
                style::PAGE_MARGIN,
                page.y - 4.0,
                style::TITLE_SIZE,
                style::TEXT,
            );
            page.svg.text(at.bold(), &line);
        }
        for line in text::wrap(subtitle, style::LABEL_SIZE, TEXT_WIDTH, 4) {
            page.y += style::LABEL_SIZE + 4.0;
            let at = Text::new(
                style::PAGE_MARGIN,
                page.y - 2.0,
                style::LABEL_SIZE,
                style::TEXT_MUTED,
            );
            page.svg.text(at, &line);
        }
        page.y += 4.0;
        page
    }

    /// Draws the legend as rows above the panels, where it hides nothing.
    pub fn legend(&mut self, keys: &[Key]) {
        const MARK: f64 = 24.0;
        const GAP: f64 = 20.0;
        let mut x = style::PAGE_MARGIN;
        let mut drawn: Vec<&Key> = Vec::new();
        for key in keys {
            if drawn.contains(&key) || key.name.is_empty() {
                continue;
            }
            let name = text::shorten(&key.name, style::LABEL_SIZE, TEXT_WIDTH - MARK - 6.0);
            let width = MARK + 6.0 + text::width(&name, style::LABEL_SIZE);
            if drawn.is_empty() {
                self.y += 20.0;
            } else if x + width > style::PAGE_WIDTH - style::PAGE_MARGIN {
                x = style::PAGE_MARGIN;
                self.y += 18.0;
            }
            self.mark(key.mark, x, self.y - 8.0, MARK);
            let at = Text::new(x + MARK + 6.0, self.y - 4.0, style::LABEL_SIZE, style::TEXT);
            self.svg.text(at, &name);
            x += width + GAP;
            drawn.push(key);
        }
        self.y += 4.0;
    }

    fn mark(&mut self, mark: Mark, x: f64, y: f64, width: f64) {
        let middle = (x + width / 2.0, y);
        match mark {
            Mark::Line {
                color,
                width: thickness,
            } => {
                let stroke = Stroke::solid(color, thickness);
                self.svg.line((x, y), (x + width, y), stroke);
            }
            Mark::Dashed { color } => {
                let stroke = Stroke::dashed(color, 1.4);
                self.svg.line((x, y), (x + width, y), stroke);
            }
            Mark::Dot { color } => {
                self.svg
                    .circle(middle, 3.2, color, Stroke::solid(color, 1.0));
            }
            Mark::Ring { color } => {
                self.svg
                    .circle(middle, 3.2, "#FFFFFF", Stroke::solid(color, 1.5));
            }
            Mark::Cross { color } => {
                let path = cross(middle, 4.0);
                self.svg.path(&path, Stroke::solid(color, 1.8));
            }
            Mark::Patch { color } => self.svg.rect(x, y - 5.5, width, 11.0, color),
            Mark::Band { fill, edge } => {
                self.svg.rect(x, y - 5.5, width, 11.0, fill);
                for edge_y in [y - 5.5, y + 5.5] {
                    let stroke = Stroke::solid(edge, 0.8);
                    self.svg.line((x, edge_y), (x + width, edge_y), stroke);
                }
            }
        }
    }

    /// A line of small text at the foot of the page; equal ones appear once.
    pub fn note(&mut self, note: impl Into<String>) {
        let note = note.into();
        if !self.notes.contains(&note) {
            self.notes.push(note);
        }
    }

    pub fn finish(mut self) -> String {
        self.y += 4.0;
        for note in std::mem::take(&mut self.notes) {
            for line in text::wrap(&note, style::NOTE_SIZE, TEXT_WIDTH, 4) {
                self.y += style::NOTE_SIZE + 4.0;
                let at = Text::new(
                    style::PAGE_MARGIN,
                    self.y - 3.0,
                    style::NOTE_SIZE,
                    style::TEXT_MUTED,
                );
                self.svg.text(at, &line);
            }
        }
        let height = self.y + style::PAGE_MARGIN - 6.0;
        self.svg.finish(style::PAGE_WIDTH, height, &self.title)
    }
}

/// The two strokes of a diagonal cross.
pub(crate) fn cross((x, y): (f64, f64), size: f64) -> Path {
    let mut path = Path::default();
    path.move_to(x - size, y - size);
    path.line_to(x + size, y + size);
    path.move_to(x - size, y + size);
    path.line_to(x + size, y - size);
    path
}

/// Heights for labels that want to stand at `wanted` but must be `gap` apart
/// and within `top..bottom`; the order of `wanted` is kept. Where they cannot
/// all fit, they are spread evenly.
pub(crate) fn spread(wanted: &[f64], gap: f64, top: f64, bottom: f64) -> Vec<f64> {
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    order.sort_by(|a, b| wanted[*a].total_cmp(&wanted[*b]));
    let room = (bottom - top) / (wanted.len().max(2) - 1) as f64;
    let gap = gap.min(room);
    let mut placed = vec![0.0; wanted.len()];
    let mut least = top;
    for &i in &order {
        placed[i] = wanted[i].clamp(least, f64::max(least, bottom));
        least = placed[i] + gap;
    }
    let mut most = bottom;
    for &i in order.iter().rev() {
        placed[i] = placed[i].min(most);
        most = placed[i] - gap;
    }
    placed
}

/// Rows of labels above a panel such that none overlap: for each label (middle,
/// width) its row and left edge, or None where `rows` are not enough.
pub(crate) fn lanes(
    labels: &[(f64, f64)],
    left: f64,
    right: f64,
    rows: usize,
) -> Vec<Option<(usize, f64)>> {
    let mut order: Vec<usize> = (0..labels.len()).collect();
    order.sort_by(|a, b| labels[*a].0.total_cmp(&labels[*b].0));
    let mut filled = vec![f64::NEG_INFINITY; rows];
    let mut places = vec![None; labels.len()];
    for index in order {
        let (middle, width) = labels[index];
        let start = (middle - width / 2.0).min(right - width).max(left);
        if let Some(row) = filled.iter().position(|end| *end + 8.0 <= start) {
            filled[row] = start + width;
            places[index] = Some((row, start));
        }
    }
    places
}

/// Text that ends at `right`, shortened to `max_width` pixels.
pub(crate) fn right_note(svg: &mut Svg, right: f64, baseline: f64, max_width: f64, note: &str) {
    let note = text::shorten(note, style::NOTE_SIZE, max_width);
    let at = Text::new(right, baseline, style::NOTE_SIZE, style::TEXT_MUTED);
    svg.text(at.anchor(Anchor::End), &note);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn spread_labels_keep_apart_and_inside(
            wanted in prop::collection::vec(0.0..400.0f64, 1..25),
        ) {
            let mut placed = spread(&wanted, 13.0, 10.0, 390.0);
            prop_assert!(placed.iter().all(|y| (10.0 - 1e-6..=390.0 + 1e-6).contains(y)));
            placed.sort_by(f64::total_cmp);
            for pair in placed.windows(2) {
                prop_assert!(pair[1] - pair[0] >= 13.0 - 1e-6);
            }
        }

        #[test]
        fn lane_labels_do_not_overlap(
            labels in prop::collection::vec((0.0..800.0f64, 10.0..200.0f64), 1..30),
        ) {
            let places = lanes(&labels, 0.0, 800.0, 3);
            for i in 0..labels.len() {
                let Some((row, start)) = places[i] else { continue };
                prop_assert!(start >= 0.0 && start + labels[i].1 <= 800.0 + 1e-9);
                for j in 0..i {
                    let Some((other_row, other)) = places[j] else { continue };
                    prop_assert!(row != other_row
                        || other + labels[j].1 <= start
                        || start + labels[i].1 <= other);
                }
            }
        }
    }
}
