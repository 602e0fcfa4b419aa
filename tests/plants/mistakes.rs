//! Grammars that are wrong, and grammars that grow beyond measure: an error that points at the place and says what was
//! expected, after bounded work and within 256 MiB.

use std::fs;
use std::io::{Seek, SeekFrom, Write};
use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};
use terrane::world::{self, Overrides, species};

/// Address space of the program, KiB: 256 MiB, and 14 MiB for the program itself.
const LIMIT: u32 = (256 + 14) << 10;

/// Lines of a grammar, where the mistake is (line and column, from 1), what is wrong, what was expected.
type Case = (&'static str, [usize; 2], &'static str, &'static str);

#[rustfmt::skip]
const MISTAKES: &[Case] = &[
    ("", [1, 1], "there is no axiom", "a line `axiom WORD`"),
    ("A -> F", [1, 7], "there is no axiom", "a line `axiom WORD`"),
    ("axiom", [1, 1], "the axiom is empty", "a word behind it"),
    ("axiom = F", [1, 1], "the axiom is no constant", "`axiom WORD`, without `=`"),
    ("axiom F\naxiom A", [2, 1], "there is an axiom already", "one axiom"),
    ("axiom F\nF", [2, 1], "it has no `->`", "`axiom WORD`, `name = expression` or `A -> WORD`"),
    ("axiom F\nF - > A", [2, 1], "it has no `->`", "`A -> WORD`"),
    ("axiom F\np1 : F -> FF", [2, 1], "`p1` is no module, and lines have no labels", "as `A -> WORD`"),
    ("omega : F\nF -> FF", [1, 1], "`omega` is no module", "`axiom WORD`"),
    ("axiom : F", [1, 1], "`axiom` is no module", "`axiom WORD`"),
    ("axiom F\n-> A", [2, 1], "the rule has no module", "what it rewrites, as `A(x)`"),
    ("axiom F\nFF -> A", [2, 2], "unexpected `F`", "one module only"),
    ("axiom F\n[ -> A", [2, 1], "brackets and `%` can't be rewritten", "another symbol"),
    ("axiom F\nQ -> F", [2, 1], "there is never a `Q`", "it stands neither in the axiom nor in the word of a rule"),
    ("axiom F\nQ(x) -> F", [2, 1], "there is never a `Q(x)`", "it stands neither in the axiom nor in the word of a rule"),
    ("axiom A\nA(x) -> F", [2, 1], "there is never a `A(x)`", "`A` stands with no parameter"),
    ("axiom F\n% -> A", [2, 1], "brackets and `%` can't be rewritten", "another symbol"),
    // Brackets and parentheses.
    ("axiom F[+A", [1, 8], "this `[` is not closed", "`]` behind it, in the same word"),
    ("axiom F+A]", [1, 10], "this `]` has no `[`", "`[` before it, in the same word"),
    ("axiom A\nA -> F[[A]", [2, 7], "this `[` is not closed", "`]` behind it"),
    ("axiom A\nA -> F[A]]", [2, 10], "this `]` has no `[`", "`[` before it"),
    ("axiom F(1", [1, 8], "this `(` is not closed", "`)`"),
    ("axiom A(1)\nA(x -> F", [2, 2], "this `(` is not closed", "`)`"),
    ("axiom F(1,)", [1, 11], "unexpected `)`", "a number, a name or `(`"),
    ("axiom F()", [1, 9], "unexpected `)`", "a number, a name or `(`"),
    ("axiom [(1)F]", [1, 8], "unexpected `(`", "a module: `[` has no parameters"),
    ("axiom F)", [1, 8], "unexpected `)`", "a symbol"),
    ("axiom F\nA > [B -> F", [2, 5], "this `[` is not closed", "`]` behind it"),
    ("axiom F\nA > B] -> F", [2, 6], "this `]` has no `[`", "`[` before it"),
    ("axiom F\n[B] < A -> F", [2, 1], "unexpected `[`", "a left context is the path from the root"),
    ("axiom F\nA > B < C -> F", [2, 7], "unexpected `<`", "`LEFT < MODULE > RIGHT`"),
    // Names and numbers.
    ("axiom A(1)\nA(length) -> F(lenght)", [2, 16], "`lenght` is not known here", "did you mean `length`?"),
    ("axiom A(1)\nA(l,w) -> F(z)", [2, 13], "`z` is not known here", "one of `l`, `w`"),
    ("axiom F(r)\nr = 2", [1, 9], "`r` is not known here", "a constant from a line above"),
    ("axiom A(1,1)\nA(x,x) -> F", [2, 5], "two parameters are called `x`", "another name"),
    ("axiom A(1)\nA(1) -> F", [2, 3], "unexpected `1`", "the name of a parameter"),
    ("r = 1\nr = 2\naxiom F", [2, 1], "`r` is defined twice", "another name"),
    ("axiom F(1.2.3)", [1, 9], "`1.2.3` is no number", "digits, as in `0.5` or `1e-3`"),
    ("axiom F(1e400)", [1, 9], "too large", "a finite number"),
    ("axiom F(nan)", [1, 9], "`nan` is not known here", "a constant"),
    ("axiom F(1/0)", [1, 9], "`grammar` can't be read: division by zero", "a finite number"),
    ("r = 0\naxiom F(2+1/r)", [2, 11], "division by zero", "a finite number"),
    ("axiom F(0^-1)", [1, 9], "division by zero", "a finite number"),
    ("axiom F(sqrt(-1))", [1, 9], "a value that is no number", "a finite number"),
    ("axiom F(ln(0))", [1, 9], "a value that is no number", "a finite number"),
    ("axiom F(1e300*1e300)", [1, 9], "too large", "a finite number"),
    ("axiom F(sinus(30))", [1, 9], "there is no function `sinus`", "one of `min`, `max`"),
    ("axiom F(min(1))", [1, 14], "unexpected `)`", "`,`: `min` has two arguments"),
    ("r = rnd(0,1)\naxiom F(r)", [1, 5], "a constant is the same for every seed", "`rnd` in the axiom or in a rule"),
    ("axiom A(1)\nA(x) : 1 < x < 2 -> F", [2, 14], "comparisons can't be chained", "`&&` between two comparisons"),
    ("axiom A(1)\nA(x) : -> F", [2, 8], "something is missing", "a number, a name or `(`"),
    ("axiom A(1)\nA(x) -(x +)> F", [2, 11], "something is missing", "a number, a name or `(`"),
    ("axiom F(2 3)", [1, 11], "unexpected `3`", "an operator, `,` or `)`"),
    ("axiom F*", [1, 8], "unexpected `*`", "a symbol"),
    // Braces, and names of sub-models.
    ("axiom F{FF", [1, 8], "`grammar` can't be right: this `{` is never closed", "`}` behind it"),
    ("axiom FA\nA -> F{.F{.F.}", [2, 7], "this `{` is never closed", "`}` behind it"),
    ("axiom FA\nA -> F}", [2, 7], "this `}` has no `{`", "`{` before it"),
    ("axiom F~", [1, 8], "nothing behind this names a sub-model", "as in `~L(1)`"),
    ("axiom AF\nA -> [F@]F", [2, 8], "nothing behind this names a sub-model", "as in `~L(1)`"),
    ("  axiom F\nA -> F", [2, 1], "indented less than the first one", "all rules in one column"),
];

#[test]
fn mistakes_are_pointed_at_and_say_what_was_expected() {
    let mut wrong = String::new();
    for (grammar, [line, column], problem, expected) in MISTAKES {
        // The grammar begins in the third line of the file.
        let file = format!("format = 1\ngrammar = '''\n{grammar}\n'''\n");
        let report = match species::parse("plant.toml", file.as_bytes()) {
            Ok(_) => panic!("{grammar:?} passes"),
            Err(error) => error.to_string(),
        };
        let place = format!("plant.toml:{}:{column}\n", line + 2);
        if ![*problem, expected, &place].iter().all(|part| report.contains(part)) {
            wrong += &format!("\n{grammar:?} at {line}:{column}: {problem}, {expected}:\n{report}\n");
            continue;
        }
        // The line is shown, and a caret stands below the column.
        let shown: Vec<&str> = report.lines().collect();
        let source = format!("{} |", line + 2);
        let at = shown.iter().position(|shown| shown.trim_start().starts_with(&source)).expect(&report);
        let text = grammar.lines().nth(line - 1).unwrap_or_default();
        assert!(shown[at].contains(text), "{report}");
        let margin = shown[at].find('|').unwrap() + 2;
        let caret = shown[at + 1].find('^').unwrap_or_else(|| panic!("no caret:\n{report}"));
        let before = text.chars().count().min(column - 1);
        assert_eq!(shown[at + 1][..caret].chars().count(), margin + before, "{report}");
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// The first of every line, in the order of the text; and no mistake that is none but for another one.
#[test]
fn one_run_tells_the_mistakes_of_all_lines() {
    let grammar = "r = 1/0\naxiom F(r)A(r)\nA(x) -> F(y)\nB -> [F";
    let file = format!("format = 1\ngrammar = '''\n{grammar}\n'''\n");
    let report = species::parse("plant.toml", file.as_bytes()).unwrap_err().to_string();
    let places: Vec<&str> = report.lines().filter_map(|line| line.trim().strip_prefix("--> ")).collect();
    assert_eq!(places, ["plant.toml:3:5", "plant.toml:5:11", "plant.toml:6:6"], "{report}");
}

/// What one word leaves open another may close, and what places a sub-model may stand in another word than its name.
#[test]
fn braces_and_names_may_come_from_other_words() {
    for grammar in [
        "axiom {AB\nA -> F+FF\nB -> }",
        "axiom A\nA -> F{FB\nB -> +F}",
        "axiom {F%\nF -> F",
        "axiom AL\nA -> F~",
        "axiom A~\n~ -> F",
    ] {
        let file = format!("format = 1\ngrammar = '''\n{grammar}\n'''\norgans.L.grammar = 'axiom F'\n");
        if let Err(error) = species::parse("plant.toml", file.as_bytes()) {
            panic!("{grammar:?}: {error}");
        }
    }
}

/// Long words and numbers don't fill the screen.
#[test]
fn messages_are_cut() {
    let name = "n".repeat(5000);
    for grammar in [
        format!("axiom F({name})"),
        format!("{name} = 1\n{name} = 2\naxiom F"),
        format!("axiom F({name}(1))"),
    ] {
        let file = format!("format = 1\ngrammar = '''\n{grammar}\n'''\n");
        let report = species::parse("plant.toml", file.as_bytes()).unwrap_err().to_string();
        assert!(report.lines().next().unwrap().len() < 200, "{report}");
    }
    let folder = tempfile::tempdir().unwrap();
    for (grammar, wanted) in [
        ("axiom A(2)\nA(x) -(x-1e300)> A(x)", "the weight is -1e300,"),
        ("axiom F(1e300)", "reaches 1e300 m"),
    ] {
        let file = format!("format = 1\ngrammar = '''\n{grammar}\n'''\n");
        fs::write(folder.path().join("plant.toml"), file).unwrap();
        let told = refused(folder.path(), 3, grammar);
        assert!(told.contains(wanted) && !told.contains("00000000"), "{told}");
    }
}

/// A file of one kind where the other is wanted is one mistake, not one a key.
#[test]
fn species_are_no_worlds() {
    let overrides = Overrides::default();
    let species = b"format = 1\nsteps = 2\nangle = 20\ngrammar = 'axiom F'\n";
    let error = world::parse("oak.toml", species, Path::new(""), &overrides).unwrap_err().to_string();
    assert!(
        error.starts_with("`grammar` makes this the file of a species") && !error.contains("`steps`"),
        "{error}"
    );
    let world = b"format = 1\nseed = 2\nterrain.cells = 64\n";
    let error = species::parse("island.toml", world).unwrap_err().to_string();
    assert!(error.starts_with("`terrain` makes this a world") && !error.contains("`seed`"), "{error}");
}

// In worlds ----------------------------------------------------------------------------------------------------------

const WORLD: &str = "format = 1\nplants = [{ scatter = { species = [\"a\"] } }]\n";
const ZERO: &str = "steps = 4\ngrammar = '''\naxiom A(3)\nA(n) -> F(1/n)A(n-1)\n'''\n";

/// `terrane check` finds what is wrong with plants before there is land, and points at the line that is to blame.
#[test]
fn worlds_tell_where_a_species_fails_to_grow() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("here.toml"), format!("{WORLD}[species.a]\n{ZERO}")).unwrap();
    fs::write(at("named.toml"), format!("{WORLD}species.a.file = 'a.toml'\n")).unwrap();
    fs::write(at("a.toml"), format!("format = 1\n{ZERO}")).unwrap();
    let set = ["--set", r#"species.a.grammar="axiom A(0)\nA(n) -> F(1/n)""#];
    for (arguments, place) in [
        (&["here.toml"][..], "here.toml:7:11"),
        (&["named.toml"], "a.toml:5:11"),
        (&["here.toml", set[0], set[1]], "--set species.a.grammar"),
    ] {
        let (code, told) = checked(folder.path(), arguments);
        assert_eq!(code, Some(3), "{told}");
        assert!(told.contains("can't grow: step") && told.contains("division by zero"), "{told}");
        assert!(told.contains(place) && told.contains("^^^ this has no value"), "{told}");
    }
    let (code, told) = checked(folder.path(), &["here.toml", "--set", "species.a.steps=2"]);
    assert_eq!(code, Some(0), "{told}");
}

#[test]
fn worlds_tell_which_rule_plants_too_much() {
    let folder = tempfile::tempdir().unwrap();
    let world = "format = 1\nspecies.a = { grammar = 'axiom F' }\n";
    for (rule, wanted) in [
        (
            "grid = { species = ['a'], cells = [9000, 9000], cell_size = 0.5 }",
            "`plants.0.grid` would bring the plants to about 81000000",
        ),
        (
            "cover = { species = ['a'], density = 1000, near = 100, reach = 100 }",
            "`plants.0.cover` would bring",
        ),
        (
            "cover = { species = ['a'], density = 10000, near = 1, reach = 9000 }",
            "`plants.0.cover` looks for places",
        ),
        ("scatter = { species = ['a'], spacing = 0.05 }", "`plants.0.scatter` looks for places"),
    ] {
        fs::write(folder.path().join("world.toml"), format!("{world}plants = [{{ {rule} }}]\n")).unwrap();
        let (code, told) = checked(folder.path(), &["world.toml"]);
        assert_eq!(code, Some(3), "{rule}: {told}");
        assert!(told.contains(wanted), "{rule}: {told}");
    }
}

/// The error is about a file of the folder, not about a text that nobody has written.
#[test]
fn folders_of_settings_tell_which_file_fails() {
    let folder = tempfile::tempdir().unwrap();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/thesis/default");
    for (file, from, to, wanted) in [
        ("trees/fork.lsys", "N 6", "N 16", "lower `N`"),
        (
            "spawners/meadow.spawner",
            "N 40\nZGridN 40\nCellSize 0.6",
            "N 4000\nZGridN 4000\nCellSize 0.01",
            "would bring the plants to",
        ),
    ] {
        let _ = fs::remove_dir_all(folder.path().join("settings"));
        copy(&shipped, &folder.path().join("settings"));
        assert_eq!(checked(folder.path(), &["settings"]).0, Some(0));
        let path = folder.path().join("settings").join(file);
        let text = fs::read_to_string(&path).unwrap().replace(from, to);
        fs::write(&path, text).unwrap();
        let (code, told) = checked(folder.path(), &["settings"]);
        assert_eq!(code, Some(3), "{told}");
        assert!(told.starts_with(&format!("error: `settings/{file}` ")) && told.contains(wanted), "{told}");
        assert!(!told.contains("species.") && !told.contains("plants.0"), "{told}");
    }
}

/// Growth that would end by itself, and is cut short.
#[test]
fn steps_that_are_too_few_are_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let species = |steps: u32, rules: &str| format!("steps = {steps}\ngrammar = '''\n{rules}\n'''\n");
    let ends = "axiom A(0)\nA(k) : k < 9 -> F[+F]A(k+1)";
    let twig = format!("axiom F~L\n'''\n[organs.L]\nsteps = 7\ngrammar = '''\n{ends}");
    for (text, wanted) in [
        (species(3, ends), "plant.toml:2: `steps` cut the growth short after 3: it ends by itself after 9;"),
        (species(9, ends), ""),
        (
            species(2, &twig),
            "plant.toml:7: `organs.L.steps` cut the growth short after 7: it ends by itself after 9;",
        ),
        // These go on for ever: that they end somewhere is meant.
        (species(3, "axiom F\nF -> F[+F]F"), ""),
        (species(3, "axiom A(1)\nA(l) -> F(l)[+A(l/2)]A(l/2)"), ""),
    ] {
        fs::write(at("plant.toml"), format!("format = 1\n{text}")).unwrap();
        let output = terrane(folder.path(), &["plant", "plant.toml", "--stats"]);
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{told}");
        assert_eq!(told.contains("warning"), !wanted.is_empty(), "{told}");
        assert!(told.contains(wanted), "{told}");
    }
    // Once a species, however many variants it has.
    fs::write(at("world.toml"), format!("{WORLD}[species.a]\nvariants = 3\n{}", species(3, ends))).unwrap();
    let output = terrane(folder.path(), &["check", "--no-time", "world.toml"]);
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(told.matches("world.toml:5: `species.a.steps` cut the growth short").count(), 1, "{told}");
}

/// Exit code and standard error of `terrane check`.
fn checked(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let output = terrane(folder, &[&["check", "--no-time", "--quiet"], arguments].concat());
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!told.contains("panicked"), "{told}");
    (output.status.code(), told)
}

