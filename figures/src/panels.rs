//! Panels on one horizontal axis, from top to bottom.

use crate::annotation::Quantity;
use crate::axis::Axis;
use crate::frame::{self, Frame};
use crate::page::Page;
use crate::style;

/// The positions of the panels on the page, in pixels.
pub(crate) struct Panels {
    left: f64,
    /// Width of each.
    pub width: f64,
    height: f64,
    /// Distance from one panel to the caption of the next.
    gap: f64,
}

impl Panels {
    /// Panels of this height with these vertical axes, whose labels have room on the left, and with this room on the
    /// right.
    pub fn new(y: &[Axis], height: f64, gap: f64, right: f64) -> Panels {
        let gutter = y.iter().map(frame::gutter).fold(0.0, f64::max);
        Panels {
            left: style::PAGE_MARGIN + gutter,
            width: style::PAGE_WIDTH - 2.0 * style::PAGE_MARGIN - gutter - right,
            height,
            gap,
        }
    }

    /// Draws each panel into its frame; the last has the labels and the caption of the horizontal axis below it.
    pub fn draw<'p, P>(
        &self,
        page: &mut Page,
        (x, quantity): (&Axis, Quantity),
        panels: &'p [P],
        y: Vec<Axis>,
        draw: fn(&mut Page, &Frame, &'p P),
    ) {
        for (index, (panel, y)) in panels.iter().zip(y).enumerate() {
            let frame = Frame {
                left: self.left,
                top: page.y + frame::CAPTION,
                width: self.width,
                height: self.height,
                x: x.clone(),
                y,
            };
            draw(page, &frame, panel);
            page.y = frame.bottom() + self.gap;
            if index + 1 == panels.len() {
                frame.x_labels(&mut page.svg);
                frame.x_caption(&mut page.svg, quantity);
                page.y = frame.bottom() + 38.0;
            }
        }
    }
}
