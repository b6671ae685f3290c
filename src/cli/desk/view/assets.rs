//! The files that the page is made of, built in.

/// A file: its type, and what is in it.
pub struct Asset {
    /// `Content-Type`.
    pub kind: &'static str,
    /// Pieces, one after the other.
    pub content: &'static [&'static str],
}

const SCRIPT: &str = "text/javascript; charset=utf-8";

/// The file at this path, if there is one.
pub fn find(path: &str) -> Option<Asset> {
    let (kind, content): (_, &'static [&'static str]) = match path {
        "/" => ("text/html; charset=utf-8", &[include_str!("page.html")]),
        // The colours and tables of all of gripd's pages, then what this one has beyond them.
        "/page.css" => (
            "text/css; charset=utf-8",
            &[include_str!("../../../lab/report/page.css"), include_str!("view.css")],
        ),
        "/page.js" => (SCRIPT, &[include_str!("page.js")]),
        "/plot.js" => (SCRIPT, &[include_str!("plot.js")]),
        "/icon.svg" => ("image/svg+xml", &[include_str!("icon.svg")]),
        _ => return None,
    };
    Some(Asset { kind, content })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_asks_for_nothing_that_is_not_here() {
        let page = find("/").unwrap().content.concat();
        for attribute in ["href=\"", "src=\""] {
            for reference in page.split(attribute).skip(1) {
                let path = format!("/{}", reference.split('"').next().unwrap());
                assert!(find(&path).is_some(), "{path}");
            }
        }
        for path in ["/", "/page.css", "/page.js", "/plot.js", "/icon.svg"] {
            let text = find(path).unwrap().content.concat().replace("http://www.w3.org/2000/svg", "");
            for outside in ["http:", "https:", "//cdn", "@import", "url("] {
                assert!(!text.contains(outside), "{outside} in {path}");
            }
            assert!(!text.contains("style=\"") && !text.contains("onclick"), "the policy forbids it: {path}");
        }
    }
}
