//! A page: one HTML file with its style in it.

use super::interactive::{Embedded, Plots};
use super::markup::escape;
use super::{Plot, PlotError, Shift, shifts};

const STYLE: &str = include_str!("page.css");
/// Said of a plot whose lines do so.
const BEYOND: &str = "What is beyond the scale is drawn along its edge.";

/// A number at the head of a page.
#[derive(Clone, Debug)]
pub struct Fact {
    /// What it is.
    pub name: String,
    /// With its unit.
    pub value: String,
    /// What there is to say of it.
    pub note: String,
}

/// A page in the making, from top to bottom.
#[derive(Clone, Debug)]
pub struct Page {
    title: String,
    body: String,
    /// Of the headings that are to come.
    level: u8,
    /// If there are any to look into.
    plots: Option<Embedded>,
}

impl Page {
    /// Begins with the title, and in a sentence or two what it is about.
    pub fn new(title: &str, lead: &str) -> Self {
        let body =
            format!("<header><h1>{}</h1><p class=\"lead\">{}</p></header>\n", escape(title), escape(lead));
        Self { body, ..Self::empty(title) }
    }

    /// Begins with nothing; `title` is the window's.
    pub fn empty(title: &str) -> Self {
        Self { title: title.into(), body: String::new(), level: 2, plots: None }
    }

    /// Begins a part: what comes until the next one has smaller headings. `id` is where links find it.
    pub fn section(&mut self, id: &str, title: &str, lead: &str) {
        self.level = 3;
        self.body += &format!("<h2 class=\"section\" id=\"{}\">{}</h2>\n", escape(id), escape(title));
        if !lead.is_empty() {
            self.paragraph(lead);
        }
    }

    /// A heading.
    pub fn heading(&mut self, text: &str) {
        self.body += &format!("<h{0}>{1}</h{0}>\n", self.level, escape(text));
    }

    /// Markup as it is. What it is made of must have been through [`escape`].
    pub fn raw(&mut self, markup: &str) {
        self.body += markup;
        self.body.push('\n');
    }

    /// A paragraph.
    pub fn paragraph(&mut self, text: &str) {
        self.body += &format!("<p>{}</p>\n", escape(text));
    }

    /// Numbers beside each other; nothing if there is none.
    pub fn facts(&mut self, facts: &[Fact]) {
        if facts.is_empty() {
            return;
        }
        self.body += "<dl class=\"facts\">\n";
        for Fact { name, value, note } in facts {
            let [name, value, note] = [name, value, note].map(|text| escape(text));
            self.body +=
                &format!("<div><dt>{name}</dt><dd>{value}</dd><dd class=\"note\">{note}</dd></div>\n");
        }
        self.body += "</dl>\n";
    }

    /// Plots to look into, all of a page at once: they share their time and cursor.
    pub fn plots(&mut self, plots: &Plots) {
        let embedded = plots.embedded();
        self.body += &embedded.place;
        self.plots = Some(embedded);
    }

    /// Notes: what is meant, and its explanation.
    pub fn notes(&mut self, notes: &[(&str, &str)]) {
        self.body += "<dl>\n";
        for (term, text) in notes {
            self.body += &format!("<dt>{}</dt><dd>{}</dd>\n", escape(term), escape(text));
        }
        self.body += "</dl>\n";
    }

    /// A plot with its heading, legend, and what to see in it.
    ///
    /// # Errors
    /// If it cannot be drawn.
    pub fn plot(&mut self, heading: &str, plot: &Plot, caption: &str) -> Result<(), PlotError> {
        let svg = plot.svg()?;
        let beyond = if plot.goes_beyond() { BEYOND } else { "" };
        let stop = if caption.is_empty() || beyond.is_empty() || caption.ends_with('.') { "" } else { "." };
        let caption = format!("{caption}{stop} {beyond}");
        self.figure(heading, &plot.legend(), &svg, caption.trim());
        Ok(())
    }

    /// The same of a picture that comes with its legend. Without a heading if that is empty.
    fn figure(&mut self, heading: &str, legend: &str, svg: &str, caption: &str) {
        self.body += "<figure>";
        if !heading.is_empty() {
            self.body += &format!("<h{0}>{1}</h{0}>", self.level, escape(heading));
        }
        self.body += &format!("{legend}<div class=\"scroll\">{svg}</div>");
        if !caption.is_empty() {
            self.body += &format!("<figcaption>{}</figcaption>", escape(caption));
        }
        self.body += "</figure>\n";
    }

