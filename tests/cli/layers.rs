//! Pictures for further work: the layers of an EXR, HDR, and plain colours.

use std::f32::consts::PI;

use exr::prelude::{FlatSamples, read_first_flat_layer_from_file};

use crate::run::Folder;

/// Renders the scene into a file.
fn render(folder: &Folder, output: &str, options: &[&str]) {
    let base = ["render", "scene.toml", "-o", output, "--quality", "draft", "-q"];
    let run = folder.run(&[&base[..], options].concat());
    assert_eq!((run.code, run.stderr.as_str()), (0, ""), "{options:?}: {run:?}");
}

/// The channels of a file, by name.
pub(crate) struct Channels(Vec<(String, FlatSamples)>);

impl Channels {
    pub(crate) fn of(folder: &Folder, name: &str) -> Channels {
        let image = read_first_flat_layer_from_file(folder.path(name)).expect("an EXR");
        let channels = image.layer_data.channel_data.list;
        Channels(
            channels.into_iter().map(|channel| (channel.name.to_string(), channel.sample_data)).collect(),
        )
    }

    fn samples(&self, name: &str) -> &FlatSamples {
        let found = self.0.iter().find(|(known, _)| known == name);
        &found.unwrap_or_else(|| panic!("no channel {name}")).1
    }

    pub(crate) fn floats(&self, name: &str) -> &[f32] {
        match self.samples(name) {
            FlatSamples::F32(values) => values,
            other => panic!("{name}: {other:?}"),
        }
    }

    pub(crate) fn ids(&self, name: &str) -> &[u32] {
        match self.samples(name) {
            FlatSamples::U32(values) => values,
            other => panic!("{name}: {other:?}"),
        }
    }
}

#[test]
fn layers_say_what_radiance_is_made_of() {
    let folder = Folder::with_scene();
    render(&folder, "plain.exr", &["--samples", "1"]);
    render(&folder, "a.exr", &["--samples", "1", "--layers", "--threads", "1"]);
    render(&folder, "b.exr", &["--samples", "1", "--layers", "--threads", "3"]);
    let bytes = ["a.exr", "b.exr"].map(|name| std::fs::read(folder.path(name)).expect("a file"));
    assert!(bytes[0] == bytes[1], "threads have a say");
    let [plain, all] = ["plain.exr", "a.exr"].map(|name| Channels::of(&folder, name));
    let names: Vec<&str> = all.0.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(
        names,
        [
            "B",
            "G",
            "R",
            "albedo.B",
            "albedo.G",
            "albedo.R",
            "class.id",
            "depth.Z",
            "element.id",
            "irradiance.B",
            "irradiance.G",
            "irradiance.R",
            "normal.X",
            "normal.Y",
            "normal.Z"
        ]
    );
    let (elements, depth) = (all.ids("element.id"), all.floats("depth.Z"));
    let mut lit = 0;
    for channel in ["R", "G", "B"] {
        let radiance = all.floats(channel);
        assert_eq!(radiance, plain.floats(channel), "layers change the picture");
        let [albedo, irradiance] =
            ["albedo", "irradiance"].map(|layer| all.floats(&format!("{layer}.{channel}")));
        for pixel in 0..radiance.len() {
            // The lamp reflects nothing.
            if albedo[pixel] > 0.0 {
                let expected = albedo[pixel] * irradiance[pixel] / PI;
                assert!((radiance[pixel] - expected).abs() <= 1e-5 * expected, "{channel} {pixel}");
                lit += usize::from(expected > 0.0);
            }
        }
    }
    assert!(lit > 1500, "{lit}");
    let normal = ["X", "Y", "Z"].map(|axis| all.floats(&format!("normal.{axis}")));
    let (mut seen, mut floor) = (0, 0);
    for pixel in 0..depth.len() {
        let length = normal.iter().map(|axis| axis[pixel] * axis[pixel]).sum::<f32>();
        if depth[pixel].is_finite() {
            seen += 1;
            assert!((length - 1.0).abs() < 1e-5 && elements[pixel] != u32::MAX, "{pixel}");
            // The wall lies in the plane z = -1, and the camera in z = 4 looks nearly along it.
            if normal[2][pixel] > 0.99 {
                assert!((depth[pixel] - 5.0).abs() < 0.1, "{}", depth[pixel]);
            }
            floor += usize::from(normal[1][pixel] > 0.99);
        } else {
            assert_eq!((length, elements[pixel], all.ids("class.id")[pixel]), (0.0, u32::MAX, 0));
        }
    }
    assert!(seen > 500 && seen < depth.len() && floor > 100, "{seen} {floor}");
    let classes = all.ids("class.id");
    assert!(classes.contains(&3) && classes.iter().any(|&class| class == 1 || class == 2), "{classes:?}");
    assert!(classes.iter().all(|&class| class <= 3));
}