fn terrane(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_terrane"));
    command.args(arguments).current_dir(folder).env("TERRANE_CACHE", folder.join("cache")).output().unwrap()
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().map(Result::unwrap) {
        let to = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &to);
        } else {
            fs::copy(entry.path(), to).unwrap();
        }
    }
}

/// What is odd is said, with its place, and grows all the same.
#[test]
fn what_is_hardly_meant_is_warned_of() {
    for (grammar, line, wanted) in [
        ("axiom A\nA -> F\nA -> B", "5", "this rule for `A` is never tried"),
        ("axiom F\nB -> A\nA -> B", "4", "there is never a `B`"),
        ("r = 2\naxiom F", "3", "`r` is not used"),
        ("r = 2\naxiom A(r)\nA(r) -> F(r)", "5", "the parameter `r` hides a constant"),
        ("axiom A(1)A(1,2)\nA(x,y) -> F", "3", "no rule is for `A` with 1 parameter"),
        ("#ignore : + -\naxiom F", "3", "`ignore = \"+-\"`"),
        ("axiom F\n#define r 3 * 2", "4", "`r = 3 * 2`"),
        ("axiom F\n#include <stdio.h>", "4", "`#include` begins a comment"),
        ("axiom F\nF -> !(1-2)F", "4", "this width is negative"),
        ("axiom ~FA\nA -> F\nF -> FF", "3", "the sub-model `F` has a rule"),
    ] {
        let file = format!("format = 1\ngrammar = '''\n{grammar}\n'''\norgans.F.grammar = 'axiom F'\n");
        let loaded = species::parse("plant.toml", file.as_bytes()).unwrap_or_else(|error| panic!("{error}"));
        let told = loaded.warnings.join("\n");
        assert!(
            told.contains(wanted) && told.contains(&format!("plant.toml:{line}:")),
            "{grammar:?}: {told}"
        );
    }
}

