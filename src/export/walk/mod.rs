//! Solved scenes as a page to walk through: one file with the triangles, their light and a WebGL library, which a browser
//! opens without anything else. `docs/export.md` says what is in it.

mod data;
mod library;
mod panel;

pub use library::{WebLibrary, WebLibraryError};

use std::io::{self, Write};
use std::path::Path;

use serde_json::{Value, json};

use super::lit::{Display, Exported, LitScene, too_far};
use crate::image::write::{OutputError, write_atomically};
use crate::image::{Heat, HeatMap};
use crate::progress::Progress;
use crate::scene::Camera;
use data::{packed, packed_part};

/// What browsers open with some memory to spare, bytes: the text, what it unpacks to and the copy of the graphics card are
/// there at the same time.
const MOST_BYTES: u64 = 256 << 20;

/// The parts of the script, one module.
const SCRIPT: [&str; 4] =
    [include_str!("shader.js"), include_str!("data.js"), include_str!("walker.js"), include_str!("page.js")];

/// Writes a lit scene as a page, whole or not at all. One unit of progress for each side of a surface, of a phase that the
/// caller has started.
///
/// # Errors
/// When the folder is missing or not writable, the disk is full, the page would have more than 256 MiB or numbers do not fit
/// single precision; then `path` is as before.
pub fn write_walk(
    path: &Path,
    lit: LitScene<'_>,
    display: Display,
    library: &WebLibrary,
    progress: &dyn Progress,
) -> Result<Exported, OutputError> {
    let mut exported = Exported::default();
    write_atomically(path, |file| {
        let mut page = Page { to: file, bytes: 0, most: MOST_BYTES };
        exported = page.fill(lit, display, library, progress)?;
        Ok::<(), io::Error>(())
    })?;
    Ok(exported)
}

/// A page on its way to its file.
struct Page<'a> {
    to: &'a mut dyn Write,
    bytes: u64,
    most: u64,
}

impl Page<'_> {
    fn fill(
        &mut self,
        lit: LitScene<'_>,
        display: Display,
        library: &WebLibrary,
        progress: &dyn Progress,
    ) -> io::Result<Exported> {
        let LitScene { scene, hierarchy, solution } = lit;
        let square_meters = hierarchy.square_meters_per_unit(scene.meters_per_unit);
        let classes = HeatMap::new(hierarchy, solution, square_meters, Heat::Class, &[]);
        let legend = classes.legend();
        let cameras =
            scene.cameras.iter().map(|camera| described(camera, lit)).collect::<Result<Vec<_>, _>>()?;
        let settings = json!({
            "cameras": cameras,
            "exposure": display.exposure,
            "tone": display.tone.name(),
            "classes": legend.entries.iter().map(|(colour, _)| colour).collect::<Vec<_>>(),
        });

        self.text(&panel::head(&scene.name))?;
        self.text(&panel::body(lit, display, &legend, &library.licence))?;
        // It waits for all that follows, and says so when that was cut off.
        self.script("module", "", &SCRIPT.concat())?;
        // Within a script nothing but its end counts, and no text of JSON needs this letter.
        let settings = settings.to_string().replace('<', "\\u003c");
        self.script("application/json", "id=\"settings\"", &settings)?;
        let mut exported = Exported::default();
        lit.for_each_part(Some(&|element| 1 + classes.class(element)), progress, |part| {
            let (vertices, triangles) = (part.vertices.len(), part.triangles.len());
            let attributes =
                format!("class=\"part\" data-vertices=\"{vertices}\" data-triangles=\"{triangles}\"");
            self.script("application/octet-stream", &attributes, &packed_part(part, display.exposure)?)?;
            exported.vertices += vertices as u64;
            exported.triangles += triangles as u64;
            Ok(())
        })?;
        for (id, text) in [("three-core", &library.core), ("three-module", &library.module)] {
            self.script("application/octet-stream", &format!("id=\"{id}\""), &packed(text.as_bytes())?)?;
        }
        self.text("</body>\n</html>\n")?;
        exported.bytes = self.bytes;
        Ok(exported)
    }

    fn script(&mut self, kind: &str, attributes: &str, content: &str) -> io::Result<()> {
        self.text(&format!("<script type=\"{kind}\" {attributes}>"))?;
        self.text(content)?;
        self.text("</script>\n")
    }

    fn text(&mut self, text: &str) -> io::Result<()> {
        self.bytes += text.len() as u64;
        if self.bytes > self.most {
            return Err(io::Error::other(format!(
                "a page of more than {} MiB, which browsers do not open; write a GLB, or solve with a lower --quality",
                self.most >> 20
            )));
        }
        self.to.write_all(text.as_bytes())
    }
}

/// Where a camera stands and looks, in metres from the origin.
fn described(camera: &Camera, lit: LitScene<'_>) -> io::Result<Value> {
    let target = lit.eye(&Camera { eye: camera.target, ..camera.clone() });
    let (eye, up) = (lit.eye(camera), camera.up.normalize());
    if ![eye, target].iter().all(|point| point.as_vec3().is_finite()) {
        return Err(too_far());
    }
    Ok(json!({
        "name": camera.name,
        "eye": eye.to_array(),
        "target": target.to_array(),
        "up": up.to_array(),
        "vfov": camera.vfov_deg,
        "aspect": f64::from(camera.width) / f64::from(camera.height),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_that_no_browser_opens_is_refused() {
        let mut written = Vec::new();
        let mut page = Page { to: &mut written, bytes: 0, most: 2 << 20 };
        page.text(&"x".repeat(2 << 20)).expect("as much as fits");
        let refused = page.text("x").expect_err("one byte too many").to_string();
        assert!(refused.contains("2 MiB") && written.len() == 2 << 20, "{refused}");
    }

    #[test]
    fn the_script_does_not_end_early() {
        assert!(!SCRIPT.concat().contains("</script"));
    }
}
