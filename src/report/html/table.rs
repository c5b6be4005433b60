//! Tables that sort when a header is pressed.

use maud::{Markup, html};

/// A cell.
pub(super) struct Cell {
    text: String,
    /// What it is sorted by, if it is a number.
    number: Option<f64>,
}

impl Cell {
    /// A number as it is written.
    pub(super) fn number(number: f64, text: String) -> Cell {
        Cell { text, number: Some(number) }
    }

    /// A whole number.
    pub(super) fn count(count: u64) -> Cell {
        Cell::number(count as f64, count.to_string())
    }

    /// Text, a number if it begins with one.
    pub(super) fn read(text: String) -> Cell {
        let number = text.split(' ').next().and_then(|first| first.parse().ok());
        Cell { text, number }
    }

    /// Words.
    pub(super) fn words(text: impl Into<String>) -> Cell {
        Cell { text: text.into(), number: None }
    }
}

/// A number with this many digits after the point.
pub(super) fn decimals(value: f64, digits: usize) -> Cell {
    Cell::number(value, format!("{value:.digits$}"))
}

/// A table under its name; `last` stays at the bottom however the others are sorted.
pub(super) fn table(name: &str, heads: &[String], rows: &[Vec<Cell>], last: Option<&[Cell]>) -> Markup {
    let is_number: Vec<bool> =
        (0..heads.len()).map(|column| rows.iter().any(|row| row[column].number.is_some())).collect();
    let line = |row: &[Cell]| {
        html! {
            tr {
                @for (column, cell) in row.iter().enumerate() {
                    @let value = cell.number.map(|number| number.to_string());
                    @if column == 0 {
                        th.number[is_number[0]] scope="row" data-value=[value] { (cell.text) }
                    } @else {
                        td.number[is_number[column]] data-value=[value] { (cell.text) }
                    }
                }
            }
        }
    };
    html! {
        div.scroll tabindex="0" role="region" aria-label=(name) {
            table.sorts {
                caption { (name) }
                thead {
                    tr {
                        @for (head, is_number) in heads.iter().zip(&is_number) {
                            th.number[*is_number] scope="col" aria-sort="none" { button type="button" { (head) } }
                        }
                    }
                }
                tbody { @for row in rows { (line(row)) } }
                @if let Some(last) = last { tfoot { (line(last)) } }
            }
        }
    }
}
