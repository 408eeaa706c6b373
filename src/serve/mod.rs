//! The interactive tool: one map, one session, one page, for the browsers of this computer.
//!
//! The page (`page`, embedded) asks, this module answers: points once, then only poses. All work is the core's
//! ([`crate::session`]); nothing here knows how a map is corrected. Only loopback is listened to, every request needs
//! the token of the address that was printed, and `Host` and `Origin` must be this computer's own (`guard`).

mod app;
mod demo;
mod edit;
mod files;
mod guard;
mod jobs;
mod map;
mod open;
mod page;
mod view;
mod walks;
mod wire;

use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::routing::{get, post};
use tokio::runtime::Runtime;

use crate::error::{Error, Result};
use app::App;

/// Largest body of a request that is not a file, bytes.
const MAX_BODY_BYTES: usize = 1 << 16;

/// What to serve.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Options {
    /// The map; `None`: the page asks for one.
    pub input: Option<PathBuf>,
    /// The session's file; `None`: beside the map.
    pub session: Option<PathBuf>,
    /// Where maps go that are dropped on the page.
    pub folder: PathBuf,
    /// Port on 127.0.0.1; 0: any free one.
    pub port: u16,
}

/// A server at work.
#[derive(Debug)]
pub struct Server {
    address: String,
    runtime: Runtime,
    app: Arc<App>,
    task: tokio::task::JoinHandle<std::io::Result<()>>,
}

impl Server {
    /// Listens, and opens the map behind the page's back: the address is good at once.
    ///
    /// # Errors
    /// [`Error::Input`] if the map is not there or the port is taken.
    pub fn start(options: &Options) -> Result<Server> {
        if let Some(input) = &options.input {
            std::fs::File::open(input).map_err(|e| Error::io(input, e))?;
        }
        let taken = |e: std::io::Error| {
            let message =
                format_args!("found that {} cannot be used ({e}), expected a free one", options.port);
            Error::input("--port", message)
        };
        let listener =
            TcpListener::bind(SocketAddr::from((Ipv4Addr::LOCALHOST, options.port))).map_err(taken)?;
        listener.set_nonblocking(true).map_err(taken)?;
        let port = listener.local_addr().map_err(taken)?.port();
        let internal = |e: std::io::Error| Error::Internal(e.to_string());
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(2)
            .max_blocking_threads(16)
            .enable_all()
            .build()
            .map_err(internal)?;
        let app = Arc::new(App::new(guard::new_token()?, options.folder.clone()));
        let address = format!("http://127.0.0.1:{port}/?token={}", app.token);
        let entered = runtime.enter();
        let listener = tokio::net::TcpListener::from_std(listener).map_err(internal)?;
        drop(entered);
        let router = router(Arc::clone(&app));
        let task = runtime
            .spawn(async move { axum::serve(listener, router).with_graceful_shutdown(interrupted()).await });
        let server = Server { address, runtime, app, task };
        if let Some(input) = &options.input {
            server.load(input, options.session.as_deref())?;
        }
        Ok(server)
    }

    /// What to type into a browser.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Opens the map given on the command line. What is wrong with it ends the program: there is nothing to show.
    fn load(&self, input: &Path, session: Option<&Path>) -> Result<()> {
        self.app.open(input, session)
    }

    /// Serves until Ctrl-C.
    ///
    /// # Errors
    /// [`Error::Internal`] if the system fails.
    pub fn wait(self) -> Result<()> {
        let Server { runtime, app, task, .. } = self;
        let ended = runtime.block_on(async {
            interrupted().await;
            app.close();
            // Whoever still listens for news is not waited for.
            tokio::time::timeout(std::time::Duration::from_millis(500), task).await
        });
        runtime.shutdown_timeout(std::time::Duration::from_millis(500));
        match ended {
            Ok(Ok(Err(e))) => Err(Error::Internal(e.to_string())),
            _ => Ok(()),
        }
    }
}

/// Resolves on Ctrl-C, or when the system asks the program to end.
async fn interrupted() {
    let asked = async {
        #[cfg(unix)]
        if let Ok(mut signal) = tokio::signal::unix::signal(tokio::signal::unix::SignalKind::terminate()) {
            signal.recv().await;
            return;
        }
        std::future::pending::<()>().await;
    };
    tokio::select! {
        _ = tokio::signal::ctrl_c() => {}
        () = asked => {}
    }
}

/// Everything that can be asked.
fn router(app: Arc<App>) -> Router {
    Router::new()
        .route("/", get(page::page))
        .route("/api/state", get(view::state))
        .route("/api/news", get(view::news))
        .route("/api/points", get(map::points))
        .route("/api/poses", get(map::poses))
        .route("/api/factors", get(map::factors))
        .route("/api/closures", get(map::closures))
        .route("/api/uncertainty", get(map::uncertainty))
        .route("/api/walks", get(walks::walks))
        .route("/api/catch", post(edit::catch))
        .route("/api/preview", post(edit::preview))
        .route("/api/commit", post(edit::commit))
        .route("/api/act", post(edit::act))
        .route("/api/inconsistency", post(jobs::inconsistency))
        .route("/api/match", post(jobs::matching))
        .route("/api/suggest", post(jobs::suggest))
        .route("/api/crosscheck", post(jobs::crosscheck))
        .route("/api/summary", post(jobs::summary))
        .route("/api/cancel", post(jobs::cancel))
        .route("/api/export", get(files::export))
        .route("/api/picture", get(files::picture))
        .route("/api/demo", post(open::demo))
        .layer(DefaultBodyLimit::max(MAX_BODY_BYTES))
        .route("/api/open", post(open::upload).layer(DefaultBodyLimit::disable()))
        .layer(axum::middleware::from_fn_with_state(Arc::clone(&app), guard::check))
        .with_state(app)
}
