//! A solution that was written and read again is the same to the last bit, and a file that is not what was written is
//! refused, whatever is wrong with it.

use std::io::Cursor;
use std::path::Path;

use lightshaft::check::{self, Limits};
use lightshaft::export::{Origin, Quality, SolutionFile, SolutionFileError, write_solution};
use lightshaft::gather::local_pass;
use lightshaft::hierarchy::Hierarchy;
use lightshaft::image::tone::{self, Exposure};
use lightshaft::image::{self, RenderOptions, View};
use lightshaft::math::hash_pair;
use lightshaft::progress::Silent;
use lightshaft::radiosity::{DisplayMesh, Forest, Light, Solution, SolveOptions};
use lightshaft::scene::Camera;
use lightshaft::tracer::Tracer;
use lightshaft::visibility::{Strategy, VisibilityCounters};
use rayon::ThreadPoolBuilder;

use crate::embree_or_skip::embree;
use crate::solving::{Case, rough};

/// What the file of a solution holds.
fn written(case: &Case, solution: &Solution, options: &SolveOptions) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.lsol");
    let origin = Origin::new(options, Quality::Draft, "fallback");
    write_solution(&path, &case.hierarchy, case.scene.meters_per_unit, solution, &origin).expect("written");
    let opened = SolutionFile::open(&path).expect("a solution file");
    assert_eq!((opened.origin(), opened.is_one_sided()), (&origin, case.hierarchy.one_sided));
    std::fs::read(&path).expect("readable")
}

fn read(case: &Case, bytes: &[u8]) -> Result<Solution, SolutionFileError> {
    read_for(&case.hierarchy, case.scene.meters_per_unit, bytes)
}

fn read_for(hierarchy: &Hierarchy, meters: f64, bytes: &[u8]) -> Result<Solution, SolutionFileError> {
    SolutionFile::read_from(Path::new("room.lsol"), Cursor::new(bytes), bytes.len() as u64)?
        .read(hierarchy, meters)
}

/// A small scene, solved, and the file of it.
fn small() -> (Case, Vec<u8>) {
    let case = Case::load("paper-3");
    let options = SolveOptions { resolution: 12.0, epsilon: 2e-2, ..rough(Strategy::Adaptive) };
    let tracer = case.fallback();
    let mut solution = case.solve(&tracer, &options);
    solution.display = local_pass(&case.hierarchy, &tracer, &solution, 16, &Silent);
    let bytes = written(&case, &solution, &options);
    (case, bytes)
}

/// Where a section's head begins.
fn section(bytes: &[u8], tag: &[u8; 4]) -> usize {
    bytes.windows(4).position(|window| window == tag).expect("a section with this tag")
}

/// Bytes of a link.
const LINK: usize = 24;

/// All sections, in order, with the size of their records.
const SECTIONS: [(&[u8; 4], usize); 12] = [
    (b"MADE", 1),
    (b"SCEN", 8),
    (b"COUN", 8),
    (b"FIGS", 8),
    (b"TREE", 1),
    (b"IRRA", 12),
    (b"STRA", 4),
    (b"OPEN", 1),
    (b"KEPT", 5),
    (b"LINK", LINK),
    (b"DTRE", 1),
    (b"DIRR", 12),
];

/// Where the records of a section lie.
fn records_of(bytes: &[u8], tag: &[u8; 4], width: usize) -> std::ops::Range<usize> {
    let head = section(bytes, tag);
    let count = u64::from_le_bytes(bytes[head + 4..head + 12].try_into().expect("eight bytes"));
    head + 16..head + 16 + count as usize * width
}

/// The records of a section.
fn records<'a>(bytes: &'a [u8], tag: &[u8; 4]) -> &'a [u8] {
    let width = SECTIONS.iter().find(|section| section.0 == tag).expect("a section").1;
    &bytes[records_of(bytes, tag, width)]
}

/// Puts the right checksum behind bytes that were changed.
fn seal(bytes: &mut [u8], range: std::ops::Range<usize>) {
    let sum = crc32fast::hash(&bytes[range.clone()]).to_le_bytes();
    bytes[range.end..range.end + 4].copy_from_slice(&sum);
}

/// Positions all over the file: every byte of its beginning, then so many more.
fn positions(length: usize) -> impl Iterator<Item = usize> {
    let more = 600;
    (0..600.min(length)).chain((0..more).map(move |i| 600 + i * (length - 600) / more)).chain([length - 1])
}

fn bits(light: &Light) -> Vec<u32> {
    let colors = light.exitance.iter().chain(&light.irradiance).flat_map(|v| v.to_array());
    let numbers = [&light.variation, &light.brightest, &light.power, &light.peak, &light.lit];
    colors.chain(numbers.into_iter().flatten().copied()).map(f32::to_bits).collect()
}

