//! The part of `pellucid compare` that reads profiles: the program's own files, with its output dropped.

#[path = "../../../../crates/cli/src/commands/compare_profiles.rs"]
pub mod compare_profiles;
#[path = "../../../../crates/cli/src/commands/limit.rs"]
pub mod limit;
#[path = "../../../../crates/cli/src/commands/noise.rs"]
pub mod noise;

/// Stands for the program's standard output and error.
pub mod console {
    pub fn print_stderr(text: impl std::fmt::Display) {
        drop(text.to_string());
    }

    pub fn print(text: &str) -> pellucid_engine::Result<()> {
        print_stderr(text);
        Ok(())
    }

    pub fn print_json(json: &serde_json::Value) -> pellucid_engine::Result<()> {
        print(&json.to_string())
    }
}
