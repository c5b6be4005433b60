//! Files read back as they were written, and nothing else is read.

use super::super::referee::Ruling;
use super::*;
use crate::compare::random_segments;

fn mesh() -> TraceMesh {
    TraceMesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        triangles: vec![[0, 1, 2]],
        first_triangle: vec![0, 1],
        facet_of_triangle: vec![0],
    }
}

fn disagreements() -> Vec<Disagreement> {
    let of = |mut segment: Segment, index: usize| {
        if index == 7 {
            segment.skip = [0, NO_FACET];
            segment.from = Vec3::new(-0.0, 1e-42, 9e8);
        }
        let ray = Ray { origin: segment.from, direction: segment.to };
        let question = if index == 3 { Question::Ray(ray) } else { Question::Segment(segment) };
        let kind = "close beside edges".to_owned();
        let within = match index % 7 {
            0 => Some(vec![Interval { start: 0, end: 1 }]),
            1 => Some(Vec::new()),
            _ => None,
        };
        Disagreement { kind, question, within, answers: [0, NO_FACET], rulings: [Ruling::RIGHT; 2] }
    };
    random_segments(50, 3).into_iter().zip(0..).map(|(segment, index)| of(segment, index)).collect()
}

/// What the reader makes of a file with this content.
fn read(content: impl AsRef<[u8]>) -> Result<Vec<Replayed>, ReplayError> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.replay");
    std::fs::write(&path, content).expect("written");
    ReplayFile::open(&path)?.rays(&mesh())
}

fn written() -> String {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.replay");
    write_replay(&path, &mesh(), &disagreements(), &|_| "why".to_owned()).expect("written");
    std::fs::read_to_string(path).expect("readable")
}

#[test]
fn rays_read_back_to_the_last_bit() {
    let bits = |question: &Question| match question {
        Question::Segment(s) => ([s.from, s.to].map(|p| p.to_array().map(f32::to_bits)), s.skip),
        Question::Ray(r) => ([r.origin, r.direction].map(|p| p.to_array().map(f32::to_bits)), [8; 2]),
    };
    let read = read(written()).expect("a replay file");
    assert_eq!(read.len(), 50);
    for (read, written) in read.iter().zip(disagreements()) {
        assert_eq!(bits(&read.question), bits(&written.question));
        assert_eq!((&read.kind, &read.within), (&written.kind, &written.within));
    }
}

#[test]
fn other_geometry_and_other_versions_are_refused() {
    let mut moved = mesh();
    moved.positions[1].x += 1e-6;
    assert_ne!(fingerprint(&moved), fingerprint(&mesh()));
    let text = written().replace(&fingerprint(&mesh()), &fingerprint(&moved));
    assert!(matches!(read(text), Err(ReplayError::OtherGeometry { .. })));
    let text = written().replace("lightshaft replay 2", "lightshaft replay 3");
    let error = read(text).expect_err("another version");
    assert!(matches!(error, ReplayError::OtherVersion { .. }), "{error}");
    assert!(error.to_string().contains("version 3"), "{error}");
}

#[test]
fn what_is_no_file_of_this_size_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let error = ReplayFile::open(folder.path()).expect_err("a folder");
    assert!(error.to_string().contains("not a regular file"), "{error}");
    let path = folder.path().join("large.replay");
    std::fs::write(&path, written()).expect("written");
    let file = File::options().write(true).open(&path).expect("our own file");
    file.set_len(MOST_BYTES).expect("a file with a hole");
    let error = ReplayFile::open(&path).expect_err("there is nothing in the hole");
    assert!(matches!(error, ReplayError::NotAsWritten { .. }), "as large as can be: {error}");
    file.set_len(MOST_BYTES + 1).expect("a file with a hole");
    let error = ReplayFile::open(&path).expect_err("too large");
    assert!(matches!(error, ReplayError::TooLarge { .. }), "{error}");
}

/// A file with these lines below its head.
fn with_head(body: &str) -> String {
    let (count, sum) = (rays_of(body, 1).count(), crc32fast::hash(body.as_bytes()));
    format!("lightshaft replay 2\ngeometry {}\nrays {count} crc32 {sum:08x}\n{body}", fingerprint(&mesh()))
}