fn pictures(case: &Case, tracer: &dyn Tracer, solution: &Solution) -> [Vec<[u32; 3]>; 2] {
    let camera = Camera { width: 61, height: 47, ..case.scene.cameras[0].clone() };
    [View::Shaded, View::Mesh].map(|view| {
        let options = RenderOptions { samples: 3, view };
        let picture = image::render(&case.hierarchy, tracer, solution, &camera, options, &Silent);
        assert!(picture.pixels.iter().any(|p| p[0] > 0.0), "a black picture shows nothing");
        picture.pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
    })
}

fn comes_back(name: &str, case: &Case, tracer: &dyn Tracer, strategy: Strategy) {
    let options = rough(strategy);
    let mut solved = case.solve(tracer, &options);
    let without = written(case, &solved, &options);
    assert!(read(case, &without).expect("what was written").display.is_none(), "{name}");
    solved.display = local_pass(&case.hierarchy, tracer, &solved, 16, &Silent);
    let bytes = written(case, &solved, &options);
    let again = read(case, &bytes).expect("what was written");
    let display = |solution: &Solution| {
        let DisplayMesh { forest, irradiance, linked } = solution.display.as_ref().expect("elements");
        let light: Vec<[u32; 3]> =
            irradiance.iter().map(|light| light.to_array().map(f32::to_bits)).collect();
        (forest.second.clone(), light, linked.clone())
    };
    assert!(display(&again) == display(&solved), "{name}: elements for display");
    assert_eq!(again.forest.second, solved.forest.second, "{name}: elements");
    assert_eq!(again.forest.cell, solved.forest.cell, "{name}: cells");
    assert_eq!(bits(&again.light), bits(&solved.light), "{name}: light");
    assert!(again.light.intensity == solved.light.intensity, "{name}: clusters");
    assert!(
        again.links.links == solved.links.links && again.links.first == solved.links.first,
        "{name}: links"
    );
    assert_eq!(again.gains.factors(), solved.gains.factors(), "{name}: gains");
    // All that light is made of, gains, openness and the factor too, is in the next bounce.
    let bounced = [&solved, &again].map(|s| bits(&s.after_one_more_bounce(&case.hierarchy)));
    assert!(bounced[0] == bounced[1], "{name}: another bounce differs");
    let figures = |s: &Solution| {
        let (energy, counters) = (&s.energy, &s.counters);
        let energy =
            [energy.emitted, energy.absorbed, energy.escaped, energy.corrected, energy.error, s.min_size];
        let counts = [counters.invisible, counters.certified_invisible, s.iterations.into()];
        let visibility = VisibilityCounters { nanoseconds: 0, ..counters.visibility };
        (energy.map(f64::to_bits), counts, visibility, s.factor.to_bits())
    };
    assert_eq!(figures(&again), figures(&solved), "{name}: figures");
    for threads in [1, 3] {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("a few threads");
        let [first, second] = [&solved, &again].map(|s| pool.install(|| pictures(case, tracer, s)));
        assert!(first == second, "{name}: pictures differ");
    }
    assert!(written(case, &again, &options) == bytes, "{name}: written again, the file differs");
}

#[test]
fn a_solution_comes_back_to_the_last_bit() {
    for (name, strategy) in
        [("cornell-box", Strategy::Adaptive), ("paper-1", Strategy::Sampled), ("paper-3", Strategy::Shaft)]
    {
        let case = Case::load(name);
        comes_back(name, &case, &case.fallback(), strategy);
    }
    let case = Case::of(Case::load("paper-1").scene, true);
    comes_back("one-sided", &case, &case.fallback(), Strategy::Adaptive);
}

#[test]
fn a_solution_comes_back_to_the_last_bit_on_embree() {
    let case = Case::load("cornell-box");
    let Some(tracer) = embree(&case.hierarchy.mesh) else { return };
    comes_back("cornell-box", &case, &tracer, Strategy::Adaptive);
}

#[test]
fn any_number_of_threads_makes_the_same_file() {
    let of = |threads| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("a few threads");
        pool.install(small).1
    };
    let alone = of(1);
    assert!([2, 5].into_iter().all(|threads| of(threads) == alone));
}