// Growth -------------------------------------------------------------------------------------------------------------

/// Keys and grammar, where the rule to blame stands, and what the message says.
#[rustfmt::skip]
const GROWTH: &[(&str, &str, &str, &[&str])] = &[
    ("steps = 24", "axiom A\nA -> AA", "5:1", &["step 24", "the rule for `A`", "16777216 modules", "10000000 are allowed"]),
    ("steps = 1000", "axiom A\nB -> C\nA -> [A]AB", "6:1", &["the rule for `A`", "are allowed"]),
    ("steps = 100000", "axiom A\nA -> AF", "5:1", &["the rule for `A`", "more than 1000000000 operations"]),
    ("steps = 40", "axiom A\nA -> A(1,2,3,4,5,6,7,8)A(1,2,3,4,5,6,7,8)A\nA(a,b,c,d,e,f,g,h) -> A(a,b,c,d,e,f,g,h)A(a,b,c,d,e,f,g,h)", "6:1", &["bytes", "are allowed"]),
    ("steps = \"auto\"", "axiom A(0)\nA(x) -> A(x+1)", "5:1", &["still changes after 100000 steps"]),
    ("steps = 3", "axiom A\nA -> *", "5:1", &["step 1", "the word is empty"]),
    ("steps = 3", "axiom F[A%B]\nF -> %", "4:7", &["step 2", "the word is empty"]),
    ("steps = 5", "axiom A(2)\nA(x) -> F(1/x)A(x-1)", "5:11", &["step 3", "the rule for `A(x)`", "division by zero"]),
    ("steps = 5", "axiom A(2)\nA(x) : 1/x > 0 -> A(x-1)", "5:8", &["division by zero"]),
    ("steps = 5", "axiom A(2)\nA(x) -> A(sqrt(x-3))", "5:11", &["step 1", "a value that is no number"]),
    ("steps = 900", "axiom A(2)\nA(x) -> A(x*x)", "5:11", &["too large"]),
    ("steps = 5", "axiom A(2)\nA(x) -(x-3)> A(x)", "5:8", &["the weight is -1", "can't be negative"]),
    ("steps = 5", "axiom A(2)\nA(x) -(x-2)> A(x)", "5:1", &["no rule that could apply has a weight above 0"]),
    // A context that is looked for through the whole word, for every module of it.
    ("steps = 20\nignore = 'F'", "axiom F\nF > [C] -> F\nF -> FF", "6:1", &["the rule for `F`", "more than 1000000000 operations"]),
];

