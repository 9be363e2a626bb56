//! Binding, opening and running.

use std::io;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use tokio::net::TcpListener;

use crate::desk::Desk;
use crate::door::{Door, open_in_browser};
use crate::guard::Guard;
use crate::{routes, work};

/// What the lab is to begin with.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    /// The bench to open: a folder, or its bench.toml. `None`: the page asks.
    pub bench: Option<PathBuf>,
    /// The port; `None`: one that the system chooses.
    pub port: Option<u16>,
}

/// Why the lab cannot run.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The port is taken, or not allowed.
    #[error(
        "cannot listen on {address}: {source}; --port N names another port, none lets the system choose"
    )]
    Listen {
        /// Where.
        address: SocketAddr,
        /// What the system said.
        source: io::Error,
    },
    /// The file that opens the page cannot be written.
    #[error("{}: cannot write the page that opens the lab: {source}", path.display())]
    Door {
        /// The file or its folder.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The server has stopped.
    #[error("the server has stopped: {0}")]
    Serve(#[source] io::Error),
}

/// What every answer needs.
#[derive(Clone)]
pub(crate) struct Shared {
    pub guard: Arc<Guard>,
    pub desk: Arc<Desk>,
}

/// A lab that listens and has not answered yet.
pub struct Lab {
    runtime: tokio::runtime::Runtime,
    listener: TcpListener,
    router: Router,
    door: Door,
    guard: Arc<Guard>,
}

/// How often a running lab asks whether it is to end.
const LOOK_EVERY: Duration = Duration::from_millis(50);

impl Lab {
    /// Listens on the loopback address and begins to open the bench.
    ///
    /// # Errors
    /// [`Error::Listen`], [`Error::Door`].
    pub fn start(settings: &Settings) -> Result<Lab, Error> {
        let address = SocketAddr::from((Ipv4Addr::LOCALHOST, settings.port.unwrap_or(0)));
        let listen = |source| Error::Listen { address, source };
        let runtime = tokio::runtime::Builder::new_multi_thread()
            // Computing has threads of its own.
            .worker_threads(2)
            .enable_all()
            .build()
            .map_err(listen)?;
        let listener = runtime
            .block_on(TcpListener::bind(address))
            .map_err(listen)?;
        let port = listener.local_addr().map_err(listen)?.port();
        let guard = Arc::new(Guard::new(port));
        let door = Door::write(&guard)?;
        let desk = Arc::new(Desk::new());
        let shared = Shared {
            guard: guard.clone(),
            desk: desk.clone(),
        };
        if let Some(bench) = &settings.bench {
            // Where it cannot be opened, the page says why.
            let _ = work::open(&desk, bench.clone());
        }
        Ok(Lab {
            runtime,
            listener,
            router: routes::router(shared),
            door,
            guard,
        })
    }

    /// Opens the page in the browser of the desktop.
    ///
    /// # Errors
    /// What the system said: there may be no desktop.
    pub fn open_in_browser(&self) -> io::Result<()> {
        open_in_browser(self.door.path())
    }

    /// The file (for the owner's eyes alone) that opens the page in a browser.
    pub fn door(&self) -> &std::path::Path {
        self.door.path()
    }

    /// An address that opens the page once. It holds a secret: not for command lines, which others can see.
    pub fn one_time_address(&self) -> String {
        self.guard.one_time_address()
    }

    /// The address of the page, for a browser that has been let in.
    pub fn address(&self) -> String {
        self.guard.address()
    }

    /// Answers until `ended` answers true.
    ///
    /// # Errors
    /// [`Error::Serve`].
    pub fn run(self, ended: &(dyn Fn() -> bool + Sync)) -> Result<(), Error> {
        let Lab {
            runtime,
            listener,
            router,
            door,
            ..
        } = self;
        let end = async {
            while !ended() {
                tokio::time::sleep(LOOK_EVERY).await;
            }
        };
        let result = runtime.block_on(async {
            tokio::select! {
                served = axum::serve(listener, router) => served.map_err(Error::Serve),
                () = end => Ok(()),
            }
        });
        drop(door);
        // A computation under way is of no more use.
        runtime.shutdown_background();
        result
    }
}
