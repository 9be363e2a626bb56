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
//! | `outside` | whether another program has changed a file of the bench |
//! | `dropped`, `preview` | CSV files on their way to a bench |
//! | `work`, `running` | one long computation at a time, with progress and cancel |
//! | `picture` | curves as a screen can show them: least and largest value a pixel |
//! | `facts`, `design_facts`, `why_facts` | what the page is told, as JSON |
//! | `help` | the guide as pages of the lab |
//! | `shared` | what every answer needs |
//! | `routes`, `socket` | the addresses of the server, and the socket for sliders |
//! | `report`, `report_conclusion`, `report_findings`, `html` | the bench as one HTML file |

mod assets;
mod design_facts;
mod desk;
mod door;
mod dropped;
mod error;
mod facts;
mod folder;
mod guard;
mod help;
mod html;
mod outside;
mod picture;
mod preview;
mod report;
mod report_conclusion;
mod report_findings;
mod routes;
mod running;
mod server;
mod shared;
mod socket;
mod why_facts;
mod work;

pub use error::Error;
pub use report::{report, report_of};
pub use report_findings::ReportFindings;
pub use server::{Lab, LabSettings};
