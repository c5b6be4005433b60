//! Writing and reading solution files. What follows from the scene is not in them: the hierarchy is built again, and
//! its fingerprint tells whether it is the same. What follows from the irradiance of the leaf elements is not either.

use super::fault::{Fault, SolutionFileError};
use super::origin::{Origin, is_name};
use super::records::Record;
use super::sections::{Sections, Tag, write_sealed, write_section};
use crate::hierarchy::{Fingerprint, Hierarchy};
use crate::image::write::{FillError, OutputError, write_atomically};
use crate::radiosity::{
    DisplayMesh, Energy, Forest, Gains, Kept, Light, Link, LinkSet, Openness, RefineCounters, Solution,
};
use crate::visibility::VisibilityCounters;
use crc32fast::hash;
use glam::Vec3;
use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::{Path, PathBuf};

/// Of the format.
pub(super) const VERSION: u32 = 4;

/// What the file begins with. Like that of a PNG, it is no text, and a transfer that changes line ends breaks it.
const MAGIC: [u8; 8] = *b"\x89LSOL\r\n\x1a";

/// Magic, version, and the version of the program, filled up with zeros.
const HEAD: usize = 8 + 4 + 20;

/// No section of counters or of figures holds more.
const MOST_FIGURES: usize = 64;

/// Longest description of the origin, bytes: it names the materials that have changed.
const LONGEST_ORIGIN: usize = 1 << 20;

const ORIGIN: Tag = *b"MADE";
const SCENE: Tag = *b"SCEN";
const COUNTERS: Tag = *b"COUN";
const FIGURES: Tag = *b"FIGS";
const SPLITS: Tag = *b"TREE";
const IRRADIANCE: Tag = *b"IRRA";
const GAINS: Tag = *b"STRA";
const KEPT_COUNTS: Tag = *b"OPEN";
const KEPT: Tag = *b"KEPT";
const LINKS: Tag = *b"LINK";
const DISPLAY_SPLITS: Tag = *b"DTRE";
const DISPLAY_IRRADIANCE: Tag = *b"DIRR";

/// Writes a solution to `path`, whole or not at all. A unit of length of the scene is `meters_per_unit` metres.
///
/// # Errors
/// When the folder is missing or not writable or the disk is full; then `path` is as before.
pub fn write_solution(
    path: &Path,
    hierarchy: &Hierarchy,
    meters_per_unit: f64,
    solution: &Solution,
    origin: &Origin,
) -> Result<(), OutputError> {
    let scene = Fingerprint::of(hierarchy, meters_per_unit);
    write_atomically(path, |file| write(file, &scene, solution, origin).map_err(FillError::Io))
}

fn write(to: &mut dyn Write, scene: &Fingerprint, solution: &Solution, origin: &Origin) -> io::Result<()> {
    let mut head = [0; HEAD];
    head[..8].copy_from_slice(&MAGIC);
    head[8..12].copy_from_slice(&VERSION.to_le_bytes());
    for (to, from) in head[12..].iter_mut().zip(origin.program.bytes()) {
        *to = from;
    }
    write_sealed(to, &head)?;
    let text = serde_json::to_vec(origin)?;
    if text.len() > LONGEST_ORIGIN {
        return Err(io::Error::other("the names of the materials that have changed are too long"));
    }
    write_section(to, ORIGIN, text.len(), text)?;
    let Fingerprint { one_sided, geometry, materials, tree } = *scene;
    write_section(to, SCENE, 4, [u64::from(one_sided), geometry, materials, tree])?;
    let counters = counters(solution);
    write_section(to, COUNTERS, counters.len(), counters)?;
    let Energy { emitted, absorbed, escaped, corrected, error } = solution.energy;
    let figures = [emitted, absorbed, escaped, corrected, error, solution.min_size, solution.factor.into()];
    write_section(to, FIGURES, figures.len(), figures)?;

    let Solution { forest, light, links, openness, gains, .. } = solution;
    write_section(to, SPLITS, forest.len(), forest.second.iter().map(|&second| second != 0))?;
    let leaves = forest.leaves().map(|leaf| light.irradiance[leaf]);
    write_section(to, IRRADIANCE, forest.leaves().count(), leaves)?;
    write_section(to, GAINS, forest.len(), gains.factors().iter().copied())?;
    let kept = || forest.leaves().map(|leaf| openness.kept_of(leaf as u32));
    write_section(to, KEPT_COUNTS, forest.leaves().count(), kept().map(|kept| kept.len() as u8))?;
    write_section(to, KEPT, kept().map(<[Kept]>::len).sum(), kept().flatten().copied())?;
    write_section(to, LINKS, links.links.len(), links.links.iter().copied())?;
    write_display(to, solution.display.as_ref())
}

