//! Files in the repository that the program writes.

use std::fs;
use std::path::Path;

/// Set to rewrite what is committed; read the difference before committing it.
pub const BLESS: &str = "TERRANE_BLESS";

/// Compares with a committed file, or writes it when [`BLESS`] is set.
pub fn check_committed(path: &Path, text: &str) -> Result<(), String> {
    if std::env::var_os(BLESS).is_some() {
        fs::write(path, text).unwrap();
    }
    let committed = fs::read_to_string(path).unwrap_or_default();
    if committed == text {
        return Ok(());
    }
    Err(format!("--- {} has\n{committed}\n--- and should have\n{text}", path.display()))
}
