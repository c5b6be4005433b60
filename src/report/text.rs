//! Text that stands in columns.

use std::fmt::Write;

/// Columns of equal width: words to the left, what holds a digit to the right.
pub(super) fn aligned<const N: usize>(heads: &[String; N], rows: &[[String; N]]) -> String {
    let widths: [usize; N] = std::array::from_fn(|column| {
        let cells = rows.iter().chain([heads]).map(|row| row[column].chars().count());
        cells.max().unwrap_or(0)
    });
    let is_number: [bool; N] = std::array::from_fn(|column| {
        rows.iter().any(|row| row[column].starts_with(|c: char| c.is_ascii_digit() || c == '+' || c == '-'))
    });
    let mut text = String::new();
    for row in [heads].into_iter().chain(rows) {
        let mut line = String::new();
        for ((cell, width), is_number) in row.iter().zip(widths).zip(is_number) {
            // Writing to a string cannot fail.
            let _ =
                if is_number { write!(line, "{cell:>width$}  ") } else { write!(line, "{cell:<width$}  ") };
        }
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}
