//! A picture in linear radiance, before anything is done for a screen.

/// Linear RGB radiance (Rec. 709), W/(m²·sr), one value per pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width × height` pixels, row by row, top row first.
    pub pixels: Vec<[f32; 3]>,
}

impl Picture {
    /// A black picture.
    pub fn black(width: u32, height: u32) -> Self {
        Self { width, height, pixels: vec![[0.0; 3]; width as usize * height as usize] }
    }

    /// Whether there is one pixel for each place.
    pub fn is_consistent(&self) -> bool {
        self.width > 0 && self.height > 0 && self.pixels.len() == self.width as usize * self.height as usize
    }
}

/// Luminance of a linear RGB value (Rec. 709), in the units of the value.
pub fn luminance(rgb: [f32; 3]) -> f32 {
    0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]
}
