//! How what is drawn is told apart: by colour, and filled or hollow.

use plotters::style::RGBColor;

/// Told apart by most people who see few colours, and in print.
pub(super) const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 90, 181),
    RGBColor(220, 50, 32),
    RGBColor(0, 140, 90),
    RGBColor(150, 70, 170),
    RGBColor(200, 130, 0),
    RGBColor(90, 90, 90),
];

/// How a curve or a bar looks, and its entry in a legend.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Look {
    /// Index of its colour.
    pub(super) index: usize,
    /// Bars and marks are outlines, lines have dashes.
    pub(super) is_hollow: bool,
}

impl Look {
    /// Filled, in the colour of this index.
    pub(super) fn filled(index: usize) -> Look {
        Look { index: index % COLOURS.len(), is_hollow: false }
    }

    pub(super) fn colour(self) -> RGBColor {
        COLOURS[self.index]
    }
}
