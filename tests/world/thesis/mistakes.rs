//! What is wrong with a folder, and the report of it.

use super::{and, set, without};
use terrane::world::thesis::{Contents, Folder};

/// A change to the folder, and the whole report.
type Case = (&'static str, fn(&mut Folder), &'static str);

pub const MISTAKES: &[Case] = &[
    (
        "a name that is spelled wrong",
        |folder| add(folder, "camera.conf", "LookHight 2"),
        r"
`LookHight` is unknown
 --> settings/camera.conf:6:1
  |
6 | LookHight 2
  | ^^^^^^^^^ did you mean `LookHeight`?
  |
  = help: known here: LookHeight, LookDirection, LookDistance, EdgeMinOffset, ExpectedPositionY
",
    ),
    (
        "a name of another file",
        |folder| add(folder, "camera.conf", "Samples 4"),
        r"
`Samples` is unknown
 --> settings/camera.conf:6:1
  |
6 | Samples 4
  | ^^^^^^^ known here: LookHeight, LookDirection, LookDistance, EdgeMinOffset, ExpectedPositionY
",
    ),
    (
        "no name",
        |folder| add(folder, "camera.conf", "1.5 LookHeight 2"),
        r"
`1.5` stands without a name
 --> settings/camera.conf:6:1
  |
6 | 1.5 LookHeight 2
  | ^^^ a name, then its values
  |
  = help: known here: LookHeight, LookDirection, LookDistance, EdgeMinOffset, ExpectedPositionY
",
    ),
    (
        "one value too many",
        |folder| add(folder, "camera.conf", "LookHeight 2 3"),
        r"
`3` is one too many
 --> settings/camera.conf:6:14
  |
6 | LookHeight 2 3
  |              ^ `LookHeight` takes 1 value
",
    ),
    (
        "a value too few",
        |folder| add(folder, "camera.conf", "LookDirection 0 1"),
        r"
`LookDirection` has too few values
 --> settings/camera.conf:6:1
  |
6 | LookDirection 0 1
  | ^^^^^^^^^^^^^ 3 numbers from -1000000 to 1000000
",
    ),
    (
        "a comma for a point",
        |folder| add(folder, "camera.conf", "LookHeight 1,5"),
        r"
`LookHeight` can't be `1,5`
 --> settings/camera.conf:6:12
  |
6 | LookHeight 1,5
  |            ^^^ allowed: a number from 0 to 10000
",
    ),
    (
        "no number",
        |folder| add(folder, "camera.conf", "LookHeight NaN"),
        r"
`LookHeight` must be finite
 --> settings/camera.conf:6:12
  |
6 | LookHeight NaN
  |            ^^^ allowed: a number from 0 to 10000
",
    ),
    (
        "a negative N",
        |folder| add(folder, "trees/fork.lsys", "N -2"),
        r"
`N` is out of range
  --> settings/trees/fork.lsys:13:3
   |
13 | N -2
   |   ^^ allowed: a whole number from 0 to 1000
",
    ),
    (
        "a missing name",
        |folder| *folder = without(folder, "terrain.conf", "Spread"),
        r"
`Spread` is missing
--> settings/terrain.conf
 = note: write `Spread` and a number from 0 to 20000
",
    ),
    (
        "a missing file",
        |folder| _ = folder.files.remove("materials/bark.mat"),
        r"
`materials/bark.mat` is missing
--> settings/materials/bark.mat
 = note: every folder of settings has it
",
    ),
    (
        "a missing folder",
        |folder| _ = folder.folders.remove("spawners"),
        r"
the folder `spawners` is missing
--> settings/spawners
 = note: it may be empty
",
    ),
    (
        "a folder that is spelled wrong",
        |folder| _ = folder.folders.insert("leaves".into()),
        r"
the folder `leaves` is unknown
--> settings/leaves
 = note: did you mean `leafs`?
",
    ),
    (
        "a file that is spelled wrong",
        |folder| set(folder, "skies.conf", ""),
        r"
the file `skies.conf` is unknown
--> settings/skies.conf
 = note: did you mean `sky.conf`?
 = help: known here: camera.conf, pathTracer.conf, sky.conf, terrain.conf, viewMode.conf
",
    ),
    (
        "an unknown ending",
        |folder| set(folder, "trees/round.txt", ""),
        r"
the file `trees/round.txt` is unknown
--> settings/trees/round.txt
 = note: names in `trees` end in .lsys or .honda
",
    ),
    (
        "an unknown material",
        |folder| set(folder, "materials/barks.mat", ""),
        r"
the file `materials/barks.mat` is unknown
--> settings/materials/barks.mat
 = note: did you mean `bark`?
 = help: known here: bark, ground, leaf, plant, rock
",
    ),
    (
        "looking straight down",
        |folder| add(folder, "camera.conf", "LookDirection 0 -1 0"),
        r"
`LookDirection` points nowhere
 --> settings/camera.conf:6:15
  |
6 | LookDirection 0 -1 0
  |               ^^^^^^ its first or third number must not be 0
  |
  = help: how far up or down the camera looks follows from the ground
",
    ),
    (
        "rock below the ground",
        |folder| add(folder, "terrain.conf", "GroundEndY 9"),
        r"
`GroundEndY` leaves no ground below the rock
 --> settings/terrain.conf:8:12
  |
8 | GroundEndY 9
  |            ^ allowed: above `RockStartY`, 9
",
    ),
    (
        "sizes that fall",
        |folder| add(folder, "spawners/left.spawner", "MaxElementScale 0.1"),
        r"
`MaxElementScale` leaves no size to choose
  --> settings/spawners/left.spawner:10:17
   |
10 | MaxElementScale 0.1
   |                 ^^^ allowed: `MinElementScale`, 0.7, and more
",
    ),
    (
        "no trees to plant",
        |folder| folder.files.retain(|name, _| !name.starts_with("trees/")),
        r"
`GeneratorType` names what there is none of
 --> settings/spawners/left.spawner:5:15
  |
5 | GeneratorType Tree
  |               ^^^^ the folder `trees` holds none

error: `GeneratorType` names what there is none of
 --> settings/spawners/right.spawner:5:15
  |
5 | GeneratorType Tree
  |               ^^^^ the folder `trees` holds none
",
    ),
    (
        "a word with a branch that ends too often",
        |folder| add(folder, "trees/fork.lsys", "Prod A > F[A]]"),
        r"
`Prod` has a `]` without its `[`
  --> settings/trees/fork.lsys:13:10
   |
13 | Prod A > F[A]]
   |          ^^^^^ a branch begins and ends in one word
",
    ),
    (
        "a word with an open branch",
        |folder| add(folder, "trees/fork.lsys", "Prod A > F[A"),
        r"
`Prod` has a `[` without its `]`
  --> settings/trees/fork.lsys:13:10
   |
13 | Prod A > F[A
   |          ^^^ a branch begins and ends in one word
",
    ),
    (
        "a symbol that is none",
        |folder| add(folder, "trees/fork.lsys", "Prod A > F(2)"),
        r"
`Prod` holds the unknown symbol `(`
  --> settings/trees/fork.lsys:13:10
   |
13 | Prod A > F(2)
   |          ^^^^ letters, and what the turtle knows
   |
   = help: the turtle knows: F f [ ] + - ^ & \ / | { . } @
",
    ),
    (
        "no arrow",
        |folder| add(folder, "trees/fork.lsys", "Prod A F[A]"),
        r"
`Prod` has too few values
  --> settings/trees/fork.lsys:13:1
   |
13 | Prod A F[A]
   | ^^^^ a symbol, `>` and a word: `Prod A > F[+A]A`
",
    ),
    (
        "a production without its word, before a name that is spelled wrong",
        |folder| add(folder, "trees/fork.lsys", "Prod A >\nTurnAngel 3"),
        r"
`Prod` has too few values
  --> settings/trees/fork.lsys:13:1
   |
13 | Prod A >
   | ^^^^ a symbol, `>` and a word: `Prod A > F[+A]A`

error: `TurnAngel` is unknown
  --> settings/trees/fork.lsys:14:1
   |
14 | TurnAngel 3
   | ^^^^^^^^^ did you mean `TurnAngle`?
   |
   = help: known here: N, Height, ConeBasePoints, Material, InitRadius, TurnAngle, PitchAngle, RollAngle, Axiom, Prod
",
    ),
    (
        "an edge that leaves no place to stand",
        |folder| add(folder, "camera.conf", "EdgeMinOffset 120.5"),
        r"
`EdgeMinOffset` leaves no place to stand
 --> settings/camera.conf:6:15
  |
6 | EdgeMinOffset 120.5
  |               ^^^^^ allowed: up to 120, half of `Size` in terrain.conf
",
    ),
    (
        "a production for nothing",
        |folder| add(folder, "trees/fork.lsys", "Prod Q > F"),
        r"
`Prod` is for `Q`, which never occurs
  --> settings/trees/fork.lsys:13:6
   |
13 | Prod Q > F
   |      ^^^^^ it stands in no word, and is not the axiom
",
    ),
    (
        "an axiom that means nothing",
        |folder| add(folder, "trees/fork.lsys", "Axiom Q"),
        r"
`Prod` is for `T`, which never occurs
  --> settings/trees/fork.lsys:11:6
   |
11 | Prod T > FFA
   |      ^^^^^^^ it stands in no word, and is not the axiom

error: `Axiom` is `Q`, which means nothing
  --> settings/trees/fork.lsys:13:7
   |
13 | Axiom Q
   |       ^ the turtle does not know it, and no `Prod Q > …` says what it grows into
",
    ),
    (
        "a letter that means nothing",
        |folder| add(folder, "trees/fork.lsys", "Prod A > FQ"),
        r"
`Prod` holds `Q`, which means nothing
  --> settings/trees/fork.lsys:13:6
   |
13 | Prod A > FQ
   |      ^^^^^^ the turtle does not know it, and no `Prod Q > …` says what it grows into
",
    ),
    (
        "a leaf without height",
        |folder| add(folder, "leafs/oval.family", "LA 0\nLB 0"),
        r"
`leafs/oval.family` grows into no leaf
--> settings/leafs/oval.family
 = note: what it draws has no height
",
    ),
    (
        "a leaf that grows without end",
        |folder| add(folder, "leafs/blade.lsys", "N 30\nProd A > {.F.}AA"),
        r"
`leafs/blade.lsys` grows into no leaf
--> settings/leafs/blade.lsys
 = note: step 15, the rule for `A`: the word would have 196603 modules, and 100000 are allowed
",
    ),
    (
        "no text",
        |folder| _ = folder.files.insert("sky.conf".into(), Contents::Bytes(b"SunPower \xff".into())),
        r"
`sky.conf` is not UTF-8 text
 --> settings/sky.conf:1:10
  |
1 | SunPower �
  |          ^ this byte is no part of a character
",
    ),
    (
        "several mistakes",
        |folder| {
            add(folder, "sky.conf", "Latitude 100\nTurbidity 0");
            add(folder, "camera.conf", "LookAhead 4");
            folder.files.remove("terrain.conf");
        },
        r"
`LookAhead` is unknown
 --> settings/camera.conf:6:1
  |
6 | LookAhead 4
  | ^^^^^^^^^ known here: LookHeight, LookDirection, LookDistance, EdgeMinOffset, ExpectedPositionY

error: `Latitude` is out of range
  --> settings/sky.conf:11:10
   |
11 | Latitude 100
   |          ^^^ allowed: a number from -90 to 90

error: `Turbidity` is out of range
  --> settings/sky.conf:12:11
   |
12 | Turbidity 0
   |           ^ allowed: a number from 1.7 to 10

error: `terrain.conf` is missing
--> settings/terrain.conf
 = note: every folder of settings has it
",
    ),
];

/// A line at the end of a file.
fn add(folder: &mut Folder, file: &str, line: &str) {
    *folder = and(folder, file, &format!("\n{line}\n"));
}
