//! The checked configuration of a verb: every option has its value, and the options fit each other.

mod compare;
mod convergence;
mod export;
mod keep;
mod pattern;
mod profile;
mod relight;
mod stored;
mod views;

pub(super) use compare::{CompareConfig, Pictures};
pub(super) use convergence::ConvergenceConfig;
pub(super) use export::ExportConfig;
pub(super) use keep::KeepConfig;
pub(super) use profile::ProfileConfig;
pub(super) use relight::RelightConfig;
pub(super) use views::{Motion, VideoConfig, Views};

use std::path::{Path, PathBuf};

use super::args::{
    CheckArgs, ExactnessArgs, MachineArgs, PictureArgs, ProbeArgs, QualityArg, RenderArgs, SolutionArgs,
    TracerArg, ViewArg, VisibilityArg,
};
use super::errors::CliError;
use crate::image::tone::{Exposure, Tone};
use crate::image::write::PictureFormat;
use crate::radiosity::Record;

/// Everything that is needed to solve a scene, whatever is then done with the solution.
#[derive(Clone, Debug)]
pub(super) struct RunConfig {
    pub(super) scene: PathBuf,
    /// Files that will be written.
    pub(super) outputs: Vec<PathBuf>,
    pub(super) solve: SolveConfig,
    /// A solution file, instead of solving.
    pub(super) stored: Option<PathBuf>,
    pub(super) tracer: TracerArg,
    pub(super) embree_lib: Option<PathBuf>,
    /// Worker threads; all cores when absent.
    pub(super) threads: Option<u32>,
    pub(super) quiet: bool,
}

/// Everything a render needs to know.
#[derive(Clone, Debug)]
pub(super) struct RenderConfig {
    /// Its outputs are all but the pictures, whose number is not known yet.
    pub(super) run: RunConfig,
    /// Files that are named to be read.
    pub(super) inputs: Vec<PathBuf>,
    pub(super) views: Views,
    pub(super) format: PictureFormat,
    /// How exposed radiance becomes displayable.
    pub(super) tone: Tone,
    /// Whether pictures have layers besides radiance.
    pub(super) layers: bool,
    pub(super) video: Option<VideoConfig>,
    pub(super) stats: Option<PathBuf>,
    pub(super) view: ViewConfig,
    /// How each pixel is lit.
    pub(super) lighting: Lighting,
    /// What the picture is compared with.
    pub(super) reference: Option<PathBuf>,
}

/// Everything a probe run needs to know.
#[derive(Clone, Debug)]
pub(super) struct ProbeConfig {
    pub(super) run: RunConfig,
    pub(super) places: Places,
    pub(super) output: Option<PathBuf>,
    /// The output is JSON; CSV otherwise.
    pub(super) is_json: bool,
    pub(super) lux: bool,
    pub(super) samples: u32,
    pub(super) reference: Option<PathBuf>,
}

/// Which points are probed.
#[derive(Clone, Debug)]
pub(super) enum Places {
    /// Those of a file.
    File(PathBuf),
    /// A grid with this spacing, over a rectangle with this name or at this height.
    Grid(String, Option<f64>),
}

/// Everything a check needs to know.
#[derive(Clone, Debug)]
pub(super) struct CheckConfig {
    pub(super) run: RunConfig,
    pub(super) json: Option<PathBuf>,
}

/// How pixels are lit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Lighting {
    /// Interpolated over the elements.
    Reconstructed,
    /// Gathered, with so many rays when typed.
    Gathered(Option<u32>),
}

/// What is seen, and how.
#[derive(Clone, Debug)]
pub(super) struct ViewConfig {
    pub(super) width: Option<u32>,
    pub(super) height: Option<u32>,
    /// Samples per pixel, when typed.
    pub(super) samples: Option<u32>,
    pub(super) exposure: Exposure,
    pub(super) kind: ViewArg,
}

