//! Memory as it is planned, before any is taken.

/// Memory by what it holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Memory {
    pub name: &'static str,
    pub bytes: u64,
}

/// Bytes in all.
pub fn total(parts: &[Memory]) -> u64 {
    parts.iter().map(|part| part.bytes).sum()
}

/// As people read it.
pub fn mebibytes(bytes: u64) -> String {
    format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20))
}