/// Without elements for display the sections are empty.
fn write_display(to: &mut dyn Write, mesh: Option<&DisplayMesh>) -> io::Result<()> {
    let elements = mesh.map_or(&[][..], |mesh| &mesh.forest.second);
    write_section(to, DISPLAY_SPLITS, elements.len(), elements.iter().map(|&second| second != 0))?;
    let leaves = || mesh.into_iter().flat_map(|mesh| mesh.forest.leaves().map(|leaf| mesh.irradiance[leaf]));
    write_section(to, DISPLAY_IRRADIANCE, leaves().count(), leaves())
}

/// Counts as they are stored. Clocks are left out: the same scene makes the same file.
fn counters(solution: &Solution) -> [u64; 17] {
    let RefineCounters { invisible, certified_invisible, visibility, detail: _ } = &solution.counters;
    let VisibilityCounters {
        pairs_tested,
        shafts_built,
        nodes_tested,
        empty_shafts,
        single_blockers,
        fused_blockers,
        rays_cast,
        rays_avoided,
        filter_calls,
        filter_rejects,
        border_hits,
        culling_anomalies,
        filled_shafts,
        candidates,
        nanoseconds: _,
    } = *visibility;
    [
        solution.iterations.into(),
        *invisible,
        *certified_invisible,
        pairs_tested,
        shafts_built,
        nodes_tested,
        empty_shafts,
        single_blockers,
        fused_blockers,
        rays_cast,
        rays_avoided,
        filter_calls,
        filter_rejects,
        border_hits,
        culling_anomalies,
        filled_shafts,
        candidates,
    ]
}

/// A solution file that was opened and found to be one, of this version.
#[derive(Debug)]
pub struct SolutionFile<R = BufReader<File>> {
    path: PathBuf,
    sections: Sections<R>,
    origin: Origin,
    scene: Fingerprint,
}

impl SolutionFile {
    /// Opens a file and reads its head, which says how it was made and for what.
    ///
    /// # Errors
    /// When the file cannot be read, is no solution file or one of another version, ends too early or is damaged.
    pub fn open(path: &Path) -> Result<SolutionFile, SolutionFileError> {
        let unreadable = |source| SolutionFileError::Unreadable { path: path.to_owned(), source };
        // Looked at before it is opened: a pipe would wait for whoever writes to it.
        if !path.metadata().map_err(unreadable)?.is_file() {
            return Err(unreadable(io::Error::other("not a regular file")));
        }
        let file = File::open(path).map_err(unreadable)?;
        let length = file.metadata().map_err(unreadable)?.len();
        SolutionFile::read_from(path, BufReader::new(file), length)
    }
}

impl<R: Read> SolutionFile<R> {
    /// Reads the head of what `path` stands for: a source of `length` bytes.
    ///
    /// # Errors
    /// As for [`SolutionFile::open`].
    pub fn read_from(path: &Path, source: R, length: u64) -> Result<Self, SolutionFileError> {
        let mut sections = Sections::new(source, length);
        let (origin, scene) = read_head(&mut sections).map_err(|fault| fault.of(path))?;
        Ok(SolutionFile { path: path.to_owned(), sections, origin, scene })
    }

    /// How the solution was made.
    pub fn origin(&self) -> &Origin {
        &self.origin
    }

