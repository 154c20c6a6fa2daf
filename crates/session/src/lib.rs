//! The way from a request to a picture that the program, the library, the window, the Python package and the ranks of
//! MPI share.
//!
//! - A [`Request`] is plain data, made once from arguments, keywords or the state of a window.
//! - [`Prepared`] is a request with its clouds read, its points arranged and its camera found. It needs no device.
//! - A [`Session`] is a prepared request on a device. It decides method and opacity, renders, and
//!   [updates](Session::update) to other requests: [`Recipe`](pellucid_scene::Recipe) is the one table of what
//!   a changed key makes again.
//! - [`Messages`] receives warnings and notes on the way.

pub mod area;
mod assembled;
pub mod candidates;
pub mod choice;
mod ensemble_warnings;
mod measured;
mod messages;
mod notes;
mod prepared;
mod request;
mod samples;
mod session;
mod soft_points;
mod sources;
mod sparse;
mod uploaded;

pub use assembled::{Assembled, Wanted};
pub use measured::Measuring;
pub use messages::{Messages, Silent};
pub use notes::shadow_holes;
pub use prepared::{Opened, Prepared};
pub use request::{ChoiceRequest, FrameRequest, Request, SeeThrough, SeeThroughBy, inputs};
pub use samples::SettledSamples;
pub use session::Session;
pub use soft_points::without_soft_points;
pub use sources::{Clouds, Limits, Residence, Sources, describe_cloud, describe_store};
pub use uploaded::Uploaded;
