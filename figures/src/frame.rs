//! One panel: a rectangle with two axes, and drawing in the units of the axes.

use crate::annotation::Quantity;
use crate::axis::{Axis, Spacing};
use crate::decimate;
use crate::style::{self, LineRole};
use crate::svg::{Anchor, Path, Stroke, Svg, Text};
use crate::text;

/// A rectangle on the page (pixels) and the axes that span it.
#[derive(Debug, Clone)]
pub(crate) struct Frame {
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
    pub x: Axis,
    pub y: Axis,
}

/// Distance in pixels from a panel up to the baseline of its caption. The label of a tick at the upper end stays clear
/// of the caption.
pub(crate) const CAPTION_GAP: f64 = 10.0;
/// Room above a panel for its caption.
pub(crate) const CAPTION: f64 = 28.0;

/// Suitable number of ticks on a horizontal axis of this length.
pub(crate) fn x_ticks(width: f64) -> f64 {
    (width / 85.0).max(2.0)
}

/// Suitable number of ticks on a vertical axis of this length.
pub(crate) fn y_ticks(height: f64) -> f64 {
    (height / 30.0).clamp(3.0, 10.0)
}

/// Up to this many dots are drawn individually; more are merged on a grid,
/// which keeps files small. 5,000 dots take about 60 kB.
const MOST_EXACT_DOTS: usize = 5_000;

/// Space that the labels of a vertical axis need on its left.
pub(crate) fn gutter(axis: &Axis) -> f64 {
    let widest = axis.labels.iter().map(|l| text::width(l, style::TICK_SIZE));
    widest.fold(14.0, f64::max) + 8.0
}

impl Frame {
    pub fn right(&self) -> f64 {
        self.left + self.width
    }

    pub fn bottom(&self) -> f64 {
        self.top + self.height
    }

    /// Horizontal position of a value in pixels.
    pub fn at_x(&self, value: f64) -> Option<f64> {
        Some(self.left + self.x.fraction(value)? * self.width)
    }

    /// Vertical position of a value in pixels.
    pub fn at_y(&self, value: f64) -> Option<f64> {
        Some(self.bottom() - self.y.fraction(value)? * self.height)
    }

    pub fn at(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        let finite = x.is_finite() && y.is_finite();
        finite.then_some(())?;
        Some((self.at_x(x)?, self.at_y(y)?))
    }

    /// Grid lines at the ticks of the vertical and, if `vertical`, of the
    /// horizontal axis.
    pub fn grid(&self, svg: &mut Svg, vertical: bool) {
        let stroke = Stroke::solid(style::GRID, 1.0);
        let mut path = Path::default();
        for y in self.y.ticks.iter().filter_map(|t| self.at_y(*t)) {
            path.move_to(self.left, y);
            path.line_to(self.right(), y);
        }
        if vertical {
            for x in self.x.ticks.iter().filter_map(|t| self.at_x(*t)) {
                path.move_to(x, self.top);
                path.line_to(x, self.bottom());
            }
        }
        svg.path(&path, stroke);
    }

    /// The line of zero, where the axis has one.
    pub fn zero_line(&self, svg: &mut Svg) {
        let has_zero = self.y.spacing == Spacing::Linear && self.y.lo < 0.0 && self.y.hi > 0.0;
        if let (true, Some(y)) = (has_zero, self.at_y(0.0)) {
            let stroke = Stroke::solid("#B5B5B5", 1.0);
            svg.line((self.left, y), (self.right(), y), stroke);
        }
    }

    /// The two lines at the left and at the bottom.
    pub fn border(&self, svg: &mut Svg) {
        let mut path = Path::default();
        path.move_to(self.left, self.top);
        path.line_to(self.left, self.bottom());
        path.line_to(self.right(), self.bottom());
        svg.path(&path, Stroke::solid(style::AXIS, 1.0));
    }

    pub fn y_labels(&self, svg: &mut Svg) {
        for (tick, label) in self.y.ticks.iter().zip(&self.y.labels) {
            if let Some(y) = self.at_y(*tick) {
                let at = Text::new(self.left - 6.0, y + 3.8, style::TICK_SIZE, style::TEXT);
                svg.text(at.anchor(Anchor::End), label);
            }
        }
    }

    /// Tick labels below the panel; takes 18 pixels.
    pub fn x_labels(&self, svg: &mut Svg) {
        let mut free_from = f64::NEG_INFINITY;
        for (tick, label) in self.x.ticks.iter().zip(&self.x.labels) {
            let Some(x) = self.at_x(*tick) else { continue };
            let bottom = self.bottom();
            let stroke = Stroke::solid(style::AXIS, 1.0);
            svg.line((x, bottom), (x, bottom + 4.0), stroke);
            let half = text::width(label, style::TICK_SIZE) / 2.0;
            if x - half < free_from {
                continue;
            }
            free_from = x + half + 4.0;
            let at = Text::new(x, bottom + 16.0, style::TICK_SIZE, style::TEXT);
            svg.text(at.anchor(Anchor::Middle), label);
        }
    }

    /// Name and unit of the horizontal axis below its tick labels; the panel
    /// with both takes 36 pixels more than its height.
    pub fn x_caption(&self, svg: &mut Svg, quantity: Quantity) {
        let caption = self.x.caption(quantity);
        let caption = text::shorten(&caption, style::LABEL_SIZE, self.width + 40.0);
        let x = self.left + self.width / 2.0;
        let at = Text::new(x, self.bottom() + 32.0, style::LABEL_SIZE, style::TEXT);
        svg.text(at.anchor(Anchor::Middle), &caption);
    }

