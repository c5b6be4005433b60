//! Text that stands in columns, and numbers with what they count.

use std::borrow::Cow;
use std::fmt::Write;

/// Names come from files and from what was typed: what they hold of control characters would work on a terminal and make a
/// plot unreadable, so each but line ends and tabs becomes the character that stands for what cannot be shown.
pub(crate) fn printable(text: &str) -> Cow<'_, str> {
    // What changes the direction of writing or takes no room would let a name look like another.
    let is_format = |c: char| matches!(c, '\u{61c}' | '\u{200b}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}');
    let is_hidden = |c: char| is_format(c) || c.is_control() && !matches!(c, '\n' | '\t');
    if !text.contains(is_hidden) {
        return text.into();
    }
    text.replace(is_hidden, "\u{fffd}").into()
}

/// Columns of equal width: words to the left, what begins with a digit to the right. Rows are as long as the first.
pub(super) fn aligned<R: AsRef<[String]>>(heads: &R, rows: &[R]) -> String {
    let lines = || [heads].into_iter().chain(rows).map(AsRef::as_ref);
    let is_digit = |c: char| c.is_ascii_digit() || c == '+' || c == '-';
    let columns: Vec<(usize, bool)> = (0..heads.as_ref().len())
        .map(|column| {
            let width = lines().map(|row| row[column].chars().count()).max().unwrap_or(0);
            (width, rows.iter().any(|row| row.as_ref()[column].starts_with(is_digit)))
        })
        .collect();
    let mut text = String::new();
    for row in lines() {
        let mut line = String::new();
        for (cell, &(width, is_number)) in row.iter().zip(&columns) {
            // Writing to a string cannot fail.
            let _ =
                if is_number { write!(line, "{cell:>width$}  ") } else { write!(line, "{cell:<width$}  ") };
        }
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}

/// Such as `1 ray` and `2 rays`.
pub(crate) fn counted(count: u64, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// Such as `once` and `2 times`.
pub(crate) fn times(count: u32) -> String {
    if count == 1 { "once".to_owned() } else { format!("{count} times") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_not_printed() {
        assert_eq!(printable("red \u{1b}[31m\ttext\r\n\u{9b}"), "red \u{fffd}[31m\ttext\u{fffd}\n\u{fffd}");
        assert_eq!(printable("lamp\u{202e}jbo"), "lamp\u{fffd}jbo");
        assert!(matches!(printable("Stühle\n"), Cow::Borrowed(_)));
    }

    #[test]
    fn one_is_singular() {
        let all = [0, 1, 2].map(|count| counted(count, "ray"));
        assert_eq!(all, ["0 rays", "1 ray", "2 rays"]);
        assert_eq!([times(1), times(3)], ["once", "3 times"]);
    }

    #[test]
    fn numbers_stand_to_the_right_and_words_to_the_left() {
        let row = |cells: [&str; 2]| cells.map(str::to_owned);
        let text = aligned(&row(["name", "n"]), &[row(["a", "1"]), row(["lamp", "12"])]);
        assert_eq!(text, "name   n\na      1\nlamp  12\n");
    }
}
