//! [`Page`]: HTML as it is put together, and the pictures that were put in it.

use crate::output::charts::{in_units, sized};
use std::fmt::Display;

const STYLE: &str = include_str!("style.css");
const NAMESPACE: &str = " xmlns=\"http://www.w3.org/2000/svg\"";

/// A picture for a paper: black on white, a file of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Plot {
    /// What it shows, as a file name without its ending.
    pub name: String,
    /// The picture.
    pub svg: String,
}

/// A page that is being written.
pub(super) struct Page {
    html: String,
    plots: Vec<Plot>,
}

impl Page {
    pub(super) fn new(title: &str) -> Self {
        let title = escaped(title);
        let html = format!(
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{title}: closed loop over lossy links</title>\n<style>\n{STYLE}</style></head><body>\n\
             <h1>{title}</h1>\n"
        );
        Self { html, plots: Vec::new() }
    }

    /// Adds HTML as it is.
    pub(super) fn add(&mut self, html: impl Display) {
        self.html += &html.to_string();
        self.html.push('\n');
    }

    pub(super) fn section(&mut self, title: &str) {
        self.add(format_args!("<h2>{}</h2>", escaped(title)));
    }

    pub(super) fn heading(&mut self, title: &str) {
        self.add(format_args!("<h3>{}</h3>", escaped(title)));
    }

    pub(super) fn paragraph(&mut self, text: &str) {
        self.add(format_args!("<p>{}</p>", escaped(text)));
    }

    /// What is added by `inside` stands beside each other where there is room.
    pub(super) fn grid(&mut self, inside: impl FnOnce(&mut Self)) {
        self.add("<div class=\"grid\">");
        inside(self);
        self.add("</div>");
    }

    /// What is added by `inside` is one place of a grid.
    pub(super) fn cell(&mut self, inside: impl FnOnce(&mut Self)) {
        self.add("<div>");
        inside(self);
        self.add("</div>");
    }

    /// What is added by `inside` is shown on demand.
    pub(super) fn folded(&mut self, summary: &str, inside: impl FnOnce(&mut Self)) {
        self.add(format_args!("<details><summary>{}</summary>", escaped(summary)));
        inside(self);
        self.add("</details>");
    }

    /// A chart; `name` is that of its file, `caption` may be empty.
    pub(super) fn figure(&mut self, name: &str, svg: String, caption: &str) {
        self.picture("", name, svg, caption);
    }

    /// A picture that is scrolled through where the screen is narrow.
    pub(super) fn wide_figure(&mut self, name: &str, svg: String, caption: &str) {
        self.picture(" class=\"wide\" tabindex=\"0\"", name, svg, caption);
    }

    fn picture(&mut self, attributes: &str, name: &str, svg: String, caption: &str) {
        let label = format!("<svg role=\"img\" aria-label=\"{}\"", escaped(&name.replace('-', " ")));
        let shown = sized(&svg, "").replacen(NAMESPACE, "", 1).replacen("<svg", &label, 1);
        let caption = match caption {
            "" => String::new(),
            text => format!("<figcaption>{}</figcaption>", escaped(text)),
        };
        self.add(format_args!("<figure><div{attributes}>{shown}</div>{caption}</figure>"));
        self.plots.push(Plot { name: name.into(), svg: in_units(&svg) });
    }

    /// The finished page and its pictures.
    pub(super) fn finish(mut self) -> (String, Vec<Plot>) {
        self.add("</body></html>");
        (self.html, self.plots)
    }
}

/// Text as HTML.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
