//! What is wrong with a folder, and the report of it.

use super::{and, set, without};
use terrane::world::thesis::{Contents, Folder};

/// A change to the folder, and the whole report.
type Case = (&'static str, fn(&mut Folder), &'static str);

pub const MISTAKES: &[Case] = &[
    ("a name that is spelled wrong", |folder| add(folder, "camera.conf", "LookHight 2"), r""),
    ("a name of another file", |folder| add(folder, "camera.conf", "Samples 4"), r""),
    ("no name", |folder| add(folder, "camera.conf", "1.5 LookHeight 2"), r""),
    ("one value too many", |folder| add(folder, "camera.conf", "LookHeight 2 3"), r""),
    ("a value too few", |folder| add(folder, "camera.conf", "LookDirection 0 1"), r""),
    ("a comma for a point", |folder| add(folder, "camera.conf", "LookHeight 1,5"), r""),
    ("no number", |folder| add(folder, "camera.conf", "LookHeight NaN"), r""),
    ("a negative N", |folder| add(folder, "trees/fork.lsys", "N -2"), r""),
    ("a missing name", |folder| *folder = without(folder, "terrain.conf", "Spread"), r""),
    ("a missing file", |folder| _ = folder.files.remove("materials/bark.mat"), r""),
    ("a missing folder", |folder| _ = folder.folders.remove("spawners"), r""),
    ("a folder that is spelled wrong", |folder| _ = folder.folders.insert("leaves".into()), r""),
    ("a file that is spelled wrong", |folder| set(folder, "skies.conf", ""), r""),
    ("an unknown ending", |folder| set(folder, "trees/round.txt", ""), r""),
    ("an unknown material", |folder| set(folder, "materials/barks.mat", ""), r""),
    ("looking straight down", |folder| add(folder, "camera.conf", "LookDirection 0 -1 0"), r""),
    ("rock below the ground", |folder| add(folder, "terrain.conf", "GroundEndY 9"), r""),
    ("sizes that fall", |folder| add(folder, "spawners/left.spawner", "MaxElementScale 0.1"), r""),
    ("no trees to plant", |folder| folder.files.retain(|name, _| !name.starts_with("trees/")), r""),
    ("a word with a branch that ends too often", |folder| add(folder, "trees/fork.lsys", "Prod A > F[A]]"), r""),
    ("a word with an open branch", |folder| add(folder, "trees/fork.lsys", "Prod A > F[A"), r""),
    ("a symbol that is none", |folder| add(folder, "trees/fork.lsys", "Prod A > F(2)"), r""),
    ("no arrow", |folder| add(folder, "trees/fork.lsys", "Prod A F[A]"), r""),
    ("a production for nothing", |folder| add(folder, "trees/fork.lsys", "Prod Q > F"), r""),
    ("an axiom that means nothing", |folder| add(folder, "trees/fork.lsys", "Axiom Q"), r""),
    ("a letter that means nothing", |folder| add(folder, "trees/fork.lsys", "Prod A > FQ"), r""),
    ("a leaf without height", |folder| add(folder, "leafs/oval.family", "LA 0\nLB 0"), r""),
    ("a leaf that grows without end", |folder| add(folder, "leafs/blade.lsys", "N 30\nProd A > {.F.}AA"), r""),
    ("no text", |folder| _ = folder.files.insert("sky.conf".into(), Contents::Bytes(b"SunPower \xff".into())), r""),
    (
        "several mistakes",
        |folder| {
            add(folder, "sky.conf", "Latitude 100\nTurbidity 0");
            add(folder, "camera.conf", "LookAhead 4");
            folder.files.remove("terrain.conf");
        },
        r"",
    ),
];

/// A line at the end of a file.
fn add(folder: &mut Folder, file: &str, line: &str) {
    *folder = and(folder, file, &format!("\n{line}\n"));
}
