//! Just enough of a Rust lexer to see code without comments and strings, and the paths in it.

/// A path that starts at `crate::` or at `super::`, as far as its next name.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Use {
    /// Line, from 1.
    pub(crate) line: usize,
    /// The name after it.
    pub(crate) name: String,
    /// How often `super::` was repeated; 0 for `crate::`.
    pub(crate) supers: usize,
}

/// The source with the inside of comments, strings and character literals blanked; lines stay.
pub(crate) fn blank_out(source: &str) -> String {
    let chars: Vec<char> = source.chars().collect();
    let mut code = String::with_capacity(source.len());
    let mut at = 0;
    while at < chars.len() {
        let end = literal_end(&chars, at);
        if end == at {
            code.push(chars[at]);
            at += 1;
        } else {
            code.extend(chars[at..end].iter().map(|&c| if c == '\n' { '\n' } else { ' ' }));
            at = end;
        }
    }
    code
}

/// One past the comment or literal that starts at `at`; `at` when none does.
fn literal_end(chars: &[char], at: usize) -> usize {
    let starts = |text: &str, at: usize| text.chars().enumerate().all(|(i, c)| chars.get(at + i) == Some(&c));
    let find =
        |text: &str, from: usize| (from..chars.len()).find(|&i| starts(text, i)).unwrap_or(chars.len());
    if starts("//", at) {
        return find("\n", at);
    }
    if starts("/*", at) {
        let (mut depth, mut i) = (0, at);
        while i < chars.len() {
            if starts("/*", i) {
                (depth, i) = (depth + 1, i + 2);
            } else if starts("*/", i) {
                (depth, i) = (depth - 1, i + 2);
                if depth == 0 {
                    return i;
                }
            } else {
                i += 1;
            }
        }
        return chars.len();
    }
    let is_in_name = at > 0 && is_name(chars[at - 1]);
    if chars[at] == 'r' && (!is_in_name || chars[at - 1] == 'b') {
        let hashes = chars[at + 1..].iter().take_while(|&&c| c == '#').count();
        if chars.get(at + 1 + hashes) == Some(&'"') {
            let close = format!("\"{}", "#".repeat(hashes));
            return (find(&close, at + 2 + hashes) + close.len()).min(chars.len());
        }
    }
    if chars[at] == '"' {
        return quoted_end(chars, at);
    }
    // 'x' and '\n' are characters, 'a in other places is a lifetime.
    if chars[at] == '\'' && (chars.get(at + 1) == Some(&'\\') || chars.get(at + 2) == Some(&'\'')) {
        return quoted_end(chars, at);
    }
    at
}

/// One past the quote that closes the one at `at`.
fn quoted_end(chars: &[char], at: usize) -> usize {
    let mut i = at + 1;
    while i < chars.len() && chars[i] != chars[at] {
        i += if chars[i] == '\\' { 2 } else { 1 };
    }
    (i + 1).min(chars.len())
}

/// Whether `line` has `word` as a word of its own.
pub(crate) fn has_word(line: &str, word: &str) -> bool {
    line.split(|c: char| !is_name(c)).any(|found| found == word)
}

/// Every path in `code` that starts at the crate or above the module, in order.
pub(crate) fn crate_uses(code: &str) -> Vec<Use> {
    // Paths may be spread over lines; without spaces they are easy to read.
    let chars: Vec<(usize, char)> = code
        .lines()
        .enumerate()
        .flat_map(|(index, line)| line.chars().chain([' ']).map(move |c| (index + 1, c)))
        .collect();
    let mut uses = Vec::new();
    let mut at = 0;
    while at < chars.len() {
        let starts_name = is_name(chars[at].1) && (at == 0 || !is_name(chars[at - 1].1));
        if !starts_name {
            at += 1;
            continue;
        }
        let line = chars[at].0;
        let (first, mut next) = name_at(&chars, at);
        let mut supers = usize::from(first == "super");
        if supers == 0 && first != "crate" {
            at = next;
            continue;
        }
        while let Some(after) = separator_end(&chars, next) {
            let (name, end) = name_at(&chars, after);
            next = end;
            if name == "super" {
                supers += 1;
                continue;
            }
            let names = if chars.get(after).is_some_and(|c| c.1 == '{') {
                names_in_braces(&chars, after)
            } else {
                vec![(line, if name.is_empty() { "*".to_owned() } else { name })]
            };
            uses.extend(names.into_iter().map(|(line, name)| Use { line, name, supers }));
            break;
        }
        at = next.max(at + 1);
    }
    uses
}

/// The name at `at` (perhaps empty) and where it ends.
fn name_at(chars: &[(usize, char)], at: usize) -> (String, usize) {
    let name: String = chars[at.min(chars.len())..].iter().map(|c| c.1).take_while(|&c| is_name(c)).collect();
    let end = at + name.chars().count();
    (name, end)
}

/// Past `::` and the spaces around it, if that is what follows.
fn separator_end(chars: &[(usize, char)], at: usize) -> Option<usize> {
    let skip = |mut i: usize| {
        while chars.get(i).is_some_and(|c| c.1.is_whitespace()) {
            i += 1;
        }
        i
    };
    let colon = skip(at);
    let is_separator = [colon, colon + 1].iter().all(|&i| chars.get(i).is_some_and(|c| c.1 == ':'));
    is_separator.then(|| skip(colon + 2))
}

/// The first names of the entries of `{a::b, c::{d, e}}`: a and c.
fn names_in_braces(chars: &[(usize, char)], open: usize) -> Vec<(usize, String)> {
    let mut names = Vec::new();
    let (mut depth, mut is_expected, mut at) = (0, false, open);
    while at < chars.len() {
        match chars[at].1 {
            '{' => {
                depth += 1;
                is_expected = depth == 1;
            }
            '}' if depth == 1 => break,
            '}' => depth -= 1,
            ',' => is_expected = depth == 1,
            c if is_name(c) => {
                let (name, end) = name_at(chars, at);
                if is_expected {
                    names.push((chars[at].0, name));
                }
                is_expected = false;
                at = end;
                continue;
            }
            _ => {}
        }
        at += 1;
    }
    names
}

fn is_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}
