//! The reference page of folders of settings, written from the declarations of their parameters.

use super::files::{Camera, Family, Honda, LSystem, Material, PathTracer, Sky, Spawner, Terrain, ViewMode};
use super::parameters::Settings;
use std::fmt::Write;

/// The whole reference as Markdown: `docs/folders.md`.
pub fn reference() -> String {
    let tables = [
        table::<PathTracer>(),
        table::<Camera>(),
        table::<ViewMode>(),
        table::<Sky>(),
        table::<Terrain>(),
        table::<Material>(),
        table::<LSystem>(),
        table::<Honda>(),
        table::<Family>(),
        table::<Spawner>(),
    ];
    INTRODUCTION.to_owned() + &tables.concat()
}

const INTRODUCTION: &str = r##"# Folders of settings

The program of Rudzki 2020 ("Realistic rendering of procedural generated forest landscapes", §4.3) reads its scene from a
folder of small text files. terrane takes such a folder wherever it takes a world file:

```sh
terrane check FOLDER
terrane render FOLDER                    # FOLDER/photos/<PhotoName>.exr
terrane convert FOLDER -o world.toml     # the same world as a file to go on with
```

A folder becomes the text of a world file and is read as one: it can mean nothing that a world file can't.

```
pathTracer.conf  camera.conf  viewMode.conf  sky.conf  terrain.conf
materials/*.mat  leafs/*.lsys, *.family  trees/*.lsys, *.honda  plants/*.lsys  spawners/*.spawner
```

- A file is a list of names with values, separated by blanks: `Resolution 640 360`; from `#` on a line is a comment. Where a
  name stands twice the last one counts. A production is written `Prod A > WORD`, on one line.
- Files of a folder are read in the order of their names. The folder `leafs` may be missing, and the trees are bare then.
- What the published program passes over in silence or falls over (unknown names, values out of range, missing files,
  unbalanced brackets) is an error here that names file, line and column.
- `SunColor` has no place in a world: the sun has the colour of the model, and a warning says so unless it is `1 1 1`.
  `SunPower` and `SkyLuminanceFactor` together are the exposure.

This page is written by the program from the same table that reads the files.
"##;

/// Heading, meaning and parameters of a kind of file.
fn table<S: Settings>() -> String {
    let (files, about) = S::ABOUT.trim_ascii().split_once(": ").unwrap_or((S::ABOUT, ""));
    let mut letters = about.chars();
    let first: String = letters.next().into_iter().flat_map(char::to_uppercase).collect();
    let mut table = format!("\n## {files}\n\n{first}{}\n\n", letters.as_str());
    table += "| name | values | default | |\n|---|---|---|---|\n";
    for parameter in S::parameters() {
        let default = match parameter.default.as_deref() {
            None => "must be given",
            Some("") => "none",
            Some(default) => default,
        };
        // Writing to a string can't fail.
        let _ = writeln!(
            table,
            "| `{}` | {} | {default} | {} |",
            parameter.name, parameter.allowed, parameter.about
        );
    }
    table
}
