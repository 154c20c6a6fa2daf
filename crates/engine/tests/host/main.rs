//! Tests of the engine without a device, and of the house: its modules, comments and kinds of builds.

mod clips;
mod comments;
mod profiles;
mod reach;
mod rooms;
mod soft_model;
