//! What stands on the page besides the scene: the controls, the legend, help, and whose work it is.

use maud::{DOCTYPE, PreEscaped, html};

use super::super::lit::{Display, LitScene};
use crate::image::Legend;
use crate::image::tone::Tone;

/// Nothing comes from elsewhere; the library is unpacked into modules of the page's own.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline' blob:; \
                      base-uri 'none'; form-action 'none'";

/// Keys and what they do.
const KEYS: [(&str, &str); 9] = [
    ("W A S D, arrows", "go forward, left, back, right; in orbit: go around and over"),
    ("Q, E", "go down, up; in orbit: farther, nearer"),
    ("I J K L", "look up, left, down, right"),
    ("Shift", "with these: three times as fast"),
    ("O, F", "orbit, fly"),
    ("1 to 9", "go to a camera"),
    ("R", "back to the camera"),
    ("− , +", "darker, brighter by a quarter of a stop"),
    ("M, C", "element mesh, class colours"),
];

/// Buttons for those without keys: the key, what it does, and the shape on it.
const PAD: [(&str, &str, &str); 6] = [
    ("KeyQ", "down", "M1 2h8v1H1zM1 4h8L5 9z"),
    ("KeyW", "forward", "M1 8h8L5 2z"),
    ("KeyE", "up", "M1 7h8v1H1zM1 6h8L5 1z"),
    ("KeyA", "left", "M8 1v8L2 5z"),
    ("KeyS", "back", "M1 2h8L5 8z"),
    ("KeyD", "right", "M2 1v8l6-4z"),
];

/// Up to the body.
pub(super) fn head(name: &str) -> String {
    let head = html! {
        head {
            meta charset="utf-8";
            meta http-equiv="Content-Security-Policy" content=(POLICY);
            meta name="viewport" content="width=device-width, initial-scale=1";
            meta name="color-scheme" content="light dark";
            link rel="icon" href="data:,";
            title { (name) " – lightshaft" }
            style { (PreEscaped(include_str!("page.css"))) }
        }
    };
    format!("{}\n<html lang=\"en\">\n{}\n<body>\n", DOCTYPE.into_string(), head.into_string())
}

/// What is seen, but for the scene itself.
pub(super) fn body(lit: LitScene<'_>, display: Display, legend: &Legend, licence: &str) -> String {
    let elements = lit.shown().leaves().count();
    let checked = |tone: Tone| (tone == display.tone).then_some("checked");
    let body = html! {
        canvas #view tabindex="0" role="application" aria-label="The scene: drag to look, keys to move; see Help" {}
        p #status role="status" { "Unpacking the light …" }
        noscript { p.alarm { "This page needs JavaScript and WebGL 2. Nothing is loaded from elsewhere." } }
        div #pad hidden role="group" aria-label="Move" {
            @for (key, label, shape) in PAD {
                button type="button" data-key=(key) aria-label=(label) {
                    svg viewBox="0 0 10 10" aria-hidden="true" { path d=(shape) {} }
                }
            }
        }
        details #panel open {
            summary { (lit.scene.name) }
            div.row {
                label for="camera" { "Camera" }
                select #camera {
                    @for (index, camera) in lit.scene.cameras.iter().enumerate() {
                        option value=(index) { (camera.name) }
                    }
                }
                button #back type="button" title="Back to the camera (R)" { "Back" }
            }
            fieldset {
                legend { "Move" }
                label { input type="radio" name="move" value="orbit" checked; "Orbit" }
                label { input type="radio" name="move" value="fly"; "Fly" }
            }
            div.row {
                label for="speed" { "Speed" }
                input #speed type="range" min="-4" max="4" step="0.5" value="0";
                output #pace for="speed" { "× 1" }
            }
            div.row {
                label for="stops" { "Exposure" }
                input #stops type="range" min="-10" max="10" step="0.25" value="0";
                output #exposure for="stops" {}
            }
            fieldset {
                legend { "Tone" }
                label { input type="radio" name="tone" value="filmic" checked=[checked(Tone::Filmic)]; "Filmic" }
                label { input type="radio" name="tone" value="plain" checked=[checked(Tone::Plain)]; "Plain" }
            }
            fieldset {
                legend { "Show" }
                label { input #mesh type="checkbox"; "Element mesh" }
                label { input #classes type="checkbox"; "Class colours" }
            }
            div #legend hidden {
                p { (legend.title) }
                ul {
                    @for ([red, green, blue], words) in &legend.entries {
                        li { span.swatch style={ "background:rgb(" (red) "," (green) "," (blue) ")" } {} span { (words) } }
                    }
                }
            }
            details {
                summary { "Help" }
                p {
                    "Drag to look around; in orbit the camera goes around what it looked at. The wheel, or two fingers, go nearer \
                     and farther; two fingers together, or the right button, move sideways. Walls do not stop you."
                }
                dl { @for (keys, what) in KEYS { dt { (keys) } dd { (what) } } }
                p {
                    "Exposure is in stops from where the page began, and the multiplier beside it is that of "
                    code { "render --exposure" } ". Black is where nothing is, or no light."
                }
            }
            details {
                summary { "About" }
                p {
                    "Light solved by lightshaft " (env!("CARGO_PKG_VERSION")) ": " (elements) " elements, "
                    span #counts {} ". Surfaces are matt; light inside a triangle is interpolated."
                }
                p { "Drawn by three.js" span #release {} ":" }
                pre tabindex="0" { (licence) }
            }
        }
    };
    format!("{}\n", body.into_string())
}