    /// Whether surfaces reflect on their front side only.
    pub fn is_one_sided(&self) -> bool {
        self.scene.one_sided
    }

    /// Reads the solution for a hierarchy that was built anew. Seconds are 0.
    ///
    /// # Errors
    /// When the file was made for something else, cannot be read, ends too early or is damaged. Whatever it holds,
    /// ids in a solution that is returned are those of elements and clusters, and all numbers are finite.
    pub fn read(
        mut self,
        hierarchy: &Hierarchy,
        meters_per_unit: f64,
    ) -> Result<Solution, SolutionFileError> {
        is_same_scene(&self.scene, &Fingerprint::of(hierarchy, meters_per_unit))
            .and_then(|()| read_solution(&mut self.sections, hierarchy))
            .map_err(|fault| fault.of(&self.path))
    }
}

fn read_head<R: Read>(sections: &mut Sections<R>) -> Result<(Origin, Fingerprint), Fault> {
    let mut head = [0; HEAD];
    let magic = &mut head[..MAGIC.len()];
    // What is shorter than that is no solution file either.
    sections
        .read(magic)
        .map_err(|fault| if let Fault::Truncated = fault { Fault::NoSolution } else { fault })?;
    if *magic != MAGIC {
        return Err(Fault::NoSolution);
    }
    sections.read(&mut head[MAGIC.len()..])?;
    sections.check(hash(&head), "its head")?;
    let version = u32::from_le_bytes([head[8], head[9], head[10], head[11]]);
    if version != VERSION {
        let program = String::from_utf8_lossy(&head[12..]);
        let program = Some(program.trim_end_matches('\0')).filter(|name| is_name(name));
        return Err(Fault::OtherVersion(version, program.unwrap_or("of an unknown version").to_owned()));
    }
    let text: Vec<u8> = sections.section(ORIGIN, LONGEST_ORIGIN)?;
    let untold = |why: String| Fault::Damaged(format!("it does not say how it was made{why}"));
    let origin: Origin = serde_json::from_slice(&text).map_err(|error| untold(format!(": {error}")))?;
    if !origin.is_sound() {
        return Err(untold(String::new()));
    }
    let scene = match sections.section(SCENE, 4)?[..] {
        [sided @ (0 | 1), geometry, materials, tree] => {
            Fingerprint { one_sided: sided == 1, geometry, materials, tree }
        }
        _ => return Err(Fault::Damaged("it does not say for which scene it was made".to_owned())),
    };
    Ok((origin, scene))
}

/// Says what differs, the most telling first.
fn is_same_scene(found: &Fingerprint, wanted: &Fingerprint) -> Result<(), Fault> {
    let difference = if found.one_sided && !wanted.one_sided {
        "for one-sided surfaces"
    } else if found.one_sided != wanted.one_sided {
        "for two-sided surfaces"
    } else if found.geometry != wanted.geometry {
        "for another scene: the geometry differs"
    } else if found.materials != wanted.materials {
        "for other materials: reflectance or emission has changed"
    } else if found.tree != wanted.tree {
        "by a lightshaft that divides this scene otherwise"
    } else {
        return Ok(());
    };
    Err(Fault::OtherScene(difference))
}