/// How the solution is computed.
#[derive(Clone, Debug)]
pub(super) struct SolveConfig {
    /// Where what is not typed comes from.
    pub(super) quality: QualityArg,
    /// Power a link may get wrong, relative to the power the receiver's irradiance brings to a wall.
    pub(super) epsilon: f64,
    /// Share of the receiver's irradiance above which partly visible pairs are split.
    pub(super) contrast: f64,
    /// Smallest element edge in scene units, when typed.
    pub(super) min_size: Option<f64>,
    /// Elements across two walls of a room, when no smallest edge is typed.
    pub(super) resolution: f64,
    /// Most rays for a pair.
    pub(super) rays: u32,
    /// Most iterations.
    pub(super) iterations: u32,
    pub(super) strategy: VisibilityArg,
    pub(super) certify: bool,
    pub(super) one_sided: bool,
    /// What is kept of the way there.
    pub(super) record: Record,
}

/// What `--quality` stands for; each value can be overridden by its own option.
struct Preset {
    epsilon: f64,
    contrast: f64,
    resolution: f64,
    rays: u32,
    iterations: u32,
    samples: u32,
    gather_rays: u32,
}

impl Preset {
    const fn of(quality: QualityArg) -> Self {
        let (epsilon, contrast, resolution, rays, iterations, samples, gather_rays) = match quality {
            QualityArg::Draft => (5e-3, 0.8, 64.0, 4, 1000, 4, 64),
            QualityArg::Normal => (5e-5, 0.1, 128.0, 16, 2000, 16, 128),
            QualityArg::High => (1e-5, 0.05, 256.0, 32, 4000, 36, 256),
        };
        Self { epsilon, contrast, resolution, rays, iterations, samples, gather_rays }
    }

    /// The preset at a place on a scale on which draft is 0, normal 1 and high 2: in between, and beyond, values
    /// follow in even ratios.
    fn at(place: f64) -> Self {
        let levels = [QualityArg::Draft, QualityArg::Normal, QualityArg::High].map(Preset::of);
        let below = if place < 1.0 { 0 } else { 1 };
        let [a, b] = [&levels[below], &levels[below + 1]];
        let part = place - below as f64;
        let mixed = |a: f64, b: f64| a * (b / a).powf(part);
        Self {
            epsilon: mixed(a.epsilon, b.epsilon),
            contrast: mixed(a.contrast, b.contrast),
            resolution: mixed(a.resolution, b.resolution),
            rays: mixed(a.rays.into(), b.rays.into()).round() as u32,
            iterations: b.iterations,
            samples: b.samples,
            gather_rays: b.gather_rays,
        }
    }
}

/// Rays for each of the four points of an element in a local pass: what they find together is to be more exact than a
/// pixel of a final gather, whose noise nobody sees since it is as fine as the pixels.
pub(super) fn local_pass_rays(quality: QualityArg) -> u32 {
    Preset::of(quality).gather_rays / 2
}

impl SolveConfig {
    /// What is typed, and the preset where nothing is.
    fn of(typed: &SolutionArgs, preset: &Preset) -> Self {
        Self::with(&typed.exactness, preset, typed.rays, typed.visibility)
    }

    fn with(typed: &ExactnessArgs, preset: &Preset, rays: Option<u32>, strategy: VisibilityArg) -> Self {
        Self {
            quality: typed.quality,
            epsilon: typed.epsilon.unwrap_or(preset.epsilon),
            contrast: preset.contrast,
            min_size: typed.min_size,
            resolution: preset.resolution,
            rays: rays.unwrap_or(preset.rays),
            iterations: typed.iterations.unwrap_or(preset.iterations),
            strategy,
            certify: typed.certify,
            one_sided: typed.one_sided,
            record: Record::Nothing,
        }
    }
}