    /// Name and unit of the vertical axis above its upper end, beginning at
    /// `left`; returns the width that it takes.
    pub fn y_caption(&self, svg: &mut Svg, left: f64, quantity: Quantity) -> f64 {
        self.y_caption_at(svg, left, self.top - CAPTION_GAP, quantity)
    }

    /// Name and unit of the vertical axis with the baseline at `y`; returns the width that it takes.
    pub fn y_caption_at(&self, svg: &mut Svg, left: f64, y: f64, quantity: Quantity) -> f64 {
        let caption = self.y.caption(quantity);
        let room = self.right() - left;
        let caption = text::shorten(&caption, style::LABEL_SIZE, room);
        let at = Text::new(left, y, style::LABEL_SIZE, style::TEXT);
        svg.text(at, &caption);
        text::width(&caption, style::LABEL_SIZE)
    }

    /// A horizontal band of values, cut at the panel.
    pub fn band(&self, svg: &mut Svg, from: f64, until: f64, fill: &str) {
        if let (Some(a), Some(b)) = (self.at_y(until), self.at_y(from)) {
            let (a, b) = (a.max(self.top), b.min(self.bottom()));
            if b > a {
                svg.rect(self.left, a, self.width, b - a, fill);
            }
        }
    }

    /// A vertical stripe of values, cut at the panel, at least a pixel wide.
    pub fn stripe(&self, svg: &mut Svg, from: f64, until: f64, fill: &str) {
        if let (Some(a), Some(b)) = (self.at_x(from), self.at_x(until)) {
            let (a, b) = (a.max(self.left), b.max(a + 1.0).min(self.right()));
            if b > a {
                svg.rect(a, self.top, b - a, self.height, fill);
            }
        }
    }

    /// Clips at the panel until `svg.end()`. Half a line width of room remains above and below.
    pub fn begin_clip(&self, svg: &mut Svg) {
        let room = 2.0;
        svg.begin_clip(
            self.left,
            self.top - room,
            self.width,
            self.height + 2.0 * room,
        );
    }

    /// A line through the points; a value that is not finite leaves a gap, a
    /// lone point is a dot. Returns whether points were left out because
    /// several share a pixel column.
    pub fn line(&self, svg: &mut Svg, xs: &[f64], ys: &[f64], stroke: Stroke) -> bool {
        let mut path = Path::default();
        let mut reduced = false;
        let mut run: Vec<(f64, f64)> = Vec::new();
        let ends = std::iter::once((f64::NAN, f64::NAN));
        for (x, y) in xs.iter().copied().zip(ys.iter().copied()).chain(ends) {
            if let Some(point) = self.at(x, y) {
                run.push(point);
                continue;
            }
            for visible in self.visible(&run) {
                let kept = decimate::decimate(visible);
                reduced |= kept.len() < visible.len();
                for (i, point) in kept.iter().enumerate() {
                    if i == 0 {
                        path.move_to(point.0, point.1);
                    } else {
                        path.line_to(point.0, point.1);
                    }
                }
            }
            run.clear();
        }
        path.close_dot();
        svg.path(&path, stroke);
        reduced
    }

    /// The stretches of a line, in pixels, that touch the panel. The rest of a long series is left out of the file.
    fn visible<'a>(&self, run: &'a [(f64, f64)]) -> impl Iterator<Item = &'a [(f64, f64)]> {
        let (left, right) = (self.left - 1.0, self.right() + 1.0);
        let apart = move |a: &(f64, f64), b: &(f64, f64)| {
            (a.0 < left && b.0 < left) || (a.0 > right && b.0 > right)
        };
        run.chunk_by(move |a, b| !apart(a, b))
            .filter(move |part| part.len() > 1 || !apart(&part[0], &part[0]))
    }

    /// A dot of `diameter` pixels at each finite point inside the panel; where
    /// there are thousands, dots that touch are merged.
    pub fn dots(
        &self,
        svg: &mut Svg,
        points: impl IntoIterator<Item = (f64, f64)>,
        diameter: f64,
        color: &str,
    ) {
        let inside: Vec<(f64, f64)> = points
            .into_iter()
            .filter_map(|(x, y)| self.at(x, y))
            .filter(|(x, y)| {
                (self.left - 1.0..=self.right() + 1.0).contains(x)
                    && (self.top - 1.0..=self.bottom() + 1.0).contains(y)
            })
            .collect();
        let mut path = Path::default();
        if inside.len() <= MOST_EXACT_DOTS {
            for (x, y) in inside {
                path.move_to(x, y);
            }
        } else {
            for (from, until, y) in decimate::merge_dots(&inside, (diameter * 0.7).max(1.0)) {
                path.move_to(from, y);
                path.line_to(until, y);
            }
        }
        path.close_dot();
        svg.path(&path, Stroke::solid(color, diameter));
    }

    /// A dot with a bar from `low` to `high`.
    pub fn error_bar(&self, svg: &mut Svg, x: f64, y: f64, low: f64, high: f64, role: LineRole) {
        let Some((px, py)) = self.at(x, y) else {
            return;
        };
        let color = role.color();
        if let (Some((_, a)), Some((_, b))) = (self.at(x, low), self.at(x, high)) {
            let mut path = Path::default();
            path.move_to(px, a);
            path.line_to(px, b);
            path.move_to(px - 3.0, a);
            path.line_to(px + 3.0, a);
            path.move_to(px - 3.0, b);
            path.line_to(px + 3.0, b);
            svg.path(&path, Stroke::solid(color, 1.2));
        }
        svg.circle((px, py), 3.0, color, Stroke::solid("#FFFFFF", 0.6));
    }
}
