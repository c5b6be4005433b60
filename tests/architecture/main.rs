//! The rules of the house that a compiler does not know: rooms use only rooms above them, `unsafe`
//! stays in its places, files stay short and have telling names. See `ARCHITECTURE.md`.

mod code;
mod planted;

use std::path::Path;

use code::{Use, blank_out, crate_uses, has_word};

/// The rooms in their order; a room uses only those before it.
const ROOMS: [&str; 18] = [
    "progress",
    "unfinished",
    "memory",
    "math",
    "scene",
    "hierarchy",
    "shaft",
    "tracer",
    "visibility",
    "radiosity",
    "gather",
    "image",
    "export",
    "probe",
    "check",
    "compare",
    "report",
    "cli",
];

/// Where `unsafe` may stand.
const UNSAFE_PLACES: [&str; 2] = ["src/tracer/embree/", "vendor-bindings/"];

/// Declarations written by a program, which may be long.
const GENERATED: [&str; 1] = ["vendor-bindings/src/bindings.rs"];

const MOST_LINES: usize = 600;

/// Names that say nothing about what is inside.
const EMPTY_NAMES: [&str; 9] =
    ["utils", "util", "misc", "helpers", "helper", "manager", "managers", "common", "stuff"];

/// A source file: its path from the package's folder with `/`, and its text.
struct Source {
    path: String,
    text: String,
}

/// Every rule that is broken, one line each: file, line, what is wrong.
fn violations(sources: &[Source]) -> Vec<String> {
    let mut found = Vec::new();
    for Source { path, text } in sources {
        for part in path.trim_end_matches(".rs").split('/') {
            if EMPTY_NAMES.contains(&part) {
                found.push(format!("{path}:1: the name '{part}' says nothing; name it after what it does"));
            }
        }
        let lines = text.lines().count();
        if lines > MOST_LINES && !GENERATED.contains(&path.as_str()) {
            found.push(format!("{path}:{MOST_LINES}: {lines} lines are too many; split at {MOST_LINES}"));
        }
        let code = blank_out(text);
        if !UNSAFE_PLACES.iter().any(|place| path.starts_with(place)) {
            for (index, line) in code.lines().enumerate() {
                if has_word(line, "unsafe") {
                    found.push(format!(
                        "{path}:{}: unsafe outside {}",
                        index + 1,
                        UNSAFE_PLACES.join(" and ")
                    ));
                }
            }
        }
        found.extend(room_violations(path, &code));
    }
    found
}

/// Uses of rooms that are not above the one `path` belongs to.
fn room_violations(path: &str, code: &str) -> Vec<String> {
    let Some(inside) = path.strip_prefix("src/") else { return Vec::new() };
    let Some(room) = inside.split('/').next().map(|part| part.trim_end_matches(".rs")) else {
        return Vec::new();
    };
    if matches!(inside, "lib.rs" | "main.rs") {
        return Vec::new();
    }
    let rank = |name: &str| ROOMS.iter().position(|&known| known == name);
    let Some(own) = rank(room) else {
        return vec![format!("{path}:1: '{room}' is no room; the rooms are {}", ROOMS.join(", "))];
    };
    // `super` leads out of the room when it is repeated as often as the module is deep.
    let parts = inside.trim_end_matches(".rs").trim_end_matches("/mod").split('/').count();
    let mut found = Vec::new();
    for Use { line, name, supers } in crate_uses(code) {
        let wrong = match (supers, rank(&name)) {
            (0, None) => Some(format!("'{name}' is no room")),
            (0, Some(used)) if used > own => Some(format!("'{room}' uses '{name}', which is below it")),
            (n, Some(used)) if n >= parts && used > own => {
                Some(format!("'{room}' uses '{name}' through super, which is below it"))
            }
            _ => None,
        };
        found.extend(wrong.map(|what| format!("{path}:{line}: {what}")));
    }
    found
}

/// All Rust files of the package, by path.
fn sources(package: &Path) -> Vec<Source> {
    let mut sources = Vec::new();
    let mut folders = vec![package.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("a readable folder") {
            let path = entry.expect("a readable entry").path();
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if path.is_dir() {
                if !name.starts_with('.') && name != "target" {
                    folders.push(path);
                }
            } else if name.ends_with(".rs") {
                let inside = path.strip_prefix(package).expect("below the package");
                let text = std::fs::read_to_string(&path).expect("a readable file");
                sources.push(Source { path: inside.to_string_lossy().replace('\\', "/"), text });
            }
        }
    }
    sources.sort_by(|a, b| a.path.cmp(&b.path));
    sources
}

#[test]
fn the_package_keeps_its_rules() {
    let sources = sources(Path::new(env!("CARGO_MANIFEST_DIR")));
    for file in ["src/lib.rs", "src/cli/mod.rs", "src/tracer/mod.rs", "vendor-bindings/src/lib.rs"] {
        assert!(sources.iter().any(|source| source.path == file), "{file} was not looked at");
    }
    let found = violations(&sources);
    assert!(found.is_empty(), "\n{}", found.join("\n"));
}

#[test]
fn the_drawing_of_the_crate_has_the_rooms_in_order() {
    let text = include_str!("../../src/lib.rs");
    let drawn: Vec<&str> = text
        .lines()
        .filter_map(|line| line.strip_prefix("//!"))
        .filter(|line| line.contains('→'))
        .flat_map(|line| line.split('→'))
        .map(str::trim)
        .filter(|name| !name.is_empty())
        .collect();
    assert_eq!(drawn, ROOMS);
}
