//! Tests of the window's parts without a window: controls, model, and pictures of the worker on a device.

mod controls;
mod display;
mod model;
mod stage;
mod worker;