fn read_solution<R: Read>(sections: &mut Sections<R>, hierarchy: &Hierarchy) -> Result<Solution, Fault> {
    let damaged = |what: &str| Fault::Damaged(what.to_owned());
    let (iterations, counters) = read_counters(&sections.section(COUNTERS, MOST_FIGURES)?)
        .ok_or_else(|| damaged("it does not count what was done"))?;
    let [emitted, absorbed, escaped, corrected, error, min_size, factor] =
        sections.section::<f64>(FIGURES, MOST_FIGURES)?[..]
    else {
        return Err(damaged("figures are missing"));
    };
    let factor = Some(factor as f32).filter(|factor| factor.is_finite());
    let factor = factor.ok_or_else(|| damaged("its light was scaled by no number"))?;

    let splits: Vec<bool> = sections.section(SPLITS, u32::MAX as usize)?;
    let leaves = splits.iter().filter(|&&is_split| !is_split).count();
    // Elements in memory are larger than in the file, so they are made only if the rest of the file is there.
    let at_least = leaves as u64 * Vec3::BYTES as u64 + splits.len() as u64 * 4;
    if sections.left() < at_least {
        return Err(Fault::Truncated);
    }
    let nodes =
        u32::try_from(splits.len() + hierarchy.nodes.len()).map_err(|_| damaged("too many elements"))?;
    let forest = Forest::from_splits(hierarchy, &splits)
        .ok_or_else(|| damaged("its elements are not those of this scene"))?;
    drop(splits);
    let irradiance: Vec<Vec3> = sections.section(IRRADIANCE, leaves)?;
    if irradiance.len() != leaves {
        return Err(damaged("elements are without irradiance"));
    }
    let light = Light::from_leaves(hierarchy, &forest, &irradiance);
    drop(irradiance);
    let gains: Vec<f32> = sections.section(GAINS, forest.len())?;
    if gains.len() != forest.len() {
        return Err(damaged("elements are without what they receive over what links bring"));
    }
    if !gains.iter().all(|gain| gain.is_finite() && *gain >= 0.0) {
        return Err(damaged("elements receive what cannot be"));
    }
    let openness = read_openness(sections, hierarchy, &forest)?;
    let links: Vec<Link> = sections.section(LINKS, u32::MAX as usize)?;
    // A leaf of the hierarchy takes part as the elements of its facet.
    let is_known = |id: u32| hierarchy.nodes.get(id as usize).map_or(id < nodes, |node| !node.is_leaf());
    if !links.iter().all(|link| is_known(link.receiver) && is_known(link.source)) {
        return Err(damaged("its links are not between clusters and elements of this scene"));
    }
    let display = read_display(sections, hierarchy, &forest)?;
    sections.end()?;
    Ok(Solution {
        forest,
        light,
        links: LinkSet::new(links, nodes as usize),
        openness,
        gains: Gains::from_factors(gains),
        factor,
        display,
        counters,
        work: Vec::new(),
        iterations,
        energy: Energy { emitted, absorbed, escaped, corrected, error },
        min_size,
        refine_seconds: 0.0,
        solve_seconds: 0.0,
    })
}

fn read_display<R: Read>(
    sections: &mut Sections<R>,
    hierarchy: &Hierarchy,
    solution: &Forest,
) -> Result<Option<DisplayMesh>, Fault> {
    let damaged = |what: &str| Fault::Damaged(what.to_owned());
    let splits: Vec<bool> = sections.section(DISPLAY_SPLITS, u32::MAX as usize)?;
    let leaves = splits.iter().filter(|&&is_split| !is_split).count();
    if sections.left() < leaves as u64 * Vec3::BYTES as u64 {
        return Err(Fault::Truncated);
    }
    let of_leaves: Vec<Vec3> = sections.section(DISPLAY_IRRADIANCE, leaves)?;
    if of_leaves.len() != leaves {
        return Err(damaged("elements for display are without irradiance"));
    }
    if splits.is_empty() {
        return Ok(None);
    }
    let forest = Forest::from_splits(hierarchy, &splits)
        .ok_or_else(|| damaged("its elements for display are not those of this scene"))?;
    let mut irradiance = vec![Vec3::ZERO; forest.len()];
    for (leaf, light) in forest.leaves().zip(of_leaves) {
        irradiance[leaf] = light;
    }
    let mesh = DisplayMesh::new(forest, irradiance, solution);
    mesh.ok_or_else(|| damaged("its elements for display are not those of its links")).map(Some)
}

