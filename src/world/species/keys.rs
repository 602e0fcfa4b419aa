//! The keys of a species file, and of a species that a world has in its own file.

use crate::plants::turtle::Side;
use crate::world::fault::Complaint;
use crate::world::keys::{DEGREES, Format, M, NONE, PER_M};
use crate::world::kinds::*;
use crate::world::place::Place;
use crate::world::schema::{self, Key, Kind, Names, REQUIRED, Section, Table, section};

section! {
    /// A kind of plant: the rules of its growth, what its symbols draw, and what it is made of.
    struct Species {
        /// What it is, and where its rules come from.
        about: String = text("a text", ""),
        /// The L-system: an axiom and productions, one a line. `docs/plants.md` tells the language.
        grammar: String = text(GRAMMAR, REQUIRED),
        /// How often the axiom is rewritten.
        steps: Option<u32> = word_or("auto", "Until nothing changes.", whole(5, 0..=100_000)),
        /// Turn of `+ - & ^ \ /` without a parameter.
        angle: f64 = angle(),
        /// Turn of `& ^` without a parameter.
        pitch: Option<f64> = optional(angle(), "that of `angle`"),
        /// Turn of `\ /` without a parameter.
        roll: Option<f64> = optional(angle(), "that of `angle`"),
        /// Symbols that move the turtle and draw a segment.
        draw: String = text("symbols", "F"),
        /// Symbols that move it and draw nothing.
        r#move: String = text("symbols", "f"),
        /// Symbols that move it and leave no vertex in a polygon.
        silent: String = text("symbols", "G"),
        /// Symbols that are no context of others.
        ignore: String = text("symbols", ""),
        /// The way that `+` turns.
        plus: Side = choice([
            ("left", "as in \"The Algorithmic Beauty of Plants\"", Side::Left),
            ("right", "the other way", Side::Right),
        ]),
        /// Diameter of segments before the first `!`.
        width: f64 = exact(number(0.1, M, 0.0..=1000.0)),
        /// What `!` without a parameter multiplies the diameter by: 0.707 halves the cross-section.
        taper: f64 = exact(number(0.707, NONE, 0.0..=1.0)),
        /// What segments turn towards as they grow: light above, weight below.
        tropism: Option<Tropism> = word_or("none", "They grow as the rules say.", table::<Tropism>()),
        /// How many different plants there are of it: each has its own random numbers.
        variants: u32 = whole(1, 1..=64),
        /// Vertical extent that every plant is scaled to.
        height: Option<f32> = height(),
        /// What its parts are made of.
        materials: Vec<(String, Material)> = named(Names::Words, table::<Material>(), DEFAULT_MATERIALS),
        /// The material of segments.
        wood: Option<String> = optional(text("a name of `materials`", ""), "the first of `materials`"),
        /// Materials of polygons: the first one, and the next after every `'`.
        leaves: Option<Vec<String>> = optional(
            list(text("a name of `materials`", ""), 1..=64, "[]"),
            "those of `materials` behind the first",
        ),
        /// Sub-models, by the symbol that places them: `~L(s)` places the organ `L`, scaled by `s`.
        organs: Vec<(String, Organ)> = named(Names::Symbols, table::<Organ>(), "{}"),
    }
}

const GRAMMAR: &str = "an L-system in quotes, best between three of them";

fn angle() -> Exact {
    exact(number(90.0, DEGREES, -360.0..=360.0))
}

fn height() -> Optional<Number> {
    optional(number(10.0, M, 1e-3..=1000.0), "as it grows")
}

const DEFAULT_MATERIALS: &str = r#"{
    bark = { reflectance = [0.13, 0.1, 0.075] },
    leaf = { reflectance = [0.05, 0.1, 0.025], transmittance = [0.05, 0.11, 0.013] },
}"#;

section! {
    /// Segments turn as they grow: each by `strength · |H × direction|` radians, H its heading (Prusinkiewicz &
    /// Lindenmayer 1990, section 2.1).
    struct Tropism {
        /// What they turn towards: metres east, up and south. Its length counts.
        direction: [f64; 3] = exacts([0.0, -1.0, 0.0], NONE, -1000.0..=1000.0),
        /// Their willingness, e.
        strength: f64 = exact(number(0.1, NONE, -100.0..=100.0)),
    }
}

