//! The lab in the browser: an HTTP server on this machine's loopback address, and the page that it serves.
//!
//! The page compares a bench's model with its measurements, moves parameters, diagnoses, designs, generates and
//! proves. `workbench` computes all of this. The lab stores nothing outside the bench folder: when it ends, that folder
//! is all that remains.
//!
//! | file | job |
//! |---|---|
//! | `guard` | access control: host, origin, cookie; headers of every answer |
//! | `door` | how a browser gets the cookie without a secret on a command line |
//! | `folder` | which folder is a bench, and whether its files lie inside it |
//! | `desk` | the open bench: session, diagnosis, staircase, undo |
//! | `dropped` | CSV files on their way to a bench |
//! | `work` | one long computation at a time, with progress and cancel |
//! | `picture` | curves reduced to the pixels of a screen |
//! | `facts` | the data for the page, as JSON |
//! | `routes`, `socket` | the addresses of the server, and the socket for sliders |
//! | `report` | the bench as one HTML file |

mod assets;
mod desk;
mod door;
mod dropped;
mod facts;
mod folder;
mod guard;
mod picture;
mod report;
mod routes;
mod server;
mod socket;
mod work;

pub use report::{Findings, report, report_of};
pub use server::{Error, Lab, Settings};
