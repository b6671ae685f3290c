//! Between the one who watches and the browsers: the last minutes, and news for all.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use hyper::body::Bytes;
use tokio::sync::broadcast;

use bus::watch::Series;

/// What each browser is told first, and then over and over.
pub struct Hub {
    /// As JSON; never changes.
    meta: String,
    past: Mutex<Past>,
    news: broadcast::Sender<Bytes>,
}

/// Rows as JSON, made once for all browsers.
#[derive(Default)]
struct Past {
    pieces: VecDeque<(usize, Arc<str>)>,
    rows: usize,
    /// The newest word on everything that is no row.
    now: String,
}

/// News of one moment.
pub struct News {
    /// Rows since the last news: JSON arrays, separated by commas.
    pub rows: String,
    /// How many.
    pub count: usize,
    /// All rows so far are of another time: the clock was set back.
    pub anew: bool,
    /// An object.
    pub now: String,
}

impl Hub {
    /// News that wait for a browser at most; then it has missed the oldest, and is told everything anew.
    const WAITING: usize = 16;

    /// Nothing has happened yet.
    pub fn new(meta: String) -> Self {
        Self { meta, past: Mutex::default(), news: broadcast::Sender::new(Self::WAITING) }
    }

    /// The past is in order after every statement, so a panic of another holder does no harm.
    fn past(&self) -> MutexGuard<'_, Past> {
        self.past.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Tells everybody. Never waits for anybody.
    pub fn tell(&self, news: News) {
        let event = event(
            "update",
            &format!("{{\"anew\":{},\"rows\":[{}],\"now\":{}}}", news.anew, news.rows, news.now),
        );
        let mut past = self.past();
        if news.anew {
            *past = Past::default();
        }
        if news.count > 0 {
            past.rows += news.count;
            past.pieces.push_back((news.count, news.rows.into()));
        }
        while past.pieces.front().is_some_and(|(count, _)| past.rows - count >= Series::KEPT) {
            if let Some((count, _)) = past.pieces.pop_front() {
                past.rows -= count;
            }
        }
        past.now = news.now;
        // Within the lock: who subscribes meanwhile has these rows either in the past or as news. That nobody
        // listens is no error.
        let _ = self.news.send(event);
    }

    /// All so far, and what comes after it. `None` while nothing has been told at all.
    pub fn subscribe(&self) -> (Option<Bytes>, broadcast::Receiver<Bytes>) {
        let past = self.past();
        let news = self.news.subscribe();
        if past.now.is_empty() {
            return (None, news);
        }
        let pieces: Vec<&str> = past.pieces.iter().map(|(_, rows)| rows.as_ref()).collect();
        let rows = pieces.join(",");
        let hello = format!("{{\"meta\":{},\"rows\":[{rows}],\"now\":{}}}", self.meta, past.now);
        (Some(event("hello", &hello)), news)
    }
}

/// A server-sent event. JSON has no line breaks, so one line of data will do.
fn event(name: &str, json: &str) -> Bytes {
    Bytes::from(format!("event: {name}\ndata: {json}\n\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn news(row: &str) -> News {
        News { rows: row.into(), count: 1, anew: false, now: "{}".into() }
    }

    fn text(bytes: Option<Bytes>) -> String {
        String::from_utf8(bytes.unwrap().to_vec()).unwrap()
    }

    #[test]
    fn who_comes_late_hears_the_past_and_nothing_twice() {
        let hub = Hub::new("{\"name\":1}".into());
        assert!(hub.subscribe().0.is_none());
        hub.tell(news("[1]"));
        hub.tell(news("[2]"));
        let (hello, mut receiver) = hub.subscribe();
        assert_eq!(
            text(hello),
            "event: hello\ndata: {\"meta\":{\"name\":1},\"rows\":[[1],[2]],\"now\":{}}\n\n"
        );
        hub.tell(news("[3]"));
        let update = receiver.try_recv().unwrap();
        assert_eq!(text(Some(update)), "event: update\ndata: {\"anew\":false,\"rows\":[[3]],\"now\":{}}\n\n");
        assert!(receiver.try_recv().is_err());
    }

    #[test]
    fn the_past_is_bounded_and_ends_where_the_clock_was_set_back() {
        let hub = Hub::new("{}".into());
        for row in 0..Series::KEPT + 50 {
            hub.tell(news(&format!("[{row}]")));
        }
        let hello = text(hub.subscribe().0);
        assert!(!hello.contains("[49]") && hello.contains("[50]"), "{}", &hello[..100]);
        hub.tell(News { anew: true, ..news("[7]") });
        assert!(text(hub.subscribe().0).contains("\"rows\":[[7]]"));
    }

    #[test]
    fn who_does_not_listen_misses_the_oldest_and_holds_up_nobody() {
        let hub = Hub::new("{}".into());
        let (_, mut slow) = hub.subscribe();
        for row in 0..100 {
            hub.tell(news(&format!("[{row}]")));
        }
        assert!(matches!(slow.try_recv(), Err(broadcast::error::TryRecvError::Lagged(84))));
        assert!(text(slow.try_recv().ok()).contains("[84]"));
    }
}