#[test]
fn every_byte_that_is_not_what_was_written_is_noticed() {
    let (case, bytes) = small();
    for (number, position) in positions(bytes.len()).enumerate() {
        let mut changed = bytes.clone();
        changed[position] ^= 1 << (number % 8);
        let error = read(&case, &changed).expect_err("a byte was changed");
        match error {
            SolutionFileError::NoSolution { .. } => assert!(position < 8, "byte {position}: {error}"),
            SolutionFileError::Damaged { .. } => assert!(position >= 8, "byte {position}: {error}"),
            other => panic!("byte {position}: {other:?}"),
        }
    }
    let more = [&bytes[..], &[0]].concat();
    assert!(matches!(read(&case, &more), Err(SolutionFileError::Damaged { .. })));
}

#[test]
fn every_end_that_is_too_early_is_noticed() {
    let (case, bytes) = small();
    for length in positions(bytes.len()) {
        let error = read(&case, &bytes[..length]).expect_err("bytes are missing");
        match error {
            SolutionFileError::NoSolution { .. } => assert!(length < 8, "{length} bytes: {error}"),
            SolutionFileError::Truncated { .. } => assert!(length >= 8, "{length} bytes: {error}"),
            other => panic!("{length} bytes: {other:?}"),
        }
    }
    // The file is shorter than it was when its length was asked for.
    let half = Cursor::new(&bytes[..bytes.len() / 2]);
    let error = SolutionFile::read_from(Path::new("a"), half, bytes.len() as u64)
        .expect("its head is whole")
        .read(&case.hierarchy, case.scene.meters_per_unit)
        .expect_err("half of it is missing");
    assert!(matches!(error, SolutionFileError::Truncated { .. }), "{error:?}");
}

#[test]
fn lengths_that_no_file_has_are_refused_before_memory_is_asked_for() {
    let (case, bytes) = small();
    for (tag, _) in SECTIONS {
        let at = section(&bytes, tag);
        for count in [u64::MAX, u64::MAX / 8, 1 << 40, bytes.len() as u64] {
            let mut changed = bytes.clone();
            changed[at + 4..at + 12].copy_from_slice(&count.to_le_bytes());
            seal(&mut changed, at..at + 12);
            let error = read(&case, &changed).expect_err("a length that no file has");
            assert!(matches!(error, SolutionFileError::Truncated { .. }), "{}: {error}", tag.escape_ascii());
        }
    }
}

/// A file may be said to be long, and be so without taking any space on a disk.
#[test]
fn a_length_that_the_file_may_have_is_not_believed_either() {
    let (case, bytes) = small();
    for (tag, _) in SECTIONS {
        let at = section(&bytes, tag);
        let mut changed = bytes[..at + 12].to_vec();
        changed[at + 4..at + 12].copy_from_slice(&(1u64 << 36).to_le_bytes());
        changed.extend([0; 4]);
        seal(&mut changed, at..at + 12);
        let endless = std::io::Read::chain(&changed[..], std::io::repeat(0));
        let error = SolutionFile::read_from(Path::new("room.lsol"), endless, 1 << 50)
            .and_then(|file| file.read(&case.hierarchy, case.scene.meters_per_unit))
            .expect_err("more than any solution has");
        assert!(matches!(error, SolutionFileError::Damaged { .. }), "{}: {error}", tag.escape_ascii());
    }
}

/// Checksums do not help against a file that was made to do harm.
#[test]
fn content_that_no_solution_has_is_refused_though_its_checksums_are_right() {
    let (case, bytes) = small();
    let all = |byte: u8, width: usize| vec![byte; width];
    let cases: [(&[u8; 4], usize, Vec<u8>); 20] = [
        (b"SCEN", 0, all(2, 1)),
        (b"COUN", 0, all(0xff, 8)),
        (b"FIGS", 8, f64::NAN.to_le_bytes().to_vec()),
        (b"FIGS", 48, 1e300f64.to_le_bytes().to_vec()),
        (b"TREE", 0, all(2, 1)),
        (b"TREE", 0, all(1, 40)),
        (b"IRRA", 4, f32::NAN.to_le_bytes().to_vec()),
        (b"STRA", 0, f32::INFINITY.to_le_bytes().to_vec()),
        (b"OPEN", 0, all(0xff, 1)),
        (b"KEPT", 0, all(0xff, 4)),
        (b"KEPT", 4, all(17, 1)),
        // All rays of an element in each of two.
        (b"KEPT", 4, [&[16][..], &records(&bytes, b"KEPT")[5..9], &[16]].concat()),
        (b"LINK", 4, all(0xff, 4)),
        (b"LINK", 20, all(4, 1)),
        (b"LINK", 21, all(0xff, 1)),
        (b"LINK", 22, vec![0x80, 0x7f]),
        (b"LINK", 22, all(0xff, 2)),
        (b"DTRE", 0, all(2, 1)),
        (b"DTRE", 0, all(1, 40)),
        (b"DIRR", 8, f32::NAN.to_le_bytes().to_vec()),
    ];
    for (tag, offset, put) in cases {
        let width = SECTIONS.iter().find(|section| section.0 == tag).expect("a section").1;
        let data = records_of(&bytes, tag, width);
        let mut changed = bytes.clone();
        changed[data.start + offset..data.start + offset + put.len()].copy_from_slice(&put);
        assert!(changed != bytes);
        seal(&mut changed, data);
        let error = read(&case, &changed).expect_err("content that no solution has");
        let what = format!("{} + {offset}: {error}", tag.escape_ascii());
        assert!(matches!(error, SolutionFileError::Damaged { .. }), "{what}");
    }
}

