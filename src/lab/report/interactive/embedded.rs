//! The plots in a page: where they stand, their numbers as JSON, and what draws them.

use super::Plots;
use crate::report::escape;

const LIBRARY: &str = include_str!("../uplot/uPlot.iife.min.js");
const LIBRARY_STYLE: &str = include_str!("../uplot/uPlot.min.css");
const LIBRARY_LICENSE: &str = include_str!("../uplot/LICENSE");
const OWN_STYLE: &str = include_str!("page.css");
const SCRIPTS: [&str; 5] = [
    include_str!("look.js"),
    include_str!("legend.js"),
    include_str!("panel.js"),
    include_str!("figure.js"),
    include_str!("page.js"),
];
/// A browser that is told so loads nothing, whatever stands in the page.
const POLICY: &str =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

/// What goes to the three places of a page that has plots.
#[derive(Clone, Debug, Default)]
pub struct Embedded {
    /// Into its head.
    pub head: String,
    /// Where the plots are to be seen.
    pub place: String,
    /// Behind everything.
    pub end: String,
}

impl Plots {
    /// In parts of a page. Where the numbers cannot be written as JSON, that stands in the plots' place.
    pub fn embedded(&self) -> Embedded {
        let data = match serde_json::to_string(self) {
            // No text in it can end the element that it stands in.
            Ok(data) => data.replace('<', "\\u003c"),
            Err(reason) => {
                let place = format!("<p>The plots cannot be drawn: {}</p>\n", escape(&reason.to_string()));
                return Embedded { place, ..Embedded::default() };
            }
        };
        let figures = "<section id=\"figures\" aria-label=\"One quantity over another\"></section>\n";
        let panels = "<section id=\"panels\" aria-label=\"Over time\"></section>\n";
        let (first, second) = if self.panels_first { (panels, figures) } else { (figures, panels) };
        Embedded {
            head: format!(
                "<meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\"/>\n\
                 <style>\n{LIBRARY_STYLE}{OWN_STYLE}</style>\n"
            ),
            place: format!(
                "<section class=\"plots\">\n{tools}<div id=\"plots\">\n{first}{second}</div>\n</section>\n",
                tools = include_str!("tools.html"),
            ),
            end: format!(
                "<script type=\"application/json\" id=\"data\">{data}</script>\n\
                 <script>\n/*\n{LIBRARY_LICENSE}\n*/\n{LIBRARY}</script>\n<script>\n{script}</script>\n",
                script = SCRIPTS.join("\n"),
            ),
        }
    }
}