impl RunConfig {
    /// Fills in the defaults and checks what depends on several options.
    ///
    /// # Errors
    /// [`CliError::Usage`] when options contradict each other. No file is touched.
    pub(super) fn check(
        scene: PathBuf,
        outputs: Vec<PathBuf>,
        solution: SolutionArgs,
        machine: MachineArgs,
        quiet: bool,
    ) -> Result<Self, CliError> {
        if solution.exactness.certify && solution.visibility == VisibilityArg::Sampled {
            return usage("--certify needs proofs, and --visibility sampled makes none");
        }
        if machine.library.embree_lib.is_some() && machine.tracer == TracerArg::Fallback {
            return usage("--embree-lib has no use with --tracer fallback");
        }
        let preset = Preset::of(solution.exactness.quality);
        Ok(Self {
            scene,
            outputs,
            solve: SolveConfig::of(&solution, &preset),
            stored: None,
            tracer: machine.tracer,
            embree_lib: machine.library.embree_lib,
            threads: machine.library.threads,
            quiet,
        })
    }
}

impl ViewConfig {
    fn of(typed: PictureArgs, exposure: Exposure, kind: ViewArg) -> Self {
        let PictureArgs { width, height, samples } = typed;
        Self { width, height, samples, exposure, kind }
    }

    /// Samples per pixel of a solution of this quality.
    pub(super) fn samples(&self, quality: QualityArg) -> u32 {
        self.samples.unwrap_or(Preset::of(quality).samples)
    }
}

impl Lighting {
    /// Rays for a pixel of a solution of this quality, if it is gathered.
    pub(super) fn rays(self, quality: QualityArg) -> Option<u32> {
        match self {
            Lighting::Reconstructed => None,
            Lighting::Gathered(typed) => Some(typed.unwrap_or(Preset::of(quality).gather_rays)),
        }
    }
}

impl RenderConfig {
    /// Fills in the defaults and checks what depends on several options.
    ///
    /// # Errors
    /// [`CliError::Usage`] when options contradict each other, [`CliError::Output`] when the
    /// extension of the output names no format. No file is touched.
    pub(super) fn check(typed: RenderArgs) -> Result<Self, CliError> {
        let format = PictureFormat::of(&typed.output)?;
        let (views, video) = Views::check(typed.views, &typed.output)?;
        let of_display = [("--exposure", typed.exposure.is_some()), ("--tone", typed.tone.is_some())];
        if let Some((option, _)) = of_display.into_iter().find(|(_, is_typed)| *is_typed) {
            if format != PictureFormat::Png && video.is_none() {
                return usage(&format!(
                    "{option} has no use with .exr and .hdr, which hold radiance as it is"
                ));
            }
            if !matches!(typed.view, ViewArg::Shaded | ViewArg::Mesh) {
                return usage(&format!("{option} has no use with a heat map, whose colours have a legend"));
            }
        }
        if typed.layers && (format != PictureFormat::Exr || typed.view != ViewArg::Shaded) {
            return usage("--layers is for .exr and --view shaded; nothing else has a place for them");
        }
        if typed.final_gather && typed.view != ViewArg::Shaded {
            return usage("--final-gather is for --view shaded; the other views show elements as they are");
        }
        let stored = typed.stored.stored;
        if stored.is_some() && typed.view == ViewArg::Cost {
            return usage(
                "--view cost needs the work of solving by node, which a solution file does not keep",
            );
        }
        if typed.reference.is_some() && typed.view != ViewArg::Shaded {
            return usage("--reference is compared with --view shaded, and no other view");
        }
        if typed.reference.is_some() && !matches!(views, Views::One { .. }) {
            return usage("--reference is compared with one picture; render it by itself");
        }
        let (one, path) = match &views {
            Views::One { output, .. } => (Some(output), None),
            Views::Sequence { motion: Motion::Path(file, _), .. } => (None, Some(file)),
            _ => (None, None),
        };
        let video_path = video.as_ref().map(|video| &video.path);
        let inputs = [Some(&typed.scene), stored.as_ref(), typed.reference.as_ref(), path];
        let written = [video_path, typed.statistics.stats.as_ref()];
        check_distinct(&[&inputs[..], &[one], &written].concat())?;
        check_extension("--stats", typed.statistics.stats.as_deref(), "json")?;
        let view = ViewConfig::of(typed.picture, checked_exposure(typed.exposure)?, typed.view);
        let outputs = written.into_iter().flatten().cloned().collect();
        let inputs = inputs.into_iter().flatten().cloned().collect();
        let run = RunConfig::check(typed.scene, outputs, typed.solution, typed.machine, typed.print.quiet)?;
        let mut run = RunConfig { stored, ..run };
        if typed.view == ViewArg::Cost {
            run.solve.record = Record::Work;
        }
        let lighting = match typed.final_gather {
            true => Lighting::Gathered(typed.gather_rays),
            false => Lighting::Reconstructed,
        };
        Ok(Self {
            run,
            inputs,
            views,
            format,
            tone: typed.tone.map_or(Tone::Filmic, Tone::from),
            layers: typed.layers,
            video,
            stats: typed.statistics.stats,
            view,
            lighting,
            reference: typed.reference,
        })
    }
}