#[test]
fn hdr_holds_radiance_to_a_hundredth() {
    let folder = Folder::with_scene();
    render(&folder, "a.exr", &["--samples", "2"]);
    render(&folder, "a.hdr", &["--samples", "2"]);
    let [exact, rounded] = ["a.exr", "a.hdr"]
        .map(|name| image::open(folder.path(name)).expect("a picture").into_rgb32f().into_raw());
    assert_eq!(exact.len(), rounded.len());
    assert!(exact.iter().any(|&value| value > 1.0));
    for (exact, rounded) in exact.chunks(3).zip(rounded.chunks(3)) {
        let most = exact.iter().copied().fold(0.0, f32::max);
        assert!(
            exact.iter().zip(rounded).all(|(a, b)| (a - b).abs() <= 0.01 * most),
            "{exact:?} {rounded:?}"
        );
    }
}

#[test]
fn plain_colours_are_those_of_radiance() {
    let folder = Folder::with_scene();
    let exposure = ["--samples", "1", "--exposure", "0.5"];
    render(&folder, "a.exr", &["--samples", "1"]);
    render(&folder, "plain.png", &[&exposure[..], &["--tone", "plain"]].concat());
    render(&folder, "filmic.png", &[&exposure[..], &["--tone", "filmic"]].concat());
    render(&folder, "default.png", &exposure);
    let [plain, filmic, default] = ["plain.png", "filmic.png", "default.png"]
        .map(|name| image::open(folder.path(name)).expect("a picture").into_rgb8().into_raw());
    assert!(filmic == default && filmic != plain);
    let radiance = image::open(folder.path("a.exr")).expect("a picture").into_rgb32f().into_raw();
    for (byte, radiance) in plain.iter().zip(radiance) {
        let linear = (radiance * 0.5).min(1.0);
        let exact =
            if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
        assert!((f32::from(*byte) - exact * 255.0).abs() <= 1.001, "{byte} for {}", exact * 255.0);
    }
}

#[test]
fn what_has_no_place_in_a_picture_is_refused() {
    let folder = Folder::with_scene();
    for (output, options, parts) in [
        ("a.png", &["--layers"][..], &["--layers", ".exr"]),
        ("a.hdr", &["--layers"], &["--layers", ".exr"]),
        ("a.exr", &["--layers", "--view", "mesh"], &["--layers", "--view shaded"]),
        ("a.exr", &["--tone", "plain"], &["--tone", ".exr"]),
        ("a.hdr", &["--exposure", "2"], &["--exposure", ".hdr"]),
        ("a.png", &["--tone", "plain", "--view", "cost"], &["--tone", "heat map"]),
    ] {
        folder.run(&[&["render", "scene.toml", "-o", output], options].concat()).expect_error(2, parts);
    }
    let run = folder.run(&["render", "scene.toml", "-o", "a.png", "--tone", "vivid"]);
    assert!(run.code == 2 && run.stderr.contains("plain"), "{run:?}");
    assert_eq!(folder.names(), ["corner.obj", "scene.toml"]);
}
