//! Names of files with a place for what differs between pictures: `%d` or `%04d` for a number, `%s` for a name.

use std::path::{Path, PathBuf};

/// A file's name in parts, and the folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::cli) struct Pattern {
    folder: PathBuf,
    before: String,
    place: Place,
    after: String,
}

/// What stands in the place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::cli) enum Place {
    /// A number of at least so many digits.
    Number(usize),
    /// A name.
    Name,
}

/// Most digits that can be asked for.
const MOST_DIGITS: usize = 9;

impl Pattern {
    /// Reads a name such as `frames/%04d.png`; `%%` is a percent sign.
    ///
    /// # Errors
    /// What is wrong with it.
    pub(in crate::cli) fn of(path: &Path) -> Result<Pattern, String> {
        let name = path.file_name().and_then(|name| name.to_str()).ok_or("the name is no text")?;
        let mut parts = [String::new(), String::new()];
        let mut place = None;
        let mut rest = name;
        while let Some(at) = rest.find('%') {
            parts[usize::from(place.is_some())] += &rest[..at];
            rest = &rest[at + 1..];
            if let Some(after) = rest.strip_prefix('%') {
                parts[usize::from(place.is_some())].push('%');
                rest = after;
                continue;
            }
            let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
            let (digits, kind) = rest.split_at(end);
            let found = match (digits, kind.chars().next()) {
                ("", Some('s')) => Place::Name,
                ("", Some('d')) => Place::Number(1),
                (digits, Some('d')) if digits.starts_with('0') && digits.len() > 1 => {
                    let digits = digits.parse().ok().filter(|digits| (1..=MOST_DIGITS).contains(digits));
                    Place::Number(digits.ok_or(format!("a number has at most {MOST_DIGITS} digits"))?)
                }
                _ => return Err("% stands before d, 04d, s or another % only".to_owned()),
            };
            if place.replace(found).is_some() {
                return Err("there are two places".to_owned());
            }
            rest = &kind[1..];
        }
        parts[usize::from(place.is_some())] += rest;
        let [before, after] = parts;
        let place = place.ok_or("there is no place")?;
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        Ok(Pattern { folder, before, place, after })
    }

    pub(in crate::cli) fn place(&self) -> Place {
        self.place
    }

    /// The folder of all files; empty for the current one.
    pub(in crate::cli) fn folder(&self) -> &Path {
        &self.folder
    }

    /// The path of the picture with this number and name.
    pub(in crate::cli) fn filled(&self, number: usize, name: &str) -> PathBuf {
        let (before, after) = (&self.before, &self.after);
        self.folder.join(match self.place {
            Place::Number(digits) => format!("{before}{number:0digits$}{after}"),
            Place::Name => format!("{before}{name}{after}"),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_filled() {
        for (name, expected) in [
            ("%d.png", "7.png"),
            ("frames/%04d.png", "frames/0007.png"),
            ("a%02db.exr", "a07b.exr"),
            ("100%%-%s.png", "100%-door.png"),
            ("%s%%%%.png", "door%%.png"),
            ("per%cent/%03d.png", "per%cent/007.png"),
        ] {
            let pattern = Pattern::of(Path::new(name)).unwrap_or_else(|why| panic!("{name}: {why}"));
            assert_eq!(pattern.filled(7, "door"), Path::new(expected), "{name}");
        }
        assert_eq!(
            Pattern::of(Path::new("%02d.png")).expect("valid").filled(12345, ""),
            Path::new("12345.png")
        );
    }

    #[test]
    fn what_has_no_place_or_is_not_clear_is_refused() {
        for (name, word) in [
            ("a.png", "no place"),
            ("a%%.png", "no place"),
            ("%04d/a.png", "no place"),
            ("%d-%d.png", "two places"),
            ("%s-%04d.png", "two places"),
            ("%x.png", "stands before"),
            ("%4d.png", "stands before"),
            ("%0d.png", "stands before"),
            ("%02s.png", "stands before"),
            ("a%", "stands before"),
            ("%099d.png", "digits"),
            ("%00d.png", "digits"),
            ("%099999999999999999999999d.png", "digits"),
            ("..", "no text"),
        ] {
            match Pattern::of(Path::new(name)) {
                Err(why) => assert!(why.contains(word), "{name}: {why}"),
                Ok(pattern) => panic!("{name} became {pattern:?}"),
            }
        }
    }
}
