//! Parts of a picture or a film, as the command line names them: ranges, crops, names of frames.

use crate::trace::{Crop, MOST_SAMPLES};
use crate::world::MOST_FRAMES;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Reads `0..60`, without its end.
fn range(text: &str, most: u32) -> Result<Range<u32>, String> {
    let ends = text.split_once("..").and_then(|(from, to)| Some(from.parse().ok()?..to.parse().ok()?));
    match ends {
        Some(range) if range.start < range.end && range.end <= most => Ok(range),
        Some(Range { start, end }) if start < end => Err(format!("it may go up to {most}")),
        Some(_) => Err("it is empty: the second number is the first one behind the range".into()),
        None => Err("it must be two whole numbers, for example 0..60; the second is not in the range".into()),
    }
}

/// Numbers of frames.
pub fn frames(text: &str) -> Result<Range<u32>, String> {
    range(text, MOST_FRAMES + 1)
}

/// Numbers of samples.
pub fn samples(text: &str) -> Result<Range<u32>, String> {
    range(text, MOST_SAMPLES)
}

/// Reads `x,y,width,height`.
pub fn crop(text: &str) -> Result<Crop, String> {
    let numbers: Option<Vec<u32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some([_, _, 0, _] | [_, _, _, 0]) => Err("its width and its height must be at least 1".into()),
        Some(&[x, y, width, height]) => Ok(Crop { origin: [x, y], size: [width, height] }),
        _ => {
            Err("it must be x,y,width,height in pixels from the upper left corner, for example 0,0,64,64"
                .into())
        }
    }
}

/// The name of the frames of a film, with a place for the number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Name {
    pub folder: PathBuf,
    before: String,
    digits: usize,
    after: String,
}

impl Name {
    /// Reads a path whose last part has one `%d`, or `%05d` for five digits.
    pub fn of(path: &Path) -> Result<Name, String> {
        const ADVICE: &str =
            "the names of frames need a place for the number, for example -o frames/%05d.png";
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let (before, rest) = name.split_once('%').ok_or(ADVICE)?;
        let (digits, after) = rest.split_once('d').ok_or(ADVICE)?;
        let digits = match digits.strip_prefix('0').map(str::parse) {
            None if digits.is_empty() => 0,
            Some(Ok(digits @ 1..=9)) => digits,
            _ => return Err(format!("%{digits}d is no place for a number: use %d, or %01d to %09d")),
        };
        if after.contains('%') {
            return Err("the names of frames may have one % alone".into());
        }
        let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
        let folder = parent.unwrap_or(Path::new(".")).into();
        Ok(Name { folder, before: before.into(), digits, after: after.into() })
    }

    /// As it was given.
    pub fn pattern(&self) -> PathBuf {
        let Name { folder, before, digits, after } = self;
        let digits = if *digits == 0 { String::new() } else { format!("0{digits}") };
        folder.join(format!("{before}%{digits}d{after}"))
    }

    pub fn path(&self, frame: u32) -> PathBuf {
        let Name { folder, before, digits, after } = self;
        folder.join(format!("{before}{frame:0digits$}{after}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_and_crops() {
        assert_eq!(frames("0..60"), Ok(0..60));
        assert_eq!(samples("1048575..1048576"), Ok(1_048_575..1_048_576));
        for wrong in
            ["", "5", "..", "3..", "..3", "3..3", "4..3", "-1..3", "0..1048577", "0...3", "0..=3", "a..b"]
        {
            assert!(samples(wrong).is_err(), "{wrong}");
        }
        assert_eq!(crop("1, 2,3,4"), Ok(Crop { origin: [1, 2], size: [3, 4] }));
        for wrong in
            ["", "1,2,3", "1,2,0,4", "1,2,3,0", "-1,2,3,4", "1,2,3,4,5", "1x2x3x4", "99999999999,0,1,1"]
        {
            assert!(crop(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn names_of_frames() {
        let path = |name: &str, frame| Name::of(Path::new(name)).unwrap().path(frame);
        assert_eq!(path("frames/%05d.png", 12), Path::new("frames/00012.png"));
        assert_eq!(path("%d.exr", 7), Path::new("./7.exr"));
        assert_eq!(path("a/b%02d_c.png", 123), Path::new("a/b123_c.png"));
        // A folder may be called anything.
        assert_eq!(path("100%/%03d.png", 1), Path::new("100%/001.png"));
        for wrong in [
            "a.png",
            "%.png",
            "%5d.png",
            "%0d.png",
            "%010d.png",
            "%05x.png",
            "%d%d.png",
            "%d/a.png",
            "%%d.png",
            "",
        ] {
            assert!(Name::of(Path::new(wrong)).is_err(), "{wrong}");
        }
    }
}
