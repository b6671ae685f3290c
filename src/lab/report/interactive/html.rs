//! The file: words as HTML, numbers as JSON, and what draws them.

use thiserror::Error;

use super::Document;
use crate::report::escape;

const LIBRARY: &str = include_str!("../uplot/uPlot.iife.min.js");
const LIBRARY_STYLE: &str = include_str!("../uplot/uPlot.min.css");
const LIBRARY_LICENSE: &str = include_str!("../uplot/LICENSE");
/// Colours, and how all our pages look.
const STYLE: &str = include_str!("../page.css");
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

/// A page that could not be written down.
#[derive(Debug, Error)]
#[error("the page `{title}`: its numbers cannot be written as JSON: {reason}")]
pub struct HtmlError {
    title: String,
    reason: serde_json::Error,
}

impl Document {
    /// The whole file.
    ///
    /// # Errors
    /// If its data cannot be written as JSON.
    pub fn html(&self) -> Result<String, HtmlError> {
        let data =
            serde_json::to_string(self).map_err(|reason| HtmlError { title: self.title.clone(), reason })?;
        // No text in it can end the element that it stands in.
        let data = data.replace('<', "\\u003c");
        let title = escape(&self.title);
        let script = SCRIPTS.join("\n");
        Ok(format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\"/>\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
             <meta name=\"color-scheme\" content=\"light dark\"/>\n<title>{title}</title>\n\
             <style>\n{LIBRARY_STYLE}</style>\n<style>\n{STYLE}{OWN_STYLE}</style>\n</head>\n<body>\n\
             <main class=\"interactive\">\n{head}<noscript><p>The plots are drawn by a script in this page, and scripts \
             are switched off.</p></noscript>\n{frame}{notes}</main>\n<footer>gripd {version}. Plots drawn with uPlot, \
             whose licence stands in this file.</footer>\n\
             <script type=\"application/json\" id=\"data\">{data}</script>\n\
             <script>\n/*\n{LIBRARY_LICENSE}\n*/\n{LIBRARY}</script>\n<script>\n{script}</script>\n</body>\n</html>\n",
            head = self.head(&title),
            frame = include_str!("frame.html"),
            notes = self.notes(),
            version = env!("CARGO_PKG_VERSION"),
        ))
    }

    fn head(&self, title: &str) -> String {
        let mut head =
            format!("<header><h1>{title}</h1><p class=\"lead\">{}</p></header>\n", escape(&self.lead));
        if !self.facts.is_empty() {
            head += "<dl class=\"facts\">\n";
            for fact in &self.facts {
                head += &format!(
                    "<div><dt>{}</dt><dd>{}</dd><dd class=\"note\">{}</dd></div>\n",
                    escape(&fact.name),
                    escape(&fact.value),
                    escape(&fact.note)
                );
            }
            head += "</dl>\n";
        }
        head
    }

    fn notes(&self) -> String {
        let mut notes = String::from("<section id=\"notes\">\n<h2>How to read this</h2>\n");
        for note in &self.notes {
            notes += &format!("<p>{}</p>\n", escape(note));
        }
        notes + "</section>\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Color;
    use crate::report::interactive::{Clock, Mark, Numbers, Panel, Series, Source};

    #[test]
    fn text_cannot_become_markup_or_script() {
        let mut document = Document { title: "<b>".into(), lead: "a & b".into(), ..Document::default() };
        document.clocks.push(Clock { from_s: 0.0, utc_s: None, name: "</script><script>alert(1)".into() });
        document.marks.push(Mark { at_s: 0.0, name: "<!--".into() });
        let html = document.html().unwrap();
        assert!(html.contains("<h1>&lt;b&gt;</h1>") && html.contains("a &amp; b"));
        assert!(!html.contains("alert(1)\"") || html.contains("\\u003c/script>\\u003cscript>alert(1)"));
        assert_eq!(html.matches("</script>").count(), 3, "data, library, ours");
        let data = html.split("id=\"data\">").nth(1).unwrap().split("</script>").next().unwrap();
        let data: serde_json::Value = serde_json::from_str(data).unwrap();
        assert_eq!(data["clocks"][0]["name"], "</script><script>alert(1)");
    }

    #[test]
    fn nothing_is_loaded_from_elsewhere() {
        let html = Document::default().html().unwrap();
        for attribute in ["src=", "href=", "@import", "url("] {
            assert!(!html.contains(attribute), "{attribute}");
        }
        assert!(html.contains("default-src 'none'"));
        assert!(html.contains("Permission is hereby granted"), "the library's licence");
    }

    #[test]
    fn a_panel_without_data_says_so() {
        let mut document = Document::default();
        document.panel(Panel::new("Speed", "speed, km/h"));
        let values = Numbers::new(vec![1.0]);
        let series = Series {
            name: "s".into(),
            source: Source::Measured,
            color: Color::First,
            values,
            interval: None,
        };
        document.panel(Panel { series: vec![series.clone()], ..Panel::new("Yaw", "yaw rate, °/s") });
        // A column without a number, its interval likewise.
        let none = || Numbers::new(vec![f64::NAN; 3]);
        let unknown = Series { values: none(), interval: Some((none(), none())), ..series };
        document.panel(Panel { series: vec![unknown], ..Panel::new("Stiffness", "1/rad") });
        let says_so: Vec<bool> = document.panels.iter().map(|panel| !panel.empty.is_empty()).collect();
        assert_eq!(says_so, [true, false, true]);
    }
}
