//! Documents held to the program: the reference of commands, written from clap's table of them, and the commands and
//! scenes that pages show. Tests only.

mod examples;
mod pages;
mod reference;