fn read_counters(stored: &[u64]) -> Option<(u32, RefineCounters)> {
    let &[
        iterations,
        invisible,
        certified_invisible,
        pairs_tested,
        shafts_built,
        nodes_tested,
        empty_shafts,
        single_blockers,
        fused_blockers,
        rays_cast,
        rays_avoided,
        filter_calls,
        filter_rejects,
        border_hits,
        culling_anomalies,
        filled_shafts,
        candidates,
    ] = stored
    else {
        return None;
    };
    let visibility = VisibilityCounters {
        pairs_tested,
        shafts_built,
        nodes_tested,
        empty_shafts,
        single_blockers,
        fused_blockers,
        rays_cast,
        rays_avoided,
        filter_calls,
        filter_rejects,
        border_hits,
        culling_anomalies,
        filled_shafts,
        candidates,
        nanoseconds: 0,
    };
    // Statistics add these up.
    let is_small = |&count: &u64| count <= u64::MAX / 4;
    if !stored.iter().all(is_small) {
        return None;
    }
    Some((
        iterations.try_into().ok()?,
        RefineCounters { invisible, certified_invisible, visibility, detail: None },
    ))
}

fn read_openness<R: Read>(
    sections: &mut Sections<R>,
    hierarchy: &Hierarchy,
    forest: &Forest,
) -> Result<Openness, Fault> {
    let leaves: Vec<u32> = forest.leaves().map(|leaf| leaf as u32).collect();
    let counts: Vec<u8> = sections.section(KEPT_COUNTS, leaves.len())?;
    let total: usize = counts.iter().map(|&count| count as usize).sum();
    let kept: Vec<Kept> = sections.section(KEPT, total)?;
    let mut rest = &kept[..];
    let lists: Vec<&[Kept]> = counts.iter().map_while(|&count| rest.split_off(..count as usize)).collect();
    let holds = |leaf: u32, kept: &Kept| match hierarchy.nodes.get(kept.node as usize) {
        Some(node) => {
            let facet = forest.side(forest.side_of(leaf)).facet;
            !node.is_leaf() && (node.first..node.end).contains(&facet)
        }
        None => (1..=forest.above(leaf).count()).contains(&(kept.node as usize - hierarchy.nodes.len())),
    };
    let is_cluster = |kept: &Kept| (kept.node as usize) < hierarchy.nodes.len();
    let are_known = |(&leaf, kept): (&u32, &&[Kept])| {
        // The same rays count for clusters and, in pairs, for elements.
        let [in_clusters, beside] = [true, false].map(|which| {
            let counted = kept.iter().filter(|&kept| is_cluster(kept) == which);
            counted.map(|kept| u32::from(kept.rays)).sum::<u32>()
        });
        let most = u32::from(Kept::RAYS);
        in_clusters <= most && beside <= most && kept.iter().all(|kept| holds(leaf, kept))
    };
    if lists.len() != leaves.len() || total != kept.len() || !leaves.iter().zip(&lists).all(are_known) {
        return Err(Fault::Damaged("rays of its elements do not end in clusters of this scene".to_owned()));
    }
    Ok(Openness::from_kept(hierarchy, forest, lists.into_iter()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quality_that_nobody_knows_is_refused_with_the_file_and_its_name() {
        let head = |quality: &str| {
            let (mut bytes, mut head) = (Vec::new(), [0; HEAD]);
            head[..8].copy_from_slice(&MAGIC);
            head[8..12].copy_from_slice(&VERSION.to_le_bytes());
            write_sealed(&mut bytes, &head).expect("memory");
            let text = format!(
                r#"{{"program":"0.1.0","tracer":"fallback","quality":"{quality}","strategy":"adaptive","epsilon":0.1,
                "contrast":0.1,"min_size":null,"resolution":64.0,"rays":4,"iterations":9,"certify":false}}"#
            );
            write_section(&mut bytes, ORIGIN, text.len(), text.into_bytes()).expect("memory");
            write_section(&mut bytes, SCENE, 4, [0u64; 4]).expect("memory");
            let length = bytes.len() as u64;
            SolutionFile::read_from(Path::new("room.lsol"), io::Cursor::new(bytes), length)
        };
        assert!(head("draft").is_ok());
        let error = head("ultra").expect_err("an unknown quality").to_string();
        assert!(error.starts_with("room.lsol: ") && error.contains("`ultra`"), "{error}");
    }
}
