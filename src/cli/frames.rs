//! From a solution to pictures and a video: what is shown, how bright it is, and one picture after the other.

use std::path::PathBuf;
use std::slice;
use std::time::Instant;

use super::args::ViewArg;
use super::config::RenderConfig;
use super::console;
use super::errors::CliError;
use super::shots::Shots;
use super::solved::Solved;
use crate::image::picture::Picture;
use crate::image::tone::{self, Exposure, Tone, automatic_exposure, srgb_bytes};
use crate::image::video::{Video, VideoShape};
use crate::image::write::{OutputError, PictureFormat, write_layers, write_picture};
use crate::image::{self, Heat, HeatMap, LayerMaker, Layers, RenderOptions, Renderer, View};
use crate::progress::Progress;
use crate::scene::Camera;

/// What came out.
pub(super) struct Made {
    /// How many pictures.
    pub(super) frames: u32,
    /// Seconds they took, without what is done once for all of them.
    pub(super) seconds: f64,
    /// The last picture.
    pub(super) last: Picture,
    /// What the colours mean, if that has to be said.
    pub(super) legends: String,
}

/// Renders all pictures and writes each as soon as it is there, while the next one is made.
///
/// # Errors
/// When a picture or the video cannot be written. Pictures that have been written stay.
pub(super) fn make(
    config: &RenderConfig,
    shots: &Shots<'_>,
    cameras: &[Camera],
    solved: &Solved,
    progress: &dyn Progress,
) -> Result<Made, CliError> {
    let Solved { scene, hierarchy, tracer, solution, quality, .. } = solved;
    let (view, heat) = looked_at(config.view.kind, config.lighting.rays(*quality));
    let options = RenderOptions { samples: config.view.samples(*quality), view };
    let renderer = Renderer::new(hierarchy, tracer.as_ref(), solution, options, progress);
    let square_meters = hierarchy.square_meters_per_unit(scene.meters_per_unit);
    let map_of = |cameras: &[Camera]| {
        let heat = heat?;
        let seen = image::seen(hierarchy, tracer.as_ref(), solution, cameras);
        Some(HeatMap::new(hierarchy, solution, square_meters, heat, &seen))
    };
    // Pictures that follow each other must not flicker, so they share one scale; others are as they are by themselves.
    let is_sequence = shots.is_sequence();
    let is_exposed = heat.is_none() && (config.format == PictureFormat::Png || config.video.is_some());
    let shared_map = if is_sequence { map_of(cameras) } else { None };
    let shared_exposure = match config.view.exposure {
        _ if !is_exposed => None,
        Exposure::Fixed(multiplier) => Some(multiplier),
        Exposure::Automatic if is_sequence => Some(image::shared_exposure(&renderer, cameras)),
        Exposure::Automatic => None,
    };
    if let Some(exposure) = shared_exposure.filter(|_| is_sequence) {
        say_exposure(config, "the pictures", exposure);
    }
    let mut legends = shared_map.as_ref().map(|map| map.legend().to_string()).unwrap_or_default();

    shots.make_folder()?;
    let maker = config.layers.then(|| LayerMaker::new(&renderer));
    let (format, tone) = (config.format, config.tone);
    let mut writer = Writer { format, tone, video: video_of(config, cameras)?, black: Vec::new() };
    let started = Instant::now();
    progress.start("render", cameras.iter().map(|camera| u64::from(camera.height)).sum());
    let mut last: Option<Shot> = None;
    for (camera, file) in cameras.iter().zip(&shots.files) {
        let own_map = if is_sequence { None } else { map_of(slice::from_ref(camera)) };
        let map = shared_map.as_ref().or(own_map.as_ref());
        // A picture is encoded while the next one is made.
        let (written, picture) = rayon::join(
            || last.take().map_or(Ok(()), |shot| writer.write(&shot)),
            || match map {
                Some(map) => renderer.heat(camera, map, progress),
                None => renderer.picture(camera, progress),
            },
        );
        written?;
        let what = if cameras.len() > 1 {
            format!("the picture of camera '{}'", camera.name)
        } else {
            "the picture".to_owned()
        };
        if let Some(map) = &own_map {
            if cameras.len() > 1 {
                legends += &format!("{what}: ");
            }
            legends += &map.legend().to_string();
        }
        let exposure = shared_exposure.or_else(|| {
            let chosen = is_exposed.then(|| automatic_exposure(&picture))?;
            say_exposure(config, &what, chosen);
            Some(chosen)
        });
        let layers = maker.as_ref().map(|maker| maker.layers(camera));
        last = Some(Shot { picture, exposure, layers, file: file.clone() });
    }
    let Some(shot) = last else { return Err(CliError::Internal("no picture was asked for".to_owned())) };
    writer.write(&shot)?;
    let black = writer.finish()?;
    progress.finish();
    if !config.run.quiet && !black.is_empty() {
        warn_of_black(&black, cameras);
    }
    let seconds = started.elapsed().as_secs_f64();
    Ok(Made { frames: cameras.len() as u32, seconds, last: shot.picture, legends })
}