section! {
    /// A material: its colour in the world is `mix(reflectance, second_reflectance, clamp(noise(p · position_factor) ·
    /// value_factor, 0, 1))`, with Perlin's noise of 2002 from 0 to 1 at the place p.
    struct Material {
        /// Light that it scatters back.
        reflectance: [f32; 3] = colour("#7a6a58"),
        /// The other colour, which noise mixes in.
        second_reflectance: Option<[f32; 3]> = optional(colour("#7a6a58"), "the same as `reflectance`"),
        /// How fine the mixture is.
        position_factor: f32 = number(1.0, PER_M, 0.0..=10_000.0),
        /// How strong it is.
        value_factor: f32 = number(1.0, NONE, 0.0..=100.0),
        /// Light that it lets through, which leaves do.
        transmittance: [f32; 3] = colour("#000000"),
        /// Of its thin gloss; 1 is without one.
        refractive_index: f32 = number(1.0, NONE, 1.0..=3.0).usual(1.0..=1.5),
        /// Of the gloss: 0 is a mirror, 1 has no highlight to speak of.
        roughness: f32 = number(1.0, NONE, 0.0..=1.0),
        /// Depth of furrows, as in bark; they are some eight times as far apart, and run upwards.
        relief: f32 = number(0.0, M, 0.0..=1.0),
    }
}

section! {
    /// A sub-model, placed at the turtle's heading, left and up: polygons, or an L-system of its own, which may place
    /// other organs.
    struct Organ {
        /// Its polygons.
        polygons: Vec<Outline> = list(table::<Outline>(), 0..=10_000, "[]"),
        /// Its L-system. `draw`, `move`, `silent`, `ignore` and `plus` are the plant's.
        grammar: String = text(GRAMMAR, ""),
        /// How often its axiom is rewritten.
        steps: Option<u32> = word_or("auto", "Until nothing changes.", whole(5, 0..=100_000)),
        /// Turn of `+ - & ^ \ /` without a parameter.
        angle: Option<f64> = optional(angle(), "the plant's"),
        /// Diameter of segments before the first `!`.
        width: f64 = exact(number(0.01, M, 0.0..=1000.0)),
        /// The material of segments.
        wood: Option<String> = optional(text("a name of `materials`", ""), "the plant's"),
        /// Materials of polygons.
        leaves: Option<Vec<String>> =
            optional(list(text("a name of `materials`", ""), 1..=64, "[]"), "the plant's"),
    }
}

section! {
    /// A polygon, concave if need be.
    struct Outline {
        /// What it is made of.
        material: Option<String> = optional(text("a name of `materials`", ""), "the first of `leaves`"),
        /// Its corners, in order: metres along the turtle's heading, to its left and upwards.
        vertices: Vec<[f64; 3]> = list(exacts([0.0; 3], M, -1000.0..=1000.0), 3..=10_000, "[]"),
    }
}

/// A species file: its format and the keys of a species.
pub(super) struct SpeciesFile(pub Species);

impl Section for SpeciesFile {
    const ABOUT: &'static str = Species::ABOUT;

    fn keys() -> Vec<Key> {
        let about = "Version of the format, 1.";
        let format = Key {
            name: "format",
            about,
            default: Format.default(),
            start: Format.start(),
            shape: Format.shape(),
        };
        std::iter::once(format).chain(Species::keys()).collect()
    }

    fn read(place: &Place) -> Self {
        Format.read(&place.key("format"));
        SpeciesFile(Species::read(place))
    }
}

/// Everything that may stand in a species file, as data.
pub fn shape() -> Table {
    Table { about: SpeciesFile::ABOUT, keys: SpeciesFile::keys(), presets: &[] }
}

/// A species of a world.
#[derive(Clone, Debug)]
pub enum Entry {
    File(Named),
    Here(Box<Species>),
}

section! {
    /// A kind of plant: a species file, or its keys written here.
    struct Named {
        /// A species file. Beside it only `variants` and `height` may stand, which win over the file's.
        file: Option<String> = required_file(),
        /// How many different plants there are of it: each has its own random numbers.
        variants: Option<u32> = optional(whole(1, 1..=64), "the file's"),
        /// Vertical extent that every plant is scaled to.
        height: Option<f32> = height(),
    }
}

/// The kind of a world's species.
pub struct EntryKind;

impl Kind for EntryKind {
    type Value = Entry;

    fn shape(&self) -> schema::Shape {
        let file = Named::keys().into_iter().take(1).map(|key| Key { default: "none".into(), ..key });
        let own = Species::keys().into_iter().map(|key| match key.name {
            "grammar" => Key { default: "required without `file`".into(), ..key },
            _ => key,
        });
        schema::Shape::Table(Table { about: Named::ABOUT, keys: file.chain(own).collect(), presets: &[] })
    }

    fn default(&self) -> String {
        "{}".into()
    }

    fn read(&self, place: &Place) -> Entry {
        if place.key("file").item().is_none() {
            return Entry::Here(Box::new(read_section(place)));
        }
        let names = Species::names().into_iter();
        for name in names.filter(|name| !["variants", "height"].contains(name)) {
            if place.key(name).item().is_some() {
                let label = "write it in that file, or all of the species here";
                place.key(name).refuse(Complaint::new("can't stand beside `file`", label).about_key());
            }
        }
        Entry::File(Named::read(place))
    }
}
