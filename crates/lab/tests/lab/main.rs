//! Checks of all methods alike, and the pages that reports write.

mod check;
mod determinism;
mod profiler;
mod stopped;
mod stores;
mod tradeoff_page;
