//! Pages: the answer of a command as one HTML file that needs nothing else, with words first, then plots, tables
//! that sort, pictures, and what the run was made with.
//!
//! Every text goes through the templates of `maud`, which escape it. Nothing is loaded: styles, scripts and pictures
//! are part of the file, and its content policy forbids everything else.

mod compare;
mod figures;
mod profile;
mod table;
mod work;

pub use compare::{Shown, write_compare};
pub use profile::{ShownMap, write_profile};

use std::path::Path;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::look::COLOURS;
use super::setup::Setup;
use super::text::printable;
use crate::image::write::{FillError, OutputError, write_atomically};

/// Colours of plots on a dark page, in the order of [`COLOURS`].
const DARK: [&str; 6] = ["#6bb1ff", "#ff8a75", "#3fd09c", "#d79bee", "#f0b94a", "#b4b4b4"];

/// Nothing comes from elsewhere.
const POLICY: &str =
    "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

/// What one page holds.
struct Page {
    /// In the tab and at the top.
    title: String,
    /// Whether the answer is a good one, in a word or two.
    verdict: Option<(bool, String)>,
    /// In words.
    summary: Vec<String>,
    /// One below the other.
    sections: Vec<Section>,
}

/// A part of a page under its own heading.
struct Section {
    heading: &'static str,
    body: Markup,
}

impl Page {
    fn write(&self, path: &Path, setup: &Setup) -> Result<(), OutputError> {
        let text = self.markup(setup).into_string();
        write_atomically(path, |file| file.write_all(printable(&text).as_bytes()).map_err(FillError::Io))
    }

    fn markup(&self, setup: &Setup) -> Markup {
        html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta http-equiv="Content-Security-Policy" content=(POLICY);
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="color-scheme" content="light dark";
                    title { (self.title) }
                    style { (PreEscaped(include_str!("page.css"))) (PreEscaped(plot_colours())) }
                }
                body {
                    main {
                        header {
                            h1 { (self.title) }
                            @if let Some((is_good, words)) = &self.verdict {
                                p.verdict.good[*is_good].bad[!*is_good] { (words) }
                            }
                            @for paragraph in &self.summary { p { (paragraph) } }
                        }
                        @for section in &self.sections {
                            section { h2 { (section.heading) } (section.body) }
                        }
                        section { h2 { "How to repeat this" } (repeat(setup)) }
                    }
                    script { (PreEscaped(include_str!("page.js"))) }
                }
            }
        }
    }
}

/// The command and everything it stood for.
fn repeat(setup: &Setup) -> Markup {
    let embree = setup.embree.as_deref().unwrap_or("not used");
    let versions = [("lightshaft", setup.lightshaft.as_str()), ("Embree", embree)];
    let settings = setup.values.iter().map(|setting| (setting.name, setting.value.as_str()));
    html! {
        pre tabindex="0" { code { (setup.command) } }
        div.scroll tabindex="0" role="region" aria-label="Settings and versions" {
            table.settings {
                tbody {
                    @for (name, value) in versions.into_iter().chain(settings) {
                        tr { th scope="row" { (name) } td { (value) } }
                    }
                }
            }
        }
    }
}

/// Rules that give what `plotters` draws the colours of the page: it knows only fixed ones.
fn plot_colours() -> String {
    let hex = |index: usize| {
        let plotters::style::RGBColor(red, green, blue) = COLOURS[index];
        format!("#{red:02X}{green:02X}{blue:02X}")
    };
    let variables = |colour: &dyn Fn(usize) -> String| -> String {
        (0..COLOURS.len()).map(|index| format!("--c{index}:{};", colour(index))).collect()
    };
    let mut rules = format!(
        "\n:root{{{}}}\n@media(prefers-color-scheme:dark){{:root{{{}}}}}\n",
        variables(&hex),
        variables(&|index| DARK[index].to_owned())
    );
    let mut rule = |fixed: &str, of_page: &str| {
        rules += &format!(
            "figure svg [fill=\"{fixed}\"]{{fill:{of_page}}}figure svg [stroke=\"{fixed}\"]{{stroke:{of_page}}}\n"
        );
    };
    rule("#FFFFFF", "var(--card)");
    rule("#000000", "var(--text)");
    for index in 0..COLOURS.len() {
        rule(&hex(index), &format!("var(--c{index})"));
    }
    rules
}

#[cfg(test)]
mod tests;