#[test]
fn growth_is_limited_before_memory_is_taken() {
    let folder = tempfile::tempdir().unwrap();
    for (keys, grammar, place, wanted) in GROWTH {
        let name = format!("{keys}, {grammar}");
        fs::write(
            folder.path().join("plant.toml"),
            format!("format = 1\n{keys}\ngrammar = '''\n{grammar}\n'''\n"),
        )
        .unwrap();
        let told = refused(folder.path(), 3, &name);
        assert!(wanted.iter().all(|part| told.contains(part)), "{name}:\n{told}");
        assert!(told.contains(&format!("plant.toml:{place}")) && told.contains('^'), "{name}:\n{told}");
    }
}

/// What is drawn has limits, too.
#[test]
fn drawings_are_limited_as_well() {
    let folder = tempfile::tempdir().unwrap();
    for (keys, grammar, organs, wanted) in [
        ("steps = 22", "axiom A\nA -> AF", "", ""),
        ("steps = 21", "axiom A\nA -> FAA", "", "points"),
        ("steps = 1", "axiom {FA}\nA -> }F{", "", ""),
        ("steps = 1", "axiom FAB\nA : 1 > 2 -> }\nB -> {", "", "it is never closed by `}`"),
        ("steps = 1", "axiom FAB\nA -> }\nB : 1 > 2 -> {", "", "there is no `{` that it closes"),
        ("steps = 1", "axiom FA\nA -> F~", "", "names a sub-model"),
        ("steps = 400", "axiom A(1)\nA(x) -> F(x)A(x*10)", "", ""),
        // An organ in an organ in an organ.
        (
            "steps = 10",
            "axiom A\nA -> [~L]A[~L]A",
            "[organs.L]\ngrammar = 'axiom ~M~M~M~M'\n[organs.M]\ngrammar = 'axiom ~N~N~N~N'\n[organs.N]\ngrammar = '''\naxiom F\nF -> [+F]F[-F]F\n'''\nsteps = 7",
            "",
        ),
    ] {
        let text = format!("format = 1\n{keys}\ngrammar = '''\n{grammar}\n'''\n{organs}\n");
        fs::write(folder.path().join("plant.toml"), text).unwrap();
        let output = limited(folder.path(), LIMIT);
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(!told.contains("panicked"), "{grammar}: {told}");
        let code = if wanted.is_empty() { output.status.code() } else { Some(3) };
        assert!(matches!(code, Some(0 | 3)) && output.status.code() == code, "{grammar}: {code:?} {told}");
        assert!(told.contains(wanted), "{grammar}: {told}");
    }
}

