//! Tests of readers, stores and writers.

mod deep;
mod in_place;
mod io;
mod output;
mod photo;
