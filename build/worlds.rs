//! The worlds that come with the program, as they lie in `configs/`, for those who have the program alone.

use std::{fmt::Write, fs, path::Path};

/// The text of `worlds.rs`: path below `folder` and bytes of every file in it, sorted.
pub fn rust(folder: &Path) -> Result<String, String> {
    let mut files = Vec::new();
    collect(folder, &mut files)?;
    files.sort();
    let root = folder.canonicalize().map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut text = String::from("&[\n");
    for file in files {
        let whole = root.join(&file);
        writeln!(text, "    ({file:?}, include_bytes!({whole:?}) as &[u8]),").expect("a string can be written to");
    }
    Ok(text + "]\n")
}

fn collect(folder: &Path, files: &mut Vec<String>) -> Result<(), String> {
    collect_below(folder, folder, files)
}

fn collect_below(root: &Path, folder: &Path, files: &mut Vec<String>) -> Result<(), String> {
    let entries = fs::read_dir(folder).map_err(|error| format!("cannot read {}: {error}", folder.display()))?;
    for entry in entries {
        let path = entry.map_err(|error| format!("cannot read {}: {error}", folder.display()))?.path();
        if path.is_dir() {
            collect_below(root, &path, files)?;
        } else if let Ok(below) = path.strip_prefix(root) {
            files.push(below.to_string_lossy().replace('\\', "/"));
        }
    }
    Ok(())
}
