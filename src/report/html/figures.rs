//! Plots and pictures as they stand in a page.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, PreEscaped, html};

use super::super::bars::{self, Group};
use super::super::look::Look;
use super::super::plot::Plot;

/// Widths of a plot, pixels: beside a keyboard and on a phone. The style of the page shows one of them.
const WIDTHS: [(&str, u32); 2] = [("wide", 720), ("narrow", 340)];

/// A plot of curves under its caption; `legend` is what its looks mean.
pub(super) fn curves(caption: &str, legend: &[(String, Look)], plot: &Plot<'_>) -> Result<Markup, String> {
    let drawn = WIDTHS.map(|(class, width)| Ok((class, plot.svg((width, 240 + width / 3))?)));
    Ok(plot_figure(caption, legend, drawn.into_iter().collect::<Result<_, String>>()?))
}

/// Bars under their caption; `legend` is what their looks mean.
pub(super) fn bar_chart(
    caption: &str,
    legend: &[(String, Look)],
    groups: &[Group],
) -> Result<Markup, String> {
    let drawn = WIDTHS.map(|(class, width)| Ok((class, bars::svg(groups, width)?)));
    Ok(plot_figure(caption, legend, drawn.into_iter().collect::<Result<_, String>>()?))
}

fn plot_figure(caption: &str, legend: &[(String, Look)], drawn: Vec<(&str, String)>) -> Markup {
    html! {
        figure.plot {
            figcaption { (caption) }
            @if legend.len() > 1 {
                ul.legend {
                    @for (name, look) in legend {
                        li { span.swatch.hollow[look.is_hollow] style=(format!("color:var(--c{})", look.index)) {} (name) }
                    }
                }
            }
            @for (class, svg) in drawn {
                // The library escapes what it writes.
                div class=(class) role="img" aria-label=(caption) { (PreEscaped(svg)) }
            }
        }
    }
}

/// A picture within a page.
pub(super) struct Image {
    /// A PNG file.
    pub(super) png: Vec<u8>,
    /// What it is, for those who do not see it.
    pub(super) name: String,
}

impl Image {
    fn markup(&self, class: &str, [width, height]: [u32; 2]) -> Markup {
        let source = format!("data:image/png;base64,{}", STANDARD.encode(&self.png));
        html! { img class=(class) src=(source) alt=(self.name) width=(width) height=(height); }
    }
}

/// Two pictures of one size in one frame; a slider moves the border between them.
pub(super) fn wipe([first, second]: [&Image; 2], size: [u32; 2], caption: &str) -> Markup {
    html! {
        figure.picture.wipe style=(width_of(size)) {
            div.frame {
                (second.markup("below", size))
                (first.markup("above", size))
                span.border {}
            }
            label.slider {
                span { (first.name) }
                input type="range" min="0" max="100" step="1" value="50"
                    aria-label=(format!("Share of the picture that shows {}, the rest shows {}", first.name, second.name));
                span { (second.name) }
            }
            figcaption { (caption) }
        }
    }
}

/// One picture.
pub(super) fn picture(image: &Image, size: [u32; 2], caption: &str) -> Markup {
    html! {
        figure.picture style=(width_of(size)) {
            div.frame { (image.markup("below", size)) }
            figcaption { (caption) }
        }
    }
}

/// As wide as it is, but not so small that it cannot be seen.
fn width_of([width, _]: [u32; 2]) -> String {
    format!("max-width:{}px", width.max(320))
}
