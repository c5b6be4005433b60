//! Bars as SVG, one below the other, each group under its name: readable in a narrow column too.

use plotters::prelude::*;

use super::look::Look;

/// Bars that belong together.
pub(super) struct Group {
    /// Above them.
    pub(super) name: String,
    /// From top to bottom.
    pub(super) bars: Vec<Bar>,
}

/// One bar, which begins at 0.
pub(super) struct Bar {
    /// How long it is; what is not a finite number of at least 0 has no bar.
    pub(super) value: f64,
    /// Least and most, where it was measured several times.
    pub(super) range: Option<(f64, f64)>,
    /// Behind it: the value with its unit.
    pub(super) text: String,
    pub(super) look: Look,
}

/// Heights of a name, of a bar and of the gap below a group, pixels.
const NAME: i32 = 20;
const BAR: i32 = 18;
const GAP: i32 = 10;

/// Left of the bars, for the line they stand on.
const LEFT: i32 = 2;

/// Size of letters as the library counts it, which is a quarter more than pixels, and about the width of one, pixels.
const FONT: u32 = 16;
const CHARACTER: f64 = 7.5;

/// As SVG of this width, pixels; as high as it has to be.
///
/// # Errors
/// What the library for drawing says.
pub(super) fn svg(groups: &[Group], width: u32) -> Result<String, String> {
    let height: i32 = groups.iter().map(|group| NAME + BAR * group.bars.len() as i32 + GAP).sum();
    let longest = bars(groups).map(|bar| bar.text.chars().count()).max().unwrap_or(0);
    // The texts get what they need, as long as half is left for the bars.
    let room = f64::from(width) - f64::from(LEFT);
    let room = (room - CHARACTER * (longest + 1) as f64).max(0.5 * room);
    let most = bars(groups).flat_map(|bar| [bar.value, bar.range.map_or(0.0, |range| range.1)]);
    let most = most.filter(|value| value.is_finite()).fold(0.0, f64::max);
    let place = |value: f64| {
        let share = if value.is_finite() && most > 0.0 { (value / most).clamp(0.0, 1.0) } else { 0.0 };
        LEFT + (share * room).round() as i32
    };

    let mut text = String::new();
    let area = SVGBackend::with_string(&mut text, (width, height.max(1) as u32)).into_drawing_area();
    let failed = |error: DrawingAreaErrorKind<_>| error.to_string();
    let mut top = 0;
    for group in groups {
        let name = Text::new(group.name.clone(), (0, top + 1), ("sans-serif", FONT));
        area.draw(&name).map_err(failed)?;
        top += NAME;
        let bottom = top + BAR * group.bars.len() as i32;
        for bar in &group.bars {
            let (end, middle) = (place(bar.value), top + BAR / 2);
            let (colour, corners) = (bar.look.colour(), [(LEFT, top + 2), (end, top + BAR - 2)]);
            let rectangle = match bar.look.is_hollow {
                true => Rectangle::new(corners, colour.stroke_width(2)),
                false => Rectangle::new(corners, colour.filled()),
            };
            area.draw(&rectangle).map_err(failed)?;
            let mut after = end;
            if let Some((least, most)) = bar.range.filter(|(least, most)| least < most) {
                let (from, to) = (place(least), place(most));
                for line in [
                    [(from, middle), (to, middle)],
                    [(from, middle - 3), (from, middle + 3)],
                    [(to, middle - 3), (to, middle + 3)],
                ] {
                    area.draw(&PathElement::new(line, BLACK.stroke_width(1))).map_err(failed)?;
                }
                after = after.max(to);
            }
            let value = Text::new(bar.text.clone(), (after + 6, top), ("sans-serif", FONT));
            area.draw(&value).map_err(failed)?;
            top += BAR;
        }
        let axis =
            PathElement::new([(LEFT - 1, bottom - BAR * group.bars.len() as i32), (LEFT - 1, bottom)], BLACK);
        area.draw(&axis).map_err(failed)?;
        top += GAP;
    }
    area.present().map_err(failed)?;
    drop(area);
    Ok(text)
}

fn bars(groups: &[Group]) -> impl Iterator<Item = &Bar> {
    groups.iter().flat_map(|group| &group.bars)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn group(values: &[f64]) -> Group {
        let bar = |&value| Bar { value, range: None, text: format!("{value}"), look: Look::filled(0) };
        Group { name: "a < b & \"c\"".to_owned(), bars: values.iter().map(bar).collect() }
    }

    fn widths(svg: &str) -> Vec<f64> {
        let rectangles = svg.split("<rect ").skip(1);
        let width =
            |text: &str| text.split("width=\"").nth(1).and_then(|rest| rest.split('"').next()?.parse().ok());
        rectangles.map(|text| width(text).expect("a width")).collect()
    }

    #[test]
    fn bars_are_as_long_as_their_values() {
        let found = widths(&svg(&[group(&[1.0, 2.0]), group(&[4.0, 0.0])], 400).expect("drawn"));
        let [a, b, c, d] = found[..] else { panic!("{found:?}") };
        assert!(
            (c / a - 4.0).abs() < 0.05 && (c / b - 2.0).abs() < 0.05 && c > 200.0 && d < 1.5,
            "{found:?}"
        );
    }

    #[test]
    fn what_cannot_be_drawn_has_no_bar_and_keeps_its_text() {
        for values in [&[][..], &[0.0], &[f64::NAN, f64::INFINITY, -3.0], &[f64::MAX, f64::MIN_POSITIVE]] {
            let text = svg(&[group(values)], 360).expect("drawn");
            assert!(text.trim_end().ends_with("</svg>"), "{text}");
            assert!(values.iter().all(|value| text.contains(&format!("{value}"))), "{text}");
            assert!(widths(&text).iter().all(|&width| width <= 360.0), "{text}");
        }
    }

    #[test]
    fn names_are_escaped() {
        let text = svg(&[group(&[1.0])], 360).expect("drawn");
        assert!(text.contains("a &lt; b &amp; ") && !text.contains("a < b"), "{text}");
    }
}