/// The video that is asked for.
fn video_of(config: &RenderConfig, cameras: &[Camera]) -> Result<Option<Video>, OutputError> {
    let shape = |rate| VideoShape { width: cameras[0].width, height: cameras[0].height, rate };
    config.video.as_ref().map(|video| Video::begin(&video.path, shape(video.rate))).transpose()
}

/// A picture that is to be written.
struct Shot {
    picture: Picture,
    /// Multiplier on radiance; colours that are none are written as they are.
    exposure: Option<f32>,
    layers: Option<Layers>,
    file: PathBuf,
}

/// Takes pictures in their order.
struct Writer {
    format: PictureFormat,
    tone: Tone,
    video: Option<Video>,
    /// Files of pictures in which nothing is seen.
    black: Vec<PathBuf>,
}

impl Writer {
    fn write(&mut self, shot: &Shot) -> Result<(), OutputError> {
        let Shot { picture, exposure, layers, file } = shot;
        if picture.pixels.iter().all(|&pixel| pixel == [0.0; 3]) {
            self.black.push(file.clone());
        }
        let plain = match (self.tone, exposure) {
            (Tone::Plain, Some(exposure)) => Some(tone::plain(picture, *exposure)),
            _ => None,
        };
        let (shown, exposure) = plain.as_ref().map_or((picture, *exposure), |plain| (plain, None));
        if let Some(video) = &mut self.video {
            video.add(&srgb_bytes(shown, exposure))?;
        }
        match (self.format, layers) {
            (PictureFormat::Png, _) => write_picture(file, shown, exposure),
            (_, Some(layers)) => write_layers(file, picture, layers),
            (_, None) => write_picture(file, picture, exposure),
        }
    }

    /// Ends the video; the answer is which pictures are black.
    fn finish(self) -> Result<Vec<PathBuf>, OutputError> {
        self.video.map_or(Ok(()), Video::finish)?;
        Ok(self.black)
    }
}

fn warn_of_black(black: &[PathBuf], cameras: &[Camera]) {
    let name = &cameras[0].name;
    console::warning(&match (black, cameras) {
        (_, [_]) => format!(
            "the picture is black: camera '{name}' sees nothing that is lit; check its eye and target"
        ),
        ([only], _) => format!("{} is black: nothing that is lit is seen there", only.display()),
        ([first, ..], _) => format!(
            "{} of {} pictures are black, {} the first of them: nothing that is lit is seen there",
            black.len(),
            cameras.len(),
            first.display()
        ),
        ([], _) => return,
    });
}

/// Says which exposure was chosen, if one was.
fn say_exposure(config: &RenderConfig, from: &str, exposure: f32) {
    if config.view.exposure == Exposure::Automatic && !config.run.quiet {
        console::note(&format!("exposure chosen from {from}: {exposure:.4e} (repeat it with --exposure)\n"));
    }
}

/// What pictures show: a view, or figures in its place.
fn looked_at(view: ViewArg, gather_rays: Option<u32>) -> (View, Option<Heat>) {
    match view {
        ViewArg::Shaded => (gather_rays.map_or(View::Shaded, View::Gathered), None),
        ViewArg::Mesh => (View::Mesh, None),
        ViewArg::Cost => (View::Shaded, Some(Heat::Cost)),
        ViewArg::Links => (View::Shaded, Some(Heat::Links)),
        ViewArg::Class => (View::Shaded, Some(Heat::Class)),
        ViewArg::Partial => (View::Shaded, Some(Heat::Partial)),
    }
}