/// A leaf of the tree exchanges light as the elements of its facet, not by itself.
#[test]
fn links_of_leaves_are_refused() {
    let (case, bytes) = small();
    let is_leaf = |node: &lightshaft::hierarchy::Node| node.is_leaf();
    let leaf = case.hierarchy.nodes.iter().position(is_leaf).expect("a leaf") as u32;
    let data = records_of(&bytes, b"LINK", LINK);
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"));
    let ends = |at: usize| (word(at), word(at + 4));
    for offset in [0, 4] {
        // One that stays between its neighbours.
        let renamed = |at: usize| if offset == 0 { (leaf, word(at + 4)) } else { (word(at), leaf) };
        let is_free = |at: &usize| {
            (*at == data.start || ends(at - LINK) < renamed(*at))
                && (at + LINK == data.end || renamed(*at) < ends(at + LINK))
        };
        let at = data.clone().step_by(LINK).find(is_free).expect("a link that may be renamed");
        let mut changed = bytes.clone();
        changed[at + offset..at + offset + 4].copy_from_slice(&leaf.to_le_bytes());
        seal(&mut changed, data.clone());
        let error = read(&case, &changed).expect_err("a link of a leaf").to_string();
        assert!(error.contains("between clusters and elements"), "{error}");
    }
}

/// They show the light of the elements that links have, in parts of them.
#[test]
fn elements_for_display_that_are_coarser_than_the_others_are_refused() {
    let (case, bytes) = small();
    let tree = records(&bytes, b"TREE");
    let splits: Vec<bool> = tree.iter().map(|&is_split| is_split == 1).collect();
    let forest = Forest::from_splits(&case.hierarchy, &splits).expect("what was written");
    // As many elements, some of them elsewhere: the first leaf is divided, and the last pair of leaves is not.
    let leaf = |element: u32| forest.second[element as usize] == 0;
    let first = forest.leaves().next().expect("leaves");
    let joined = (0..forest.len() as u32)
        .rfind(|&element| !leaf(element) && leaf(element + 1) && leaf(forest.second[element as usize]))
        .expect("a pair of leaves");
    let mut other: Vec<u8> = Vec::new();
    for (element, &is_split) in (0u32..).zip(tree) {
        match element {
            _ if element as usize == first => other.extend([1, 0, 0]),
            _ if element == joined => other.push(0),
            _ if element == joined + 1 || element == joined + 2 => {}
            _ => other.push(is_split),
        }
    }
    assert_eq!(other.len(), tree.len());
    let leaves = vec![0; 12 * forest.leaves().count()];
    let mut changed = bytes[..section(&bytes, b"DTRE")].to_vec();
    for (tag, width, content) in [(b"DTRE", 1, &other), (b"DIRR", 12, &leaves)] {
        let at = changed.len();
        changed.extend_from_slice(tag);
        changed.extend_from_slice(&((content.len() / width) as u64).to_le_bytes());
        changed.extend([0; 4]);
        seal(&mut changed, at..at + 12);
        changed.extend_from_slice(content);
        changed.extend([0; 4]);
        seal(&mut changed, at + 16..at + 16 + content.len());
    }
    let error = read(&case, &changed).expect_err("other elements").to_string();
    assert!(error.contains("elements for display are not those of its links"), "{error}");
    // The same elements are no fault.
    let at = changed.len() - 4 - leaves.len() - 16 - 4 - other.len();
    changed[at..at + other.len()].copy_from_slice(tree);
    seal(&mut changed, at..at + other.len());
    assert!(read(&case, &changed).is_ok_and(|solution| solution.display.is_some()));
}

