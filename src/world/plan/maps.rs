//! Maps: files of heights or factors that are stretched over the terrain.

use super::Check;
use crate::core::memory::mebibytes;
use crate::formats::{self, Hints};
use crate::terrain::Map;
use crate::world::fault::{Cause, Complaint};
use crate::world::place::{KeyPath, shown};
use std::sync::Arc;

/// Most memory, bytes, that all maps of a world take together.
const MOST_MAPS: u64 = 1 << 30;

/// What the values of a map are read as.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Use {
    /// Metres, by the ends of the scale where the world gives them.
    Heights(Option<[f32; 2]>),
    Factors,
}

/// A map as it was read, for whoever names the same file in the same way.
pub(super) struct Read {
    path: String,
    hints: Hints,
    as_what: Use,
    map: Arc<Map>,
}

impl Check<'_> {
    /// A map of factors.
    pub fn factors(&mut self, path: &str, place: &KeyPath) -> Option<Arc<Map>> {
        self.map(path, place, Hints::default(), Use::Factors)
    }

    pub(super) fn map(
        &mut self,
        path: &str,
        place: &KeyPath,
        hints: Hints,
        as_what: Use,
    ) -> Option<Arc<Map>> {
        let same = |read: &&Read| read.path == path && read.hints == hints && read.as_what == as_what;
        if let Some(read) = self.maps.iter().find(same) {
            return Some(read.map.clone());
        }
        let map = formats::read_map(&self.folder.join(path), hints).and_then(|map| match as_what {
            Use::Heights(range) => map.into_metres(range),
            Use::Factors => Ok(map),
        });
        match map {
            Ok(map) => {
                self.warn_of_another_land(path, place, &map);
                let formats::Map { width, height, values, .. } = map;
                let map = Arc::new(Map { width, height, values });
                let others: u64 = self.maps.iter().map(|read| read.map.bytes()).sum();
                if others + map.bytes() > MOST_MAPS {
                    let label = format!(
                        "it takes {} of memory beside {} of other maps, and all may take {}",
                        mebibytes(map.bytes()),
                        mebibytes(others),
                        mebibytes(MOST_MAPS)
                    );
                    let complaint = Complaint::new(format!("names \"{}\"", shown(path)), label)
                        .help("scale maps down, or name the same file with the same keys where one will do");
                    self.refuse(std::slice::from_ref(place), complaint);
                    return None;
                }
                self.maps.push(Read { path: path.into(), hints, as_what, map: map.clone() });
                Some(map)
            }
            Err(error) => {
                let cause = match error {
                    formats::Error::NoRange { .. } | formats::Error::Unsuitable { .. } => Cause::World,
                    _ => Cause::File,
                };
                let complaint = Complaint::new(format!("names \"{}\"", shown(path)), error.to_string());
                self.refuse(std::slice::from_ref(place), Complaint { cause, ..complaint });
                None
            }
        }
    }

    /// A map is stretched over the terrain, whatever it was made for.
    fn warn_of_another_land(&mut self, path: &str, place: &KeyPath, map: &formats::Map) {
        let Some(whole) = map.extent else { return };
        let [across, down] = map.tile.map_or([1, 1], |tile| tile.of);
        let covered = [across, down].map(|tiles| whole / tiles as f32);
        let terrain = self.extent;
        if covered.iter().all(|length| (length - terrain).abs() <= 1e-4 * terrain) {
            return;
        }
        let land = match map.tile {
            Some(tile) => format!(
                "{} × {} m, tile {}, {} of {across} × {down} of a land of {whole} × {whole} m",
                covered[0], covered[1], tile.column, tile.row
            ),
            None => format!("{whole} × {whole} m"),
        };
        self.warnings.push(format!(
            "`{place}` names \"{}\", which by its sidecar covers {land}, and is stretched over the terrain's \
             {terrain} × {terrain} m; change `terrain.extent` if that isn't meant",
            shown(path)
        ));
    }
}
