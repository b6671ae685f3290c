//! `gripd view`: a bus or a recording, watched on a web page that this process serves to browsers of this machine.

mod assets;
mod hub;
mod news;
mod request;
mod server;
mod watcher;

use std::io::Write;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::thread;

use clap::Args;
use tokio::net::TcpListener;
use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::oneshot;

use super::Failure;
use super::watched::Watched;
use hub::Hub;

/// A page with live plots: friction, slip slopes, cornering stiffness, sideslip, and what they are made from. What is
/// shown of the estimates is decoded from the frames that a gripd publishes, their checksums and counters checked.
/// With --estimate, or on a recording, the same estimators run here. Nothing is ever sent on the bus.
#[derive(Args)]
pub struct View {
    #[command(flatten)]
    watched: Watched,
    /// Where the page is served: a port of the loopback interface. Port 0: any that is free.
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1:8470", value_parser = address)]
    listen: SocketAddr,
}

/// An address with its port, or a port of the loopback.
fn address(text: &str) -> Result<SocketAddr, &'static str> {
    let of_port = |port| SocketAddr::from((Ipv4Addr::LOCALHOST, port));
    text.parse()
        .or_else(|_| text.parse().map(of_port))
        .map_err(|_| "write ADDRESS:PORT, as 127.0.0.1:8470, or PORT")
}

impl View {
    /// Serves it until a signal ends it.
    pub fn run(self) -> Result<(), Failure> {
        let address = self.listen;
        if !address.ip().is_loopback() {
            return Err(Failure::usage(format_args!(
                "--listen {address}: can be reached from outside, and there is no password; listen on \
                 127.0.0.1:PORT, and from another machine use `ssh -L {port}:127.0.0.1:{port}`",
                port = address.port()
            )));
        }
        let subject = self.watched.prepare()?;
        let hub = Arc::new(Hub::new(news::meta(&subject)));
        let runtime =
            tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(Failure::work)?;
        runtime.block_on(async {
            let mut interrupt = signal(SignalKind::interrupt()).map_err(Failure::work)?;
            let mut terminate = signal(SignalKind::terminate()).map_err(Failure::work)?;
            let listener = TcpListener::bind(address).await.map_err(|error| {
                Failure::work(format_args!(
                    "cannot listen on {address}: {error}; choose another port with --listen 127.0.0.1:PORT"
                ))
            })?;
            // A thread of its own: frames are taken in time, however many browsers there are.
            let (opened, is_open) = oneshot::channel();
            let of_thread = Arc::clone(&hub);
            thread::Builder::new()
                .name("watch".into())
                .spawn(move || watcher::run(subject, &of_thread, opened))
                .map_err(Failure::work)?;
            is_open.await.map_err(|_| Failure::work("the thread that watches ended"))??;
            let address = listener.local_addr().map_err(Failure::work)?;
            writeln!(std::io::stdout(), "http://{address}/")?;
            tracing::info!("the page is at http://{address}/ for browsers of this machine; Ctrl-C ends it");
            tokio::select! {
                () = server::serve(listener, hub) => {}
                _ = interrupt.recv() => {}
                _ = terminate.recv() => {}
            }
            Ok(())
        })
    }
}
