//! Starts the server: binds the port, opens the bench, answers requests.

use std::io;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use tokio::net::TcpListener;

use crate::desk::Desk;
use crate::door::{Door, open_in_browser};
use crate::error::Error;
use crate::guard::Guard;
use crate::shared::Shared;
use crate::{routes, work};

/// The settings of the lab.
#[derive(Clone, Debug, Default)]
pub struct LabSettings {
    /// The bench to open: a folder, or its bench.toml. With `None`, the page asks.
    pub bench: Option<PathBuf>,
    /// The port; with `None`, the system chooses one.
    pub port: Option<u16>,
}

/// A lab that listens but does not answer yet.
pub struct Lab {
    runtime: tokio::runtime::Runtime,
    listener: TcpListener,
    router: Router,
    door: Door,
    guard: Arc<Guard>,
}

/// Interval of the checks whether a running lab should end.
const LOOK_EVERY: Duration = Duration::from_millis(50);

impl Lab {
    /// Listens on the loopback address and begins to open the bench.
    ///
    /// # Errors
    /// [`Error::Bench`], [`Error::Listen`], [`Error::Door`].
    pub fn start(settings: &LabSettings) -> Result<Lab, Error> {
        if let Some(bench) = &settings.bench {
            crate::folder::of_bench(bench).map_err(Error::Bench)?;
        }
        let address = SocketAddr::from((Ipv4Addr::LOCALHOST, settings.port.unwrap_or(0)));
        let listen = |source| Error::Listen { address, source };
        let runtime = tokio::runtime::Builder::new_multi_thread()
            // Computations have their own threads.
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
            // What is wrong with its files, the page shows and mends.
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
    /// The system's error: there may be no desktop.
    pub fn open_in_browser(&self) -> io::Result<()> {
        open_in_browser(self.door.path())
    }

    /// The file, readable by its owner only, that opens the page in a browser.
    pub fn door(&self) -> &std::path::Path {
        self.door.path()
    }

    /// An address that opens the page once. It contains a secret, so it must not appear on a command line.
    pub fn one_time_address(&self) -> String {
        self.guard.one_time_address()
    }

    /// The address of the page, for a browser that has the cookie.
    pub fn address(&self) -> String {
        self.guard.address()
    }

    /// Answers requests until `ended` returns `true`.
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
        // A computation that is still running is no longer needed.
        runtime.shutdown_background();
        result
    }
}