impl ProbeConfig {
    /// Checks what depends on several options.
    ///
    /// # Errors
    /// [`CliError::Usage`] when options contradict each other or the output is neither CSV nor JSON.
    pub(super) fn check(typed: ProbeArgs) -> Result<Self, CliError> {
        let extension = typed.output.as_ref().map(|path| {
            path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
        });
        if extension.as_ref().is_some_and(|e| e != "csv" && e != "json") {
            return usage("the name of the table must end in .csv or .json");
        }
        let stored = typed.stored.stored;
        let inputs = [Some(&typed.scene), stored.as_ref(), typed.points.as_ref(), typed.reference.as_ref()];
        check_distinct(&[&inputs[..], &[typed.output.as_ref()]].concat())?;
        let places = match (typed.points, typed.grid) {
            (Some(_), _) if typed.spacing.is_some() => {
                return usage("--spacing is for --grid, and has no use with --points");
            }
            (Some(file), _) => Places::File(file),
            (None, Some(grid)) => Places::Grid(grid, typed.spacing),
            (None, None) => return usage("give --points FILE or --grid NAME|HEIGHT"),
        };
        let outputs = typed.output.iter().cloned().collect();
        let run = RunConfig::check(typed.scene, outputs, typed.solution, typed.machine, typed.print.quiet)?;
        Ok(Self {
            run: RunConfig { stored, ..run },
            places,
            output: typed.output,
            is_json: extension.as_deref() == Some("json"),
            lux: typed.lux,
            samples: typed.samples,
            reference: typed.reference,
        })
    }
}

impl CheckConfig {
    /// Fills in the defaults and checks what depends on several options.
    ///
    /// # Errors
    /// [`CliError::Usage`] when options contradict each other. No file is touched.
    pub(super) fn check(typed: CheckArgs) -> Result<Self, CliError> {
        let stored = typed.stored.stored;
        check_distinct(&[Some(&typed.scene), stored.as_ref(), typed.json.as_ref()])?;
        check_extension("--json", typed.json.as_deref(), "json")?;
        let outputs = typed.json.iter().cloned().collect();
        let run = RunConfig::check(typed.scene, outputs, typed.solution, typed.machine, typed.print.quiet)?;
        Ok(Self { run: RunConfig { stored, ..run }, json: typed.json })
    }
}

/// Files that are read or written must not be the same.
fn check_distinct(files: &[Option<&PathBuf>]) -> Result<(), CliError> {
    let files: Vec<&PathBuf> = files.iter().copied().flatten().collect();
    (1..files.len()).try_for_each(|index| check_apart(files[index], files[..index].iter().copied()))
}

/// A file must be none of others.
pub(super) fn check_apart<'a>(
    file: &Path,
    mut others: impl Iterator<Item = &'a PathBuf>,
) -> Result<(), CliError> {
    if others.any(|other| is_same_file(file, other)) {
        return usage(&format!("{} is named twice, for two different files", file.display()));
    }
    Ok(())
}

/// What is written says what it is, and does not go over a mesh by mistake.
fn check_extension(option: &str, path: Option<&Path>, wanted: &str) -> Result<(), CliError> {
    let is_right = |path: &Path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(wanted));
    match path {
        Some(path) if !is_right(path) => {
            usage(&format!("{option} {}: the name must end in .{wanted}", path.display()))
        }
        _ => Ok(()),
    }
}

