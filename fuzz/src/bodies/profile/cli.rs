//! The part of `pellucid compare` that reads profiles: the program's own files, with its output dropped.

#[path = "../../../../crates/cli/src/commands/compare_profiles.rs"]
pub mod compare_profiles;
#[path = "../../../../crates/cli/src/commands/limit.rs"]
pub mod limit;
#[path = "../../../../crates/cli/src/commands/noise.rs"]
pub mod noise;
#[path = "../../../../crates/cli/src/commands/tables.rs"]
pub mod tables;

/// Stands for the program's standard output and error.
pub mod console {
    use std::fmt::Display;

    #[derive(Clone, Copy)]
    pub struct Console;

    impl Console {
        pub fn report(self, line: impl Display) {
            drop(line.to_string());
        }

        pub fn print(self, text: &str) -> pellucid_engine::Result<()> {
            self.report(text);
            Ok(())
        }

        pub fn print_json(self, json: &serde_json::Value) -> pellucid_engine::Result<()> {
            self.print(&json.to_string())
        }
    }
}