    /// How numbers moved when something was learnt.
    pub fn shifts(&mut self, heading: &str, names: (&str, &str), rows: &[Shift], caption: &str) {
        self.figure(heading, &shifts::legend(names.0, names.1), &shifts::svg(heading, rows), caption);
    }

    /// A table: the first cell of a row is its name, the others are numbers.
    pub fn table(&mut self, columns: &[&str], rows: &[Vec<String>]) {
        self.rows("", columns, rows);
    }

    /// A table of words: cells wrap, and the last of a row is what the others amount to.
    pub fn table_of_words(&mut self, columns: &[&str], rows: &[Vec<String>]) {
        self.rows(" class=\"text\"", columns, rows);
    }

    fn rows(&mut self, class: &str, columns: &[&str], rows: &[Vec<String>]) {
        self.body += &format!("<div class=\"scroll\"><table{class}><thead><tr>");
        for column in columns {
            self.body += &format!("<th scope=\"col\">{}</th>", escape(column));
        }
        self.body += "</tr></thead><tbody>\n";
        for row in rows {
            self.body += "<tr>";
            for (index, cell) in row.iter().enumerate() {
                let cell = escape(cell);
                self.body += &if index == 0 {
                    format!("<th scope=\"row\">{cell}</th>")
                } else {
                    format!("<td>{cell}</td>")
                };
            }
            self.body += "</tr>\n";
        }
        self.body += "</tbody></table></div>\n";
    }

    /// The whole file.
    pub fn html(&self) -> String {
        let plots = self.plots.as_ref();
        let (head, end) = plots.map_or(("", ""), |it| (it.head.as_str(), it.end.as_str()));
        let (class, drawn) = match plots {
            Some(_) => {
                (" class=\"interactive\"", ". Plots drawn with uPlot, whose licence stands in this file.")
            }
            None => ("", ""),
        };
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
             <meta name=\"color-scheme\" content=\"light dark\"/>\n<title>{}</title>\n\
             <style>\n{STYLE}</style>\n{head}</head>\n<body>\n<main{class}>\n{}</main>\n\
             <footer>gripd {}{drawn}</footer>\n{end}</body>\n</html>\n",
            escape(&self.title),
            self.body,
            env!("CARGO_PKG_VERSION")
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::interactive::{Clock, Mark};

    #[test]
    fn text_cannot_become_markup() {
        let mut page = Page::new("<b>", "\"a\" & b");
        page.table(&["x", "<y>"], &[vec!["row".into(), "<script>".into()]]);
        let html = page.html();
        assert!(html.contains("<h1>&lt;b&gt;</h1>") && html.contains("&quot;a&quot; &amp; b"));
        assert!(html.contains("<td>&lt;script&gt;</td>") && !html.contains("<script"));
    }

    #[test]
    fn text_in_plots_cannot_become_markup_or_script() {
        let mut plots = Plots::default();
        let name = "</script><script>alert(1)".to_owned();
        plots.clocks.push(Clock { from_s: 0.0, utc_s: None, name, own_s: None });
        plots.marks.push(Mark { at_s: 0.0, name: "<!--".into() });
        let mut page = Page::new("<b>", "a & b");
        page.plots(&plots);
        let html = page.html();
        assert!(html.contains("<h1>&lt;b&gt;</h1>") && html.contains("a &amp; b"));
        assert!(html.contains("\\u003c/script>\\u003cscript>alert(1)"));
        assert_eq!(html.matches("</script>").count(), 3, "data, library, ours");
        let data = html.split("id=\"data\">").nth(1).unwrap().split("</script>").next().unwrap();
        let data: serde_json::Value = serde_json::from_str(data).unwrap();
        assert_eq!(data["clocks"][0]["name"], "</script><script>alert(1)");
    }

    #[test]
    fn nothing_is_loaded_from_elsewhere() {
        let mut page = Page::empty("plots");
        page.plots(&Plots::default());
        let html = page.html();
        for attribute in ["src=", "href=", "@import", "url("] {
            assert!(!html.contains(attribute), "{attribute}");
        }
        assert!(html.contains("default-src 'none'"));
        assert!(html.contains("Permission is hereby granted"), "the library's licence");
    }
}