#[test]
fn rays_that_go_nowhere_or_too_far_are_refused() {
    for line in [
        "ray 0 0 0 0 0 0 by hand",
        "ray 0 0 0 1e-13 0 0 by hand",
        "ray 0 0 0 1e38 1e38 1e38 by hand",
        "ray 1e38 0 0 1 0 0 by hand",
        "segment 1 2 3 1 2 3 - - - by hand",
        "segment -3e38 0 0 3e38 0 0 - - - by hand",
    ] {
        let message = read(with_head(&format!("{line}\n"))).expect_err(line).to_string();
        assert!(message.contains(":4: from ") && message.contains("1e-12 to 1e9 far"), "{line}: {message}");
    }
    assert!(read(with_head("ray 0 0 0 0 1e-9 0 by hand\nsegment 0 0 1e4 0 0 0 - - - by hand\n")).is_ok());
}

#[test]
fn a_file_that_is_cut_off_anywhere_or_changed_is_refused() {
    let text = written();
    let head = text.match_indices('\n').nth(HEAD - 1).expect("a head").0;
    for length in (head + 1..text.len()).step_by(37) {
        let error = read(&text[..length]).expect_err("cut off");
        assert!(matches!(error, ReplayError::NotAsWritten { .. }), "{length}: {error}");
    }
    let half = &text[..text.len() / 2];
    let half = &half[..half.rfind('\n').expect("several lines") + 1];
    let message = read(half).expect_err("cut off after a line").to_string();
    assert!(message.contains("50 rays were written, and"), "{message}");
    let changed = text.replacen("e-1", "e-2", 1);
    assert!(read(&changed).expect_err("changed").to_string().contains("checksum"), "{changed}");
    let (first, last) = text.split_at(head);
    let nameless =
        format!("{}rays all of them{last}", &first[..first.rfind("rays").expect("the third line")]);
    assert!(matches!(read(nameless), Err(ReplayError::NotAsWritten { .. })));
}

#[test]
fn lists_that_would_make_the_file_too_large_are_left_away() {
    let list: Vec<Interval> = (0..400_000).map(|i| Interval { start: 9 * i, end: 9 * i + 2 }).collect();
    let mut one = disagreements().swap_remove(0);
    one.within = Some(list);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.replay");
    write_replay(&path, &mesh(), &[one.clone(), one.clone(), one], &|_| "why".to_owned()).expect("written");
    let text = std::fs::read_to_string(&path).expect("readable");
    assert!(text.len() as u64 <= MOST_BYTES && text.contains("\nrays 2 crc32"), "{}", text.len());
    assert!(ReplayFile::open(&path).is_ok());
}

#[test]
fn the_line_that_is_no_ray_is_named() {
    assert_eq!(read(with_head("\n# why\n")).expect("no rays"), []);
    for (bad, part) in [
        ("segment 0 0 0 1 1", "5 numbers"),
        ("segment 0 0 0 1 1 1 - -", "facets"),
        ("segment 0 0 0 1 1 one - - - random", "'one' is no finite number"),
        ("ray 0 0 0 1 1 inf random", "'inf' is no finite number"),
        ("segment 0 0 0 1 1 1 1 - - random", "'1' is no facet"),
        ("segment 0 0 0 1 1 1 - -1 - random", "'-1' is no facet"),
        ("segment 0 0 0 1 1 1 - - 0-1 random", "'0-1' is no list"),
        ("segment 0 0 0 1 1 1 - - 0,0 random", "'0,0' is no list"),
        ("segment 0 0 0 1 1 1 - - random", "'random' is no list"),
        ("segment 0 0 0 1 1 1 - - -", "kind"),
        ("ray 0 0 0 1 1 1", "kind"),
        ("ray 0 0 0 1 1 1 \u{1b}[31mred", "control characters: '\\u{1b}[31mred'"),
        ("line 0 0 0 1 1 1 random", "'line' is neither"),
    ] {
        let body = format!("# why\nsegment 0 0 0 1 1 1 0 - 0 random\n{bad}\n");
        let error = read(with_head(&body)).expect_err(bad);
        assert!(matches!(error, ReplayError::Malformed { line: 6, .. }), "{error}");
        assert!(error.to_string().contains(part), "{error}");
    }
    for (bad, at) in [
        ("", 1),
        ("v 0 0 0", 1),
        ("lightshaft replay 2", 2),
        ("lightshaft replay 2\nx\n", 2),
        ("lightshaft replay 2\ngeometry 0", 3),
    ] {
        let error = read(bad).expect_err(bad);
        assert!(matches!(error, ReplayError::Malformed { line, .. } if line == at), "{error}");
    }
    assert!(matches!(read([0xff, 0xfe, 0]), Err(ReplayError::Malformed { line: 1, .. })));
}