/// Plants of a world grow side by side, and share the memory that one may have. What needs more than a share grows for all that.
#[test]
fn plants_that_grow_side_by_side_keep_to_the_limit_together() {
    let folder = tempfile::tempdir().unwrap();
    let rule = "A(x,y,z) -> A(x,y,z)A(y,z,rnd(0,1))";
    for (steps, code) in [(22, 0), (30, 3)] {
        let text = format!(
            "format = 1\nplants = [{{ scatter = {{ species = ['a'] }} }}]\nspecies.a.variants = 4\n\
             species.a.steps = {steps}\nspecies.a.grammar = '''\naxiom FA(1,2,3)\n{rule}\n'''\n"
        );
        fs::write(folder.path().join("world.toml"), text).unwrap();
        for threads in ["1", "4"] {
            let arguments = ["check", "world.toml", "--no-time", "--quiet"];
            // Four stacks of 2 MiB, and what the world itself takes.
            let output = within(folder.path(), LIMIT + (16 << 10), &arguments, threads);
            let told = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(code), "{steps} steps, {threads} threads: {told}");
            assert!(code == 0 || told.contains("201326592 are allowed"), "{threads} threads: {told}");
        }
    }
    // The file is right.
    let text = "format = 1\nplants = [{ scatter = { species = ['a'] } }]\n\
                species.a = { steps = 2, grammar = \"axiom FA\\nA -> AA\" }\n";
    fs::write(folder.path().join("world.toml"), text).unwrap();
    let arguments = ["check", "world.toml", "--no-time", "--quiet", "--set", "species.a.steps=30"];
    let output = within(folder.path(), LIMIT + (16 << 10), &arguments, "1");
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{told}");
    assert!(told.contains("--set species.a.steps=30") && !told.contains("world.toml:"), "{told}");
    assert!(told.contains("`species.a.steps` is too much: step 24"), "{told}");
}

