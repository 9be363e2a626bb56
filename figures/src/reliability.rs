//! Figure: stated probabilities and the frequencies with which they came true.

use crate::annotation::Quantity;
use crate::axis::Axis;
use crate::frame::Frame;
use crate::page::{Key, Mark, Page};
use crate::style::{self, LineRole};
use crate::svg::{Anchor, Path, Stroke, Text};

/// Stated probabilities against frequencies (a calibration curve).
#[derive(Debug, Clone, Copy, Default)]
pub struct Reliability<'a> {
    /// The title: a sentence that says what the figure shows.
    pub title: &'a str,
    /// Details, written below the title; may be empty.
    pub subtitle: &'a str,
    /// The bins.
    pub bins: &'a [ReliabilityBin],
    /// Half width of the band around the diagonal that counts as good, such
    /// as 0.05; zero for no band.
    pub tolerance: f64,
}

/// Statements of about the same probability.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ReliabilityBin {
    /// Mean stated probability, 0 to 1.
    pub stated: f64,
    /// Share of the statements that came true, 0 to 1; NaN for an empty bin.
    pub frequency: f64,
    /// Lower end of the 95 % interval of the frequency.
    pub low: f64,
    /// Upper end of the 95 % interval of the frequency.
    pub high: f64,
    /// Number of statements.
    pub count: usize,
}

/// Draws frequency over stated probability with the diagonal, and below it
/// how many statements each bin holds.
pub fn reliability(figure: &Reliability) -> String {
    let mut page = Page::new(figure.title, figure.subtitle);
    let mut keys = vec![
        Key::new(
            Mark::Dot {
                color: LineRole::Model.color(),
            },
            "frequency with its 95 % interval",
        ),
        Key::new(
            Mark::Dashed {
                color: style::LIMIT,
            },
            "perfectly calibrated",
        ),
    ];
    if figure.tolerance > 0.0 {
        let name = format!("within ±{:.0} points", figure.tolerance * 100.0);
        keys.push(Key::new(Mark::Patch { color: style::BAND }, name));
    }
    page.legend(&keys);
    let size = 420.0;
    let gutter = 44.0;
    let left = (style::PAGE_WIDTH - size - gutter) / 2.0;
    let percent = || Axis::linear(Some((0.0, 100.0)), 0.02, 6.0);
    let main = Frame {
        left: left + gutter,
        top: page.y + 28.0,
        width: size,
        height: size,
        x: percent(),
        y: percent(),
    };
    draw_curve(&mut page, &main, figure);
    main.y_caption(
        &mut page.svg,
        left,
        Quantity {
            name: "how often it was true",
            unit: "%",
        },
    );
    let most = figure.bins.iter().map(|b| b.count).max().unwrap_or(0);
    let counts = Frame {
        top: main.bottom() + 34.0,
        height: 60.0,
        y: Axis::linear(Some((0.0, (most.max(1)) as f64)), 0.0, 3.0),
        ..main.clone()
    };
    counts.grid(&mut page.svg, false);
    for bin in figure.bins {
        if let Some((x, y)) = counts.at(bin.stated * 100.0, bin.count as f64) {
            page.svg
                .rect(x - 7.0, y, 14.0, counts.bottom() - y, "#A9A9A9");
        }
    }
    counts.border(&mut page.svg);
    counts.y_labels(&mut page.svg);
    counts.x_labels(&mut page.svg);
    counts.y_caption(
        &mut page.svg,
        left,
        Quantity {
            name: "number of statements",
            unit: "",
        },
    );
    counts.x_caption(
        &mut page.svg,
        Quantity {
            name: "stated probability",
            unit: "%",
        },
    );
    page.y = counts.bottom() + 38.0;
    page.finish()
}

fn draw_curve(page: &mut Page, frame: &Frame, figure: &Reliability) {
    if figure.tolerance > 0.0 {
        let half = figure.tolerance * 100.0;
        let corners = [
            (0.0, half),
            (100.0, 100.0 + half),
            (100.0, 100.0 - half),
            (0.0, -half),
        ];
        let mut path = Path::default();
        for (i, (x, y)) in corners.into_iter().enumerate() {
            if let Some((x, y)) = frame.at(x, y) {
                if i == 0 {
                    path.move_to(x, y);
                } else {
                    path.line_to(x, y);
                }
            }
        }
        path.close();
        frame.begin_clip(&mut page.svg);
        page.svg.area(&path, style::BAND);
        page.svg.end();
    }
    frame.grid(&mut page.svg, true);
    if let (Some(from), Some(to)) = (frame.at(0.0, 0.0), frame.at(100.0, 100.0)) {
        page.svg.line(from, to, Stroke::dashed(style::LIMIT, 1.4));
    }
    page.svg.begin_series("frequency", "frequency");
    let filled = figure.bins.iter().filter(|bin| bin.frequency.is_finite());
    let (xs, ys): (Vec<f64>, Vec<f64>) = filled
        .clone()
        .map(|b| (b.stated * 100.0, b.frequency * 100.0))
        .unzip();
    let stroke = Stroke::solid(LineRole::Model.color(), 1.4);
    frame.line(&mut page.svg, &xs, &ys, stroke);
    for bin in filled {
        frame.error_bar(
            &mut page.svg,
            bin.stated * 100.0,
            bin.frequency * 100.0,
            bin.low * 100.0,
            bin.high * 100.0,
            LineRole::Model,
        );
    }
    page.svg.end();
    if figure.bins.iter().all(|bin| !bin.frequency.is_finite()) {
        let (x, y) = (
            frame.left + frame.width / 2.0,
            frame.top + frame.height / 2.0,
        );
        let at = Text::new(x, y, style::LABEL_SIZE, style::TEXT_MUTED);
        page.svg.text(at.anchor(Anchor::Middle), "no statements");
    }
    frame.border(&mut page.svg);
    frame.y_labels(&mut page.svg);
}