/// Refuses to write over a file that the scene was read from.
pub(super) fn check_not_read(outputs: &[PathBuf], read: &[PathBuf]) -> Result<(), CliError> {
    for output in outputs {
        if let Some(read) = read.iter().find(|read| is_same_file(output, read)) {
            let (output, read) = (output.display(), read.display());
            return usage(&format!("{output} would be written over {read}, which the scene is read from"));
        }
    }
    Ok(())
}

fn usage<T>(message: &str) -> Result<T, CliError> {
    Err(CliError::Usage(message.to_owned()))
}

/// The exposure in the precision of the picture, where it must still be a positive number.
fn checked_exposure(typed: Option<f64>) -> Result<Exposure, CliError> {
    match typed.map(|multiplier| multiplier as f32) {
        None => Ok(Exposure::Automatic),
        Some(multiplier) if multiplier.is_normal() => Ok(Exposure::Fixed(multiplier)),
        Some(_) => usage("--exposure must lie between 1e-37 and 1e38"),
    }
}

/// Whether two paths name one file, as far as can be told; a file that does not exist yet is
/// compared by its folder and name.
fn is_same_file(a: &Path, b: &Path) -> bool {
    let canonical = |path: &Path| {
        path.canonicalize().ok().or_else(|| {
            let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
            Some(folder.canonicalize().ok()?.join(path.file_name()?))
        })
    };
    a == b || matches!((canonical(a), canonical(b)), (Some(a), Some(b)) if a == b)
}

#[cfg(test)]
mod tests {
    use super::super::args::{Arguments, Verb};
    use super::*;
    use clap::Parser;

    fn check(options: &[&str]) -> Result<RenderConfig, CliError> {
        let typed = ["lightshaft", "render", "a.toml", "-o"].iter().chain(options);
        match Arguments::try_parse_from(typed).expect("the grammar accepts this").verb {
            Verb::Render(typed) => RenderConfig::check(*typed),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn quality_sets_what_is_not_set_by_hand() {
        let draft = check(&["a.png", "--quality", "draft"]).expect("valid");
        let normal = check(&["a.png"]).expect("valid");
        let mixed = check(&["a.png", "--quality", "draft", "--rays", "9"]).expect("valid");
        assert!(
            draft.run.solve.epsilon > normal.run.solve.epsilon
                && draft.run.solve.rays < normal.run.solve.rays
        );
        let samples = |config: &RenderConfig| config.view.samples(config.run.solve.quality);
        assert!(samples(&draft) < samples(&normal));
        assert_eq!((mixed.run.solve.rays, mixed.run.solve.epsilon), (9, draft.run.solve.epsilon));
        assert_eq!(normal.run.solve.strategy, VisibilityArg::Adaptive);
    }

    #[test]
    fn options_that_contradict_each_other_are_refused() {
        for (options, word) in [
            (&["a.png", "--certify", "--visibility", "sampled"][..], "--certify"),
            (&["a.png", "--tracer", "fallback", "--embree-lib", "x.so"], "--embree-lib"),
            (&["a.exr", "--exposure", "2"], "--exposure"),
            (&["a.png", "--exposure", "1e300"], "--exposure"),
            (&["a.png", "--exposure", "2", "--view", "cost"], "--exposure"),
            (&["a.png", "--stats", "a.png"], "a.png"),
            (&["a.png", "--stats", "./a.png"], "a.png"),
            (&["a.png", "--stats", "a.toml"], "a.toml"),
            (&["a.png", "--solution", "./a.png"], "a.png"),
        ] {
            match check(options) {
                Err(CliError::Usage(message)) => assert!(message.contains(word), "{message}"),
                other => panic!("{options:?} gave {other:?}"),
            }
        }
    }

    #[test]
    fn an_unknown_extension_is_an_output_error() {
        assert!(matches!(check(&["a.jpg"]), Err(CliError::Output(_))));
        assert_eq!(check(&["a.EXR"]).expect("valid").format, PictureFormat::Exr);
    }
}