/// A plant of which nothing is seen has one level of detail, and says so.
#[test]
fn what_draws_nothing_is_told() {
    let folder = tempfile::tempdir().unwrap();
    for (keys, grammar, is_empty) in
        [("width = 0", "FF", true), ("", "!(-1)FF", true), ("", "f", true), ("", "F", false)]
    {
        let text = format!("format = 1\n{keys}\ngrammar = 'axiom {grammar}'\n");
        fs::write(folder.path().join("plant.toml"), text).unwrap();
        let arguments = ["plant", "plant.toml", "--stats", "--json", "-o", "plant.glb"];
        let output = within(folder.path(), LIMIT, &arguments, "1");
        let told = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "{told} {}", String::from_utf8_lossy(&output.stderr));
        assert_eq!(told.contains("draws nothing"), is_empty, "{keys} {grammar}: {told}");
        let file = fs::read(folder.path().join("plant.glb")).unwrap();
        let has_null = file.windows(4).any(|bytes| bytes == b"null" || bytes == b"NaN ");
        assert!(!has_null, "{keys} {grammar}");
    }
}

#[test]
fn files_without_measure_are_refused_by_their_size() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plant.toml");
    // A gigabyte, most of it a hole: to read it would take a gigabyte of memory.
    let mut file = fs::File::create(&path).unwrap();
    file.write_all(b"format = 1\ngrammar = '''\naxiom F\n").unwrap();
    file.seek(SeekFrom::Start(1 << 30)).unwrap();
    file.write_all(b"'''").unwrap();
    drop(file);
    let told = refused(folder.path(), 3, "a gigabyte");
    assert!(told.contains("plant.toml is too large") && told.contains("1048576 bytes"), "{told}");

    // As long as may be, in one line, in one word, in brackets.
    let fill = |text: &str| text.repeat((1 << 20) / text.len() - 40);
    for (name, grammar) in [
        ("a word", format!("axiom {}", fill("F"))),
        ("brackets", format!("axiom {}F{}", "[".repeat(400_000), "]".repeat(400_000))),
        ("parentheses", format!("axiom F({}1{})", "(".repeat(400_000), ")".repeat(400_000))),
        ("signs", format!("axiom F({}1)", fill("-"))),
        ("sums", format!("axiom F({}1)", fill("1+"))),
        ("powers", format!("axiom F({}1)", fill("1^"))),
        ("rules", format!("axiom F\n{}", fill("F : 0 -> F\n"))),
        ("symbols", format!("axiom {}", ('\u{4e00}'..='\u{9fff}').cycle().take(300_000).collect::<String>())),
        ("constants", (0..70_000).map(|name| format!("a{name}=1\n")).collect::<String>() + "axiom F"),
        ("contexts", format!("axiom F\n{}", fill("F[F][F]F < F > F[F][F]F -> F\n"))),
        ("a context", format!("axiom FF\nF > {} -> F", "[".repeat(400_000))),
        ("parameters", format!("axiom F({}1)", fill("1,"))),
    ] {
        let text = format!("format = 1\nsteps = 2\ngrammar = '''\n{grammar}\n'''\n");
        fs::write(&path, text).unwrap();
        let start = Instant::now();
        let output = limited(folder.path(), LIMIT);
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(matches!(output.status.code(), Some(0 | 3)), "{name}: {:?} {told}", output.status);
        assert!(!told.contains("panicked") && start.elapsed() < Duration::from_secs(60), "{name}: {told}");
        // A report of a long line is not as long as the line.
        assert!(told.len() < 40_000, "{name}: {} bytes of report", told.len());
    }
}

