//! Why the lab cannot run.

use std::io;
use std::net::SocketAddr;
use std::path::PathBuf;

/// The reason why the lab cannot run.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The bench that was to be opened is not there, or one of its files lies outside its folder.
    #[error("{0}")]
    Bench(String),
    /// The port is taken, or not allowed.
    #[error(
        "cannot listen on {address}: {source}; --port N names another port, none lets the system choose"
    )]
    Listen {
        /// The address.
        address: SocketAddr,
        /// The system's error.
        source: io::Error,
    },
    /// The file that opens the page cannot be written.
    #[error("{}: cannot write the page that opens the lab: {source}", path.display())]
    Door {
        /// The file or its folder.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// The server has stopped.
    #[error("the server has stopped: {0}")]
    Serve(#[source] io::Error),
}
