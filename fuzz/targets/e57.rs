#![no_main]

pellucid_fuzz::target!(e57);