/// A checker that lets everything pass would be no good.
#[test]
fn what_is_sound_passes_and_too_much_memory_does_not() {
    let folder = tempfile::tempdir().unwrap();
    // Two words of 16 MiB.
    let text = "format = 1\nsteps = 23\ngrammar = '''\naxiom FA\nA -> AA\n'''\n";
    fs::write(folder.path().join("plant.toml"), text).unwrap();
    assert_eq!(limited(folder.path(), LIMIT).status.code(), Some(0));
    assert_ne!(limited(folder.path(), 32 << 10).status.code(), Some(0));
}

/// The program's error about `plant.toml`.
fn refused(folder: &Path, code: i32, name: &str) -> String {
    let start = Instant::now();
    let output = limited(folder, LIMIT);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{name}: {told}");
    assert!(told.starts_with("error: ") && !told.contains("panicked"), "{name}: {told}");
    // Not a measurement: hours are what this is about.
    assert!(start.elapsed() < Duration::from_secs(300), "{name} takes forever");
    told
}

fn limited(folder: &Path, kib: u32) -> Output {
    within(folder, kib, &["plant", "plant.toml", "--stats", "--quiet"], "1")
}

fn within(folder: &Path, kib: u32, arguments: &[&str], threads: &str) -> Output {
    Command::new("sh")
        .args(["-c", &format!("ulimit -v {kib} && exec \"$0\" \"$@\"")])
        .arg(env!("CARGO_BIN_EXE_terrane"))
        .args(arguments)
        .current_dir(folder)
        .env("RAYON_NUM_THREADS", threads)
        // One heap: glibc has one for each thread, of 64 MiB of addresses, and each keeps some of what was freed. What is
        // measured is what the program holds.
        .env("MALLOC_ARENA_MAX", "1")
        .output()
        .unwrap()
}
