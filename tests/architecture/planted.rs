//! Breaks every rule on purpose: a check that finds nothing here would find nothing anywhere.

use super::{MOST_LINES, Source, violations};

fn found(path: &str, text: &str) -> Vec<String> {
    violations(&[Source { path: path.to_owned(), text: text.to_owned() }])
}

/// Exactly one violation, at this line, that mentions `part`.
fn expect_one(path: &str, text: &str, line: usize, part: &str) {
    let found = found(path, text);
    let [one] = &found[..] else { panic!("{path}: {text:?} gave {found:?}") };
    assert!(one.starts_with(&format!("{path}:{line}: ")), "{one}");
    assert!(one.contains(part), "'{part}' is not in: {one}");
}

#[test]
fn a_use_of_a_room_below_is_found() {
    expect_one("src/math/plane.rs", "//! Planes.\nuse crate::scene::Scene;\n", 2, "'math' uses 'scene'");
    expect_one("src/progress.rs", "fn f() { crate::math::plane(); }", 1, "'progress' uses 'math'");
    expect_one("src/radiosity/solve.rs", "pub(crate) use crate::report::stats::Stats;", 1, "report");
    expect_one("src/scene/mod.rs", "use crate::{\n  math::Box,\n  shaft::{self, Shaft},\n};", 3, "shaft");
    expect_one("src/scene/mod.rs", "use crate::\n    cli::main;", 1, "cli");
    expect_one("src/scene/obj.rs", "use super::super::tracer::Ray;", 1, "through super");
    expect_one("src/scene/mod.rs", "use super::tracer::Ray;", 1, "through super");
    expect_one("src/scene/mod.rs", "use super::{math, image};", 1, "image");
}

#[test]
fn a_room_or_a_path_that_is_not_in_the_order_is_found() {
    expect_one("src/gpu/mod.rs", "use crate::math::Box;", 1, "'gpu' is no room");
    expect_one("src/image/tone.rs", "use crate::prelude::Box;", 1, "'prelude' is no room");
    expect_one("src/image/tone.rs", "use crate::*;", 1, "'*' is no room");
}

#[test]
fn unsafe_outside_its_places_is_found() {
    let code = "fn f(p: *const u8) -> u8 {\n    unsafe { *p }\n}\n";
    for path in
        ["src/math/fast.rs", "src/tracer/fallback.rs", "src/tracer/embree.rs", "tests/a.rs", "build.rs"]
    {
        expect_one(path, code, 2, "unsafe outside");
    }
    expect_one("src/math/fast.rs", "unsafe impl Send for A {}", 1, "unsafe outside");
    for path in ["src/tracer/embree/scene.rs", "vendor-bindings/src/lib.rs"] {
        assert!(found(path, code).is_empty());
    }
}

#[test]
fn a_long_file_is_found() {
    let long = "// line\n".repeat(MOST_LINES + 1);
    expect_one("src/math/polygon.rs", &long, MOST_LINES, "too many");
    assert!(found("src/math/polygon.rs", &long[8..]).is_empty());
    assert!(found("vendor-bindings/src/bindings.rs", &long).is_empty());
}

#[test]
fn a_name_that_says_nothing_is_found() {
    for path in ["src/math/utils.rs", "src/utils/vector.rs", "tests/helpers/mod.rs", "src/image/manager.rs"] {
        assert!(found(path, "").iter().any(|line| line.contains("says nothing")), "{path}");
    }
}

#[test]
fn what_is_allowed_is_not_found() {
    for (path, text) in [
        ("src/scene/mod.rs", "use crate::math::Box;\nuse crate::scene::obj;\nuse crate::progress::Progress;"),
        ("src/scene/obj.rs", "use super::mesh;\nuse super::super::math::Box;\nuse std::image::X;"),
        ("src/cli/mod.rs", "use crate::{radiosity, report::{stats, cli}};"),
        ("src/lib.rs", "pub mod cli;\npub use crate::cli::main;"),
        ("src/math/mod.rs", "// crate::scene is told of here, unsafe\n/* unsafe /* crate::cli */ unsafe */"),
        (
            "src/math/mod.rs",
            "const A: &str = \"crate::cli \\\" unsafe\";\nconst B: &str = r#\"unsafe \" crate::cli\"#;",
        ),
        ("src/math/mod.rs", "#![deny(unsafe_op_in_unsafe_fn)]\nfn f<'a>(c: &'a char) -> bool { *c == '\"' }"),
        ("src/math/mod.rs", "pub(crate) fn f() {}\npub(super) fn g() {}"),
        ("tests/solver.rs", "use lightshaft::cli;"),
    ] {
        assert_eq!(found(path, text), Vec::<String>::new(), "{path}: {text}");
    }
}

#[test]
fn a_quote_does_not_hide_what_follows() {
    expect_one("src/math/mod.rs", "const Q: char = '\"';\nuse crate::cli;\n", 2, "cli");
    expect_one("src/math/mod.rs", "fn f<'a>(_: &'a str) {}\nuse crate::cli; // '\n", 2, "cli");
    expect_one("src/math/mod.rs", "const Q: &[u8] = br\"\\\";\nuse crate::cli;\n", 2, "cli");
    expect_one("src/math/mod.rs", "const Q: char = '\\'';\nunsafe fn f() {}\n", 2, "unsafe");
}
