//! What is answered, and to whom.

use super::*;

fn status(answer: &str) -> &str {
    answer.split(' ').nth(1).unwrap_or(answer)
}

#[test]
fn the_page_and_its_parts_come_with_a_strict_policy() {
    let server = Server::start("1");
    for (path, kind, within) in [
        ("/", "text/html; charset=utf-8", "<title>gripd view</title>"),
        ("/page.css", "text/css; charset=utf-8", "prefers-color-scheme: dark"),
        ("/page.js", "text/javascript; charset=utf-8", "EventSource"),
        ("/plot.js", "text/javascript; charset=utf-8", "class Plot"),
        ("/icon.svg", "image/svg+xml", "<svg"),
    ] {
        let answer = server.get(path);
        assert_eq!(status(&answer), "200", "{path}");
        let (head, body) = answer.split_once("\r\n\r\n").unwrap();
        let head = head.to_ascii_lowercase();
        for line in [
            &format!("content-type: {kind}"),
            "x-content-type-options: nosniff",
            "x-frame-options: deny",
            "referrer-policy: no-referrer",
            "cross-origin-resource-policy: same-origin",
            "cache-control: no-store",
            &format!("content-length: {}", body.len()),
        ] {
            assert!(head.contains(line), "{path}: no `{line}` in {head}");
        }
        let policy = head.lines().find_map(|line| line.strip_prefix("content-security-policy: ")).unwrap();
        assert!(
            policy.starts_with("default-src 'none';") && !policy.contains("unsafe") && !policy.contains('*')
        );
        assert!(!head.contains("access-control"), "{head}");
        assert!(body.contains(within), "{path}: {body}");
    }
    assert_eq!(status(&server.get("/../Cargo.toml")), "404");
    assert_eq!(status(&server.get("/nothing")), "404");
}

#[test]
fn other_names_and_other_methods_are_refused() {
    let server = Server::start("1");
    for (request, expected) in [
        ("GET / HTTP/1.1\r\nHost: localhost\r\n", "200"),
        ("GET / HTTP/1.1\r\nHost: [::1]:9\r\n", "200"),
        ("GET / HTTP/1.1\r\nHost: evil.example\r\n", "403"),
        ("GET /events HTTP/1.1\r\nHost: evil.example:8470\r\n", "403"),
        ("GET /events HTTP/1.1\r\nHost: localhost\r\nSec-Fetch-Site: cross-site\r\n", "403"),
        ("GET / HTTP/1.1\r\nHost: localhost\r\nOrigin: https://evil.example\r\n", "403"),
        ("GET / HTTP/1.1\r\n", "403"),
        ("GET / HTTP/1.0\r\n", "403"),
        ("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n", "405"),
        ("DELETE /events HTTP/1.1\r\nHost: localhost\r\n", "405"),
        ("nonsense\r\n", "400"),
    ] {
        let answer = server.ask(&format!("{request}Connection: close\r\n\r\n"));
        assert_eq!(status(&answer), expected, "{request}: {answer}");
        if expected == "405" {
            assert!(answer.to_ascii_lowercase().contains("allow: get"), "{answer}");
        }
    }
}

#[test]
fn events_begin_with_the_past_and_go_on() {
    let server = Server::start("20");
    // From the first word of all.
    let mut early = server.events();
    let (name, hello) = early.next();
    assert_eq!(name, "hello");
    let columns = hello["meta"]["columns"].as_array().unwrap().len();
    assert_eq!(
        (hello["meta"]["name"].as_str(), hello["meta"]["driven"][1].as_str()),
        (Some("drive.log"), Some("fr"))
    );
    let mut rows = hello["rows"].as_array().unwrap().clone();
    let over = |value: &serde_json::Value| value["now"]["remark"] == "the recording is over";
    let mut last = hello.clone();
    while !over(&last) {
        let (name, update) = early.next();
        assert_eq!(name, "update");
        assert_eq!(update["anew"], false);
        rows.extend(update["rows"].as_array().unwrap().iter().cloned());
        last = update;
    }
    assert!((290..=301).contains(&rows.len()), "{} rows", rows.len());
    assert!(rows.iter().all(|row| row.as_array().unwrap().len() == columns + 1));
    let times: Vec<f64> = rows.iter().map(|row| row[0].as_f64().unwrap()).collect();
    assert!(times.is_sorted() && times.windows(2).all(|pair| pair[0] < pair[1]));
    // Who comes late has all of it at once.
    let (name, late) = server.events().next();
    assert_eq!((name.as_str(), late["rows"].as_array()), ("hello", Some(&rows)));
    assert!(late["now"]["estimates"]["speed"].as_f64().unwrap() > 1.0);
    assert_eq!(late["now"]["messages"].as_array().unwrap().len(), 7);
}

#[test]
fn browsers_that_do_not_read_hold_up_nobody() {
    let server = Server::start("5");
    let silent: Vec<TcpStream> = (0..5).map(|_| server.connect()).collect();
    let stalled: Vec<Events> = (0..10).map(|_| server.events()).collect();
    let mut reading: Vec<Events> = (0..3).map(|_| server.events()).collect();
    for events in &mut reading {
        assert_eq!(events.next().0, "hello");
    }
    for _ in 0..10 {
        for events in &mut reading {
            assert_eq!(events.next().0, "update");
        }
    }
    assert_eq!(status(&server.get("/")), "200");
    drop((silent, stalled));
}

#[test]
fn what_cannot_be_is_said() {
    let log = drive().to_str().unwrap();
    let taken = Server::start("1");
    let there = taken.address.to_string();
    for (arguments, code, expected) in [
        (&["-c", CAR, log, "--listen", "0.0.0.0:0"][..], 2, "ssh -L"),
        (&["-c", CAR, log, "--listen", "[::]:0"], 2, "from outside"),
        (&["-c", CAR, log, "--listen", "nowhere"], 2, "--listen"),
        (&["-c", CAR, log, "--listen", &there], 1, "another port"),
        (&["-c", "none.toml", log, "--listen", "127.0.0.1:0"], 2, "none.toml"),
        (&["-c", CAR, "none.log", "--listen", "127.0.0.1:0"], 1, "none.log"),
    ] {
        let output = Command::new(GRIPD).arg("view").args(arguments).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
        assert!(said.contains(expected), "{arguments:?}: {said}");
    }
}
