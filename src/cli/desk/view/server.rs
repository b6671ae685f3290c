//! HTTP for browsers of this machine: a few files, and a stream of events.

use std::convert::Infallible;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;

use hyper::body::{Body, Bytes, Frame, Incoming};
use hyper::header::{
    ALLOW, CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, HeaderName, HeaderValue, REFERRER_POLICY,
    X_CONTENT_TYPE_OPTIONS, X_FRAME_OPTIONS,
};
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper::{Request, Response, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::TcpListener;
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::{Semaphore, mpsc};

use super::assets;
use super::hub::Hub;
use super::request::refusal;

/// Connections at a time; a browser takes a handful.
const CONNECTIONS: usize = 64;
/// So long a browser may take to say what it wants.
const PATIENCE: Duration = Duration::from_secs(10);

/// Scripts and styles of this server alone, nothing from elsewhere, and in no other page's frame.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; \
                      base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Answers until it is dropped.
pub async fn serve(listener: TcpListener, hub: Arc<Hub>) {
    let connections = Arc::new(Semaphore::new(CONNECTIONS));
    loop {
        let Ok(permit) = Arc::clone(&connections).acquire_owned().await else { return };
        let stream = match listener.accept().await {
            Ok((stream, _)) => stream,
            Err(error) => {
                tracing::debug!("a browser could not be answered: {error}");
                // Out of descriptors, it would be asked again at once.
                tokio::time::sleep(Duration::from_millis(10)).await;
                continue;
            }
        };
        let hub = Arc::clone(&hub);
        tokio::spawn(async move {
            let answer = service_fn(|request| {
                let answer = answer(&request, &hub);
                async move { Ok::<_, Infallible>(answer) }
            });
            let connection = http1::Builder::new()
                .timer(TokioTimer::new())
                .header_read_timeout(PATIENCE)
                .max_buf_size(16 * 1024)
                .serve_connection(TokioIo::new(stream), answer);
            // Browsers go when they like.
            if let Err(error) = connection.await {
                tracing::debug!("a connection ended: {error}");
            }
            drop(permit);
        });
    }
}

fn answer(request: &Request<Incoming>, hub: &Arc<Hub>) -> Response<Answer> {
    const TEXT: &str = "text/plain; charset=utf-8";
    if let Some((status, reason)) = refusal(request) {
        let mut response = response(status, TEXT, Answer::whole(reason.into()));
        if status == StatusCode::METHOD_NOT_ALLOWED {
            response.headers_mut().insert(ALLOW, HeaderValue::from_static("GET"));
        }
        return response;
    }
    match request.uri().path() {
        "/events" => response(StatusCode::OK, "text/event-stream", Answer::events(Arc::clone(hub))),
        path => match assets::find(path) {
            Some(asset) => response(StatusCode::OK, asset.kind, Answer::whole(asset.content.concat().into())),
            None => response(StatusCode::NOT_FOUND, TEXT, Answer::whole("There is nothing here.\n".into())),
        },
    }
}

fn response(status: StatusCode, kind: &'static str, body: Answer) -> Response<Answer> {
    let mut response = Response::new(body);
    *response.status_mut() = status;
    for (name, value) in [
        (CONTENT_TYPE, kind),
        (CONTENT_SECURITY_POLICY, POLICY),
        (X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (X_FRAME_OPTIONS, "DENY"),
        (REFERRER_POLICY, "no-referrer"),
        (CACHE_CONTROL, "no-store"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
        (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    ] {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    response
}

/// The body of an answer.
enum Answer {
    /// All of it.
    Whole(Option<Bytes>),
    /// Events, without end.
    Events(mpsc::Receiver<Bytes>),
}

impl Answer {
    fn whole(text: Bytes) -> Self {
        Self::Whole(Some(text))
    }

    /// Between the news and a browser there is room for one event: what more comes waits in the hub, and only the
    /// newest of it.
    fn events(hub: Arc<Hub>) -> Self {
        let (browser, events) = mpsc::channel(1);
        tokio::spawn(async move {
            // Soon again after the program was started anew.
            let mut next = Some(Bytes::from_static(b"retry: 1000\n\n"));
            let (mut hello, mut news) = hub.subscribe();
            let mut greeted = hello.is_some();
            loop {
                for event in [next.take(), hello.take()].into_iter().flatten() {
                    if browser.send(event).await.is_err() {
                        return;
                    }
                }
                match news.recv().await {
                    Ok(event) if greeted => next = Some(event),
                    // The first word of all, or too many to catch up with: from the beginning.
                    Ok(_) | Err(RecvError::Lagged(_)) => {
                        (hello, news) = hub.subscribe();
                        greeted = hello.is_some();
                    }
                    Err(RecvError::Closed) => return,
                }
            }
        });
        Self::Events(events)
    }
}

impl Body for Answer {
    type Data = Bytes;
    type Error = Infallible;

    fn poll_frame(
        self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, Infallible>>> {
        match self.get_mut() {
            Self::Whole(text) => Poll::Ready(text.take().map(|text| Ok(Frame::data(text)))),
            Self::Events(events) => {
                events.poll_recv(context).map(|event| event.map(|event| Ok(Frame::data(event))))
            }
        }
    }

    fn is_end_stream(&self) -> bool {
        matches!(self, Self::Whole(None))
    }

    fn size_hint(&self) -> hyper::body::SizeHint {
        match self {
            Self::Whole(text) => {
                hyper::body::SizeHint::with_exact(text.as_ref().map_or(0, |text| text.len() as u64))
            }
            Self::Events(_) => hyper::body::SizeHint::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::hub::News;
    use super::*;

    fn tell(hub: &Hub, row: usize) {
        hub.tell(News { rows: format!("[{row}]"), count: 1, anew: false, now: "{}".into() });
    }

    #[test]
    fn a_browser_that_was_asleep_is_told_everything_anew() {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(async {
            let hub = Arc::new(Hub::new("{}".into()));
            let Answer::Events(mut events) = Answer::events(Arc::clone(&hub)) else { panic!() };
            let mut next = async || String::from_utf8(events.recv().await.unwrap().to_vec()).unwrap();
            assert!(next().await.starts_with("retry: "));
            tell(&hub, 0);
            assert!(next().await.contains("event: hello\ndata: {\"meta\":{},\"rows\":[[0]]"));
            tell(&hub, 1);
            assert!(next().await.contains("\"rows\":[[1]]"));
            for row in 2..200 {
                tell(&hub, row);
                tokio::task::yield_now().await;
            }
            // Those that were on their way, then all of it; and from there on what is new.
            let mut caught_up = String::new();
            for _ in 0..5 {
                caught_up = next().await;
                if caught_up.starts_with("event: hello") {
                    break;
                }
            }
            assert!(
                caught_up.contains("\"rows\":[[0],[1],[2],") && caught_up.contains(",[199]]"),
                "{caught_up}"
            );
            tell(&hub, 200);
            assert!(next().await.contains("\"rows\":[[200]]"));
        });
    }
}
