//! A land cut into tiles that share the samples of their edges.

use super::Error;
use super::preset::Preset;
use crate::formats::sidecar::Tile;
use std::fmt;
use std::path::{Path, PathBuf};

/// How many tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tiles {
    /// From west to east.
    pub across: u32,
    /// From north to south.
    pub down: u32,
}

impl Tiles {
    pub const ONE: Tiles = Tiles { across: 1, down: 1 };

    pub fn are_one(self) -> bool {
        self == Tiles::ONE
    }

    /// Refuses a land of `cells` samples a side that doesn't come out even.
    pub fn check(self, cells: u32) -> Result<(), Error> {
        let intervals = cells - 1;
        if intervals.is_multiple_of(self.across) && intervals.is_multiple_of(self.down) {
            return Ok(());
        }
        let common = (1..).map(|n| n * self.across).find(|n| n.is_multiple_of(self.down)).unwrap_or(1);
        let below = intervals / common * common + 1;
        let above = below + common;
        let advice = if below > 1 { format!("{below} or {above}") } else { above.to_string() };
        Err(Error::Usage(format!(
            "--tiles {self}: neighbours share the samples of their edge, so {cells} samples a side leave {intervals} \
             intervals, which can't be divided so; resample with --cells {advice}"
        )))
    }

    /// All of them, row by row; nothing to say of a land in one piece.
    pub fn all(self) -> impl Iterator<Item = Option<Tile>> {
        let of = [self.across, self.down];
        (0..self.down).flat_map(move |row| {
            (0..self.across).map(move |column| (of != [1, 1]).then_some(Tile { column, row, of }))
        })
    }

    /// Width and height of each, samples.
    pub fn size(self, cells: u32) -> [u32; 2] {
        [(cells - 1) / self.across + 1, (cells - 1) / self.down + 1]
    }

    /// Column and row of the first sample of one, in the whole land.
    pub fn origin(self, tile: Option<Tile>, cells: u32) -> [u32; 2] {
        let Some(Tile { column, row, .. }) = tile else { return [0, 0] };
        let [width, height] = self.size(cells);
        [column * (width - 1), row * (height - 1)]
    }
}

/// The file of a tile: `height_x0_y0.r16`, from the north-west corner, is what Unreal's import of tiled landscapes looks
/// for, and World Machine's export writes; `height_0_0.raw`, x and z from the south-west, is the order of Unity's Terrain Tools
/// (Import Heightmap, batch mode).
pub fn path(whole: &Path, tile: Option<Tile>, preset: Option<Preset>) -> PathBuf {
    let Some(Tile { column, row, of: [_, down] }) = tile else { return whole.into() };
    let stem = whole.file_stem().unwrap_or_default().to_string_lossy();
    let extension = whole.extension().unwrap_or_default().to_string_lossy();
    whole.with_file_name(match preset {
        Some(Preset::Unity) => format!("{stem}_{column}_{}.{extension}", down - 1 - row),
        _ => format!("{stem}_x{column}_y{row}.{extension}"),
    })
}

/// Reads `2x2`.
pub fn tiles(text: &str) -> Result<Tiles, String> {
    const MOST: u32 = 256;

    let counts = text.split_once(['x', 'X', '×']).and_then(|(n, m)| Some((n.parse().ok()?, m.parse().ok()?)));
    match counts {
        Some((across, down)) if (1..=MOST).contains(&across) && (1..=MOST).contains(&down) => {
            Ok(Tiles { across, down })
        }
        Some(_) => Err(format!("both counts must lie between 1 and {MOST}")),
        None => Err("it must be how many across x how many down, for example 2x2".into()),
    }
}

impl fmt::Display for Tiles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.across, self.down)
    }
}
