//! Which requests are answered: those that a browser of this machine makes for this page, and no others.
//!
//! A page from elsewhere can make a browser ask this server for things, and by a name server of its own that says
//! `127.0.0.1` for its name it could even read the answer. So the name that was asked for must be this machine's.

use hyper::header::{HOST, HeaderMap, ORIGIN};
use hyper::{Method, Request, StatusCode, Version};

/// Why a request is not answered.
pub fn refusal<B>(request: &Request<B>) -> Option<(StatusCode, &'static str)> {
    if request.method() != Method::GET {
        return Some((StatusCode::METHOD_NOT_ALLOWED, "This page can only be read: GET.\n"));
    }
    let headers = request.headers();
    let mut hosts = headers.get_all(HOST).iter();
    let named = match (hosts.next(), hosts.next(), request.version()) {
        (Some(host), None, _) => host.to_str().is_ok_and(is_this_machine),
        // Before HTTP/1.1 there need not be one; no browser is that old.
        _ => false,
    };
    let asked = request.uri().authority().is_none_or(|authority| is_this_machine(authority.as_str()));
    if !named || !asked || request.version() > Version::HTTP_11 {
        return Some((
            StatusCode::FORBIDDEN,
            "This page answers to localhost, 127.0.0.1 and [::1], and to no other name.\n",
        ));
    }
    if is_from_elsewhere(headers, request.uri().path()) {
        return Some((StatusCode::FORBIDDEN, "Another site asks for this.\n"));
    }
    None
}

/// `localhost`, or an address of the loopback interface, with or without a port.
fn is_this_machine(authority: &str) -> bool {
    let (host, port) = match authority.rsplit_once(':') {
        // Of `[::1]` the last colon is within the brackets.
        Some((host, port)) if !port.ends_with(']') => (host, port),
        _ => (authority, "0"),
    };
    if port.is_empty() || !port.bytes().all(|digit| digit.is_ascii_digit()) {
        return false;
    }
    let address = host.strip_prefix('[').and_then(|host| host.strip_suffix(']'));
    match address {
        Some(six) => six.parse::<std::net::Ipv6Addr>().is_ok_and(|address| address.is_loopback()),
        None if host.eq_ignore_ascii_case("localhost") => true,
        None => host.parse::<std::net::Ipv4Addr>().is_ok_and(|address| address.is_loopback()),
    }
}

/// A link to the page may be followed from anywhere; its parts are for the page itself.
fn is_from_elsewhere(headers: &HeaderMap, path: &str) -> bool {
    let text = |name: &str| headers.get(name).map(|value| value.to_str().unwrap_or("?"));
    let site = text("sec-fetch-site");
    let origin = headers.get(ORIGIN).map(|origin| origin.to_str().unwrap_or("?"));
    let foreign = origin.is_some_and(|origin| {
        !origin.split_once("://").is_some_and(|(_, authority)| is_this_machine(authority))
    });
    foreign || (path != "/" && matches!(site, Some("cross-site" | "same-site")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(method: &str, uri: &str, headers: &[(&str, &str)]) -> Option<u16> {
        let mut request = Request::builder().method(method).uri(uri);
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        refusal(&request.body(()).unwrap()).map(|(status, _)| status.as_u16())
    }

    #[test]
    fn this_machine_by_any_of_its_names() {
        for host in
            ["127.0.0.1", "127.0.0.1:8470", "localhost:1", "LocalHost", "[::1]:8470", "[::1]", "127.9.9.9"]
        {
            assert_eq!(asked("GET", "/", &[("host", host)]), None, "{host}");
        }
        assert_eq!(asked("GET", "http://localhost:8470/", &[("host", "localhost:8470")]), None);
    }

    #[test]
    fn no_other_name() {
        for host in [
            "evil.example",
            "evil.example:8470",
            "127.0.0.1.evil.example",
            "localhost.evil.example",
            "192.168.1.2",
            "0.0.0.0",
            "[::2]",
            "",
            ":8470",
            "127.0.0.1:",
            "127.0.0.1:80x",
            "127.1",
            "2130706433",
            "user@localhost",
            "localhost:80:80",
            "[::1",
            "::1",
        ] {
            assert_eq!(asked("GET", "/", &[("host", host)]), Some(403), "{host}");
        }
        assert_eq!(asked("GET", "/", &[]), Some(403), "none at all");
        assert_eq!(asked("GET", "/", &[("host", "localhost"), ("host", "localhost")]), Some(403), "two");
        assert_eq!(asked("GET", "http://evil.example/", &[("host", "localhost")]), Some(403));
    }

    #[test]
    fn nothing_but_reading() {
        for method in ["POST", "PUT", "DELETE", "OPTIONS", "PATCH", "HEAD", "TRACE", "CONNECT"] {
            assert_eq!(asked(method, "/", &[("host", "localhost")]), Some(405), "{method}");
        }
    }

    #[test]
    fn other_sites_do_not_get_its_parts() {
        let host = ("host", "localhost:8470");
        let site = |site| ("sec-fetch-site", site);
        assert_eq!(asked("GET", "/events", &[host, site("cross-site")]), Some(403));
        assert_eq!(asked("GET", "/events", &[host, site("same-origin")]), None);
        assert_eq!(asked("GET", "/", &[host, site("cross-site")]), None, "a link that is followed");
        assert_eq!(asked("GET", "/", &[host, ("origin", "https://evil.example")]), Some(403));
        assert_eq!(asked("GET", "/", &[host, ("origin", "null")]), Some(403));
        assert_eq!(asked("GET", "/", &[host, ("origin", "http://localhost:8470")]), None);
    }
}
