//! The legend of a figure.

use plotters::prelude::*;

use super::{Area, Drawn, Figure, GUIDE, INK, color, draw_dashed, draw_marker, text_style};

/// Height of the legend's first line and of each further one, in pixels.
pub(super) const LEGEND: u32 = 34;
const LEGEND_LINE: u32 = 22;

impl Figure {
    /// The legend's entries and their places, line by line.
    pub(super) fn legend(&self, width: i32) -> Vec<(LegendLine<'_>, (i32, i32))> {
        let names = self.names.iter().enumerate().map(|(index, name)| LegendLine { name, sign: Sign::Series(index) });
        let guide = self.guide.iter().map(|guide| LegendLine { name: guide.name, sign: Sign::Guide });
        let has_front = self.panels.iter().any(|panel| !panel.front.is_empty());
        let front = has_front.then_some(LegendLine { name: self.front, sign: Sign::Front });
        let (mut x, mut y) = (24, LEGEND as i32 / 2);
        let place = |entry: LegendLine<'_>| {
            let needed = 66 + 8 * entry.name.chars().count() as i32;
            if x > 24 && x + needed > width {
                (x, y) = (24, y + LEGEND_LINE as i32);
            }
            let place = (x, y);
            x += needed;
            place
        };
        let entries: Vec<_> = names.chain(guide).chain(front).collect();
        let places: Vec<_> = entries.iter().copied().map(place).collect();
        entries.into_iter().zip(places).collect()
    }
}

/// A line of a legend.
#[derive(Debug, Clone, Copy)]
pub(super) struct LegendLine<'a> {
    pub(super) name: &'a str,
    sign: Sign,
}

#[derive(Debug, Clone, Copy)]
enum Sign {
    Series(usize),
    Guide,
    Front,
}

impl LegendLine<'_> {
    pub(super) fn draw(&self, root: &Area<'_>, (x, y): (i32, i32)) -> Drawn {
        let line = [(x, y), (x + 30, y)];
        match self.sign {
            Sign::Series(index) => {
                root.draw(&PathElement::new(line, color(index).stroke_width(2)))?;
                draw_marker(root, (x + 15, y), index)?;
            }
            Sign::Guide => draw_dashed(root, line)?,
            Sign::Front => {
                root.draw(&PathElement::new(line, GUIDE.stroke_width(2)))?;
                root.draw(&Circle::new((x + 15, y), 9, INK.stroke_width(1)))?;
            }
        }
        root.draw(&Text::new(self.name.to_owned(), (x + 38, y), text_style(14)))?;
        Ok(())
    }
}