/// What is read can be looked at, however wrong it is.
#[test]
fn whatever_is_read_of_a_harmful_file_can_be_rendered_and_checked() {
    let (case, bytes) = small();
    let tracer = case.fallback();
    let (mut read_well, mut refused) = (0, 0);
    for number in 0..240u64 {
        let (tag, width) = SECTIONS[2 + number as usize % (SECTIONS.len() - 2)];
        let data = records_of(&bytes, tag, width);
        let mut changed = bytes.clone();
        for i in 0..1 + number % 3 {
            let chosen = hash_pair(number, i);
            let at = data.start + (chosen >> 8) as usize % data.len();
            // Small numbers and single bits are more often something that could be.
            changed[at] ^= if number % 2 == 0 { 1 << (chosen % 8) } else { chosen as u8 };
        }
        seal(&mut changed, data);
        let Ok(solution) = read(&case, &changed) else {
            refused += 1;
            continue;
        };
        read_well += 1;
        let camera = Camera { width: 16, height: 12, ..case.scene.cameras[0].clone() };
        for view in [View::Shaded, View::Mesh] {
            let options = RenderOptions { samples: 1, view };
            let picture = image::render(&case.hierarchy, &tracer, &solution, &camera, options, &Silent);
            tone::srgb_bytes(&picture, Some(Exposure::Automatic.multiplier(&picture)));
        }
        // That takes longer: once for every section whose numbers it looks at.
        if (4..8).contains(&number) {
            check::check(&case.hierarchy, &tracer, &solution, &Limits::DRAFT, &Silent);
        }
    }
    assert!(read_well > 40 && refused > 20, "{read_well} were read, {refused} refused");
}

#[test]
fn trees_without_end_are_no_forest() {
    let hierarchy = Case::load("paper-3").hierarchy;
    let sides = hierarchy.facets.len() * hierarchy.sides() as usize;
    assert!(Forest::from_splits(&hierarchy, &vec![false; sides]).is_some());
    for elements in [0, sides - 1, sides + 1] {
        assert!(Forest::from_splits(&hierarchy, &vec![false; elements]).is_none(), "{elements}");
    }
    // One side is split a thousand times, always in the first half, and the halves that are left follow.
    let mut deep = vec![true; 1000];
    deep.resize(2000 + sides, false);
    assert!(Forest::from_splits(&hierarchy, &deep).is_none());
    let mut shallow = vec![true; 100];
    shallow.resize(200 + sides, false);
    assert_eq!(Forest::from_splits(&hierarchy, &shallow).map(|forest| forest.len()), Some(200 + sides));
}

#[test]
fn other_scenes_and_versions_are_told_apart() {
    let (case, bytes) = small();
    let meters = case.scene.meters_per_unit;
    let refused = |hierarchy: &Hierarchy, meters: f64, part: &str| {
        let error = read_for(hierarchy, meters, &bytes).expect_err(part);
        assert!(matches!(error, SolutionFileError::OtherScene { .. }), "{error:?}");
        assert!(error.to_string().starts_with("room.lsol: ") && error.to_string().contains(part), "{error}");
    };
    let changed = |change: &dyn Fn(&mut lightshaft::scene::Scene)| {
        let mut scene = Case::load("paper-3").scene;
        change(&mut scene);
        Case::of(scene, false).hierarchy
    };
    refused(&Case::load("paper-1").hierarchy, meters, "geometry");
    refused(&case.hierarchy, 2.0 * meters, "geometry");
    refused(&changed(&|scene| scene.positions[0].x += 1e-3), meters, "geometry");
    refused(&changed(&|scene| scene.positions.iter_mut().for_each(|p| *p *= 2.0)), meters, "geometry");
    refused(&changed(&|scene| scene.materials[0].reflectance[1] += 1e-3), meters, "materials");
    let lamp = |material: &mut lightshaft::scene::Material| material.radiance[0] *= 1.001;
    refused(&changed(&|scene| scene.materials.iter_mut().for_each(lamp)), meters, "materials");
    refused(&Case::of(Case::load("paper-3").scene, true).hierarchy, meters, "two-sided");
    // Names and cameras do not matter.
    let renamed = changed(&|scene| {
        scene.materials[0].name.push('x');
        scene.cameras.clear();
    });
    assert!(read_for(&renamed, meters, &bytes).is_ok());

    for (version, part) in [(5u32, "a newer lightshaft (0.9.7, format 5"), (0, "an older lightshaft (0.9.7")]
    {
        let mut other = bytes.clone();
        other[8..12].copy_from_slice(&version.to_le_bytes());
        other[12..18].copy_from_slice(b"0.9.7\0");
        seal(&mut other, 0..32);
        // Whatever follows the head may be laid out otherwise.
        other.truncate(36);
        let error = read(&case, &other).expect_err("another version");
        assert!(matches!(error, SolutionFileError::OtherVersion { .. }), "{error:?}");
        assert!(error.to_string().contains(part), "{error}");
    }
}
