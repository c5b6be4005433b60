//! `probe`.
use super::args::ProbeArgs;
use super::config::RunConfig;
use super::console;
use super::errors::CliError;
use super::solved::{Loaded, Solved, in_pool};
use crate::gather::{Gatherer, Irradiance};
use crate::probe::{Deviation, read_points, read_reference};
use rayon::prelude::*;

pub(super) fn run(typed: ProbeArgs) -> Result<(), CliError> {
    let config = RunConfig::check(typed.scene, typed.solution, typed.machine, typed.quiet)?;
    let bad = |e: crate::probe::ProbeError| CliError::Malformed(e.to_string());
    let points = read_points(&typed.points).map_err(bad)?;
    let reference = typed.reference.map(|p| read_reference(&p)).transpose().map_err(bad)?;
    in_pool(&config, |progress| {
        let Solved { hierarchy, tracer, solution, mut stats, mut clock, .. } =
            Loaded::load(&config)?.solve(&config, progress)?;
        clock.lap();
        stats.seconds.total = clock.total();
        println!(
            "solved {:.1} s refine {:.1} balance {:.3}% elements {} links {} MB {}",
            stats.seconds.total,
            stats.seconds.refine,
            100.0 * stats.energy.balance_error,
            stats.scene.elements,
            stats.links.total,
            stats.memory.peak_rss_bytes >> 20
        );
        let show = |name: &str, found: &[Irradiance]| {
            if let Some(reference) = &reference {
                let t = Deviation::of(found, reference, |i| i.total);
                let d = Deviation::of(found, reference, |i| i.direct);
                println!(
                    "{name}: total rms {:.2}% bias {:+.2}% worst {:.1}% at {} | direct rms {:.2}% bias {:+.2}% worst {:.1}% at {}",
                    100.0 * t.rms,
                    100.0 * t.bias,
                    100.0 * t.worst,
                    t.worst_at + 2,
                    100.0 * d.rms,
                    100.0 * d.bias,
                    100.0 * d.worst,
                    d.worst_at + 2
                );
                if std::env::var_os("LS_DUMP").is_some() {
                    for (i, (f, r)) in found.iter().zip(reference).enumerate() {
                        println!(
                            "  {} found {:.4} direct {:.4} ref {:.4} se {:.4} direct {:.4}",
                            i + 2,
                            f.total,
                            f.direct,
                            r.irradiance.total,
                            r.error.total,
                            r.irradiance.direct
                        );
                    }
                }
            }
        };
        for samples in [typed.samples / 4, typed.samples, typed.samples * 4] {
            let gatherer = Gatherer::new(&hierarchy, tracer.as_ref(), &solution, samples);
            if samples < typed.samples {
                let found: Vec<Irradiance> = points
                    .iter()
                    .map(|p| Irradiance {
                        total: gatherer.interpolated(p.position, p.normal),
                        direct: Default::default(),
                    })
                    .collect();
                show("interpolated", &found);
            }
            let found: Vec<Irradiance> = points
                .par_iter()
                .enumerate()
                .map(|(i, p)| gatherer.irradiance(p.position, p.normal, i as u64))
                .collect();
            show(&format!("gathered {samples} {:.2} s", clock.lap()), &found);
        }
        console::note("");
        Ok(())
    })
}
