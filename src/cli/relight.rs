//! `relight`: from a solution file to one of the same scene with other lamps or reflectances.

use super::config::{RelightConfig, RunConfig};
use super::console;
use super::errors::CliError;
use super::solved::{Loaded, Solved, add_display, fill_stats, in_pool, scene_failure, warn_if_unbalanced};
use super::stored::scene_of;
use crate::export::{Origin, write_solution};
use crate::hierarchy::{Fingerprint, Hierarchy};
use crate::image::write::check_destination;
use crate::memory;
use crate::progress::Progress;
use crate::radiosity::{Relit, Reuse, Solution, relight};
use crate::report::stats::RelitStats;
use crate::report::{json, table};
use crate::scene::{self, LoadOptions, Scene, check_names};

/// Where more than this share of the light comes over links that are too coarse for it, there is more error than
/// solving makes.
const COARSE: f64 = 0.15;

/// Where more than this share of the light falls where there was little, pairs may matter that were given up.
const MOVED: f64 = 0.25;

/// Changes the light as configured.
///
/// # Errors
/// The first thing that goes wrong; then no output has been touched, except that the solution stays
/// when writing the statistics fails after it.
pub(super) fn run(config: &RelightConfig) -> Result<(), CliError> {
    for path in &config.run.outputs {
        check_destination(path)?;
    }
    let scene = scene_of(&config.stored, config.scene.as_deref())?;
    let run = RunConfig { scene, ..config.run.clone() };
    in_pool(&run, |progress| run_in_pool(config, &run, progress))
}

fn run_in_pool(config: &RelightConfig, run: &RunConfig, progress: &dyn Progress) -> Result<(), CliError> {
    let loaded = Loaded::load(run, progress)?;
    check_names(&config.changes, &loaded.scene.materials)
        .map_err(|why| CliError::Usage(format!("--set: {why}")))?;
    let Solved { scene: before, hierarchy, tracer, solution, quality, origin, mut stats, clock } =
        loaded.solution(run, progress)?;
    let options = origin.options().ok_or_else(|| {
        let (stored, strategy) = (config.stored.display(), &origin.strategy);
        CliError::Malformed(format!(
            "{stored}: solved with a strategy {strategy} that is not known; solve again"
        ))
    })?;
    let mut changes = origin.changes.clone();
    config.changes.iter().for_each(|change| change.add_to(&mut changes));
    let (scene, hierarchy) = with_other_materials(run, &changes, (&before, hierarchy), progress)?;

    let had_display = solution.display.is_some();
    let rays_before = solution.counters.visibility.rays_cast;
    let square_meters = hierarchy.square_meters_per_unit(scene.meters_per_unit);
    let Relit { mut solution, untested, coarse, moved } =
        relight(&hierarchy, tracer.as_ref(), solution, &options, config.reuse, square_meters, progress);
    if config.local_pass {
        stats.local_pass = add_display(&mut solution, &hierarchy, tracer.as_ref(), quality, progress);
    }
    let origin = Origin { changes, ..origin }.at(&config.output, &run.scene);
    write_solution(&config.output, &hierarchy, scene.meters_per_unit, &solution, &origin)?;

    fill_stats(&mut stats, &scene, &hierarchy, &solution);
    let rays_cast = solution.counters.visibility.rays_cast - rays_before;
    let relit = RelitStats { untested, coarse, moved, rays_cast };
    stats.relit = Some(relit);
    stats.seconds.total = clock.total();
    stats.memory.peak_rss_bytes = memory::peak_rss_bytes();
    if !run.quiet {
        warn_if_unbalanced(&solution);
        console::note(&table::table(&[(scene.name.as_str(), &stats)]));
        console::note(&told(&solution, &relit));
        if had_display && !config.local_pass {
            console::note("what it had for display was of the light before; --local-pass makes that anew\n");
        }
        warn_if_coarse(&relit, config.reuse);
        warn_if_moved(&relit);
    }
    if let Some(path) = &config.stats {
        json::write_json(path, &stats)?;
    }
    Ok(())
}

/// The scene with these materials, and the hierarchy over it, which must be the one that was solved but for them.
fn with_other_materials(
    run: &RunConfig,
    changes: &[scene::MaterialChange],
    (before, solved): (&Scene, Hierarchy),
    progress: &dyn Progress,
) -> Result<(Scene, Hierarchy), CliError> {
    let options = LoadOptions { changes: changes.to_vec(), ..LoadOptions::default() };
    let scene = scene::load(&run.scene, &options, progress).map_err(scene_failure)?;
    if !run.quiet {
        let is_new = |warning: &&String| !before.warnings.contains(warning);
        scene.warnings.iter().filter(is_new).for_each(|warning| console::warning(warning));
    }
    let hierarchy = Hierarchy::build(&scene, solved.one_sided, progress);
    let [was, is] = [(&solved, before), (&hierarchy, &scene)]
        .map(|(hierarchy, scene)| Fingerprint::of(hierarchy, scene.meters_per_unit));
    if (was.geometry, was.tree) != (is.geometry, is.tree) {
        return Err(CliError::InvalidScene(format!(
            "{}: of surfaces that lie in each other, others are kept now, since what shines is kept first: links do not \
             fit any more; change the scene and solve it again",
            run.scene.display()
        )));
    }
    Ok((scene, hierarchy))
}

/// What was saved, and what that costs.
fn told(solution: &Solution, relit: &RelitStats) -> String {
    let seconds = solution.refine_seconds + solution.solve_seconds;
    let (links, rays) = (solution.links.links.len(), solution.counters.visibility.rays_cast);
    let mut text = format!(
        "relit in {seconds:.2} s over {links} links; visibility took {} rays more than the {} of before; {:.1} % of the \
         light comes over links that it would have divided further, {:.1} % falls where there was little\n",
        relit.rays_cast,
        rays - relit.rays_cast,
        100.0 * relit.coarse,
        100.0 * relit.moved
    );
    if relit.untested > 0 {
        text += &format!(
            "{} links came from what was dark and shines now: they were tested, and links divided where the new light \
             needs it\n",
            relit.untested
        );
    }
    text
}

/// Says so when much of the light comes from where there was little.
fn warn_if_coarse(relit: &RelitStats, reuse: Reuse) {
    if relit.coarse > COARSE {
        let is_refined = reuse == Reuse::Refined || relit.untested > 0;
        console::warning(&format!(
            "{:.0} % of the light comes over links that are too coarse for it; {}change the scene and solve it again",
            100.0 * relit.coarse,
            if is_refined { "" } else { "--refine divides them, or " }
        ));
    }
}

/// Says so when much of the light falls where there was little.
fn warn_if_moved(relit: &RelitStats) {
    if relit.moved > MOVED {
        console::warning(&format!(
            "{:.0} % of the light falls where there was little before: surfaces that seemed hidden from each other there, by \
             the few rays that so little light deserves, stay hidden, whatever now shines on them; change the scene and \
             solve it again to be sure",
            100.0 * relit.moved
        ));
    }
}
