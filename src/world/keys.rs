//! Every key of a world file: its name, kind, unit, range, default and meaning, one row each. Reading, messages and
//! the reference page come from these rows; [`plan`](super::plan) turns what they yield into values for the makers.

use super::fault::Complaint;
use super::kinds::*;
use super::place::{Place, noun};
use super::schema::{Kind, Names, Preset, REQUIRED, Shape, Unit, section};
use super::{models, planting, species};
use crate::formats::{FirstRow, raw::ByteOrder};
use crate::scene;
use crate::terrain::{Boundary, FARTHEST_GROUND, hydraulic, reef, thermal};
use crate::trace::MOST_SAMPLES;
use crate::zoom::address::Location;
use crate::zoom::height::{Refinement, Roughness};

pub const NONE: Unit = Unit { symbol: "", factor: 1.0 };
pub const M: Unit = Unit { symbol: "m", factor: 1.0 };
pub const PER_M: Unit = Unit { symbol: "m⁻¹", factor: 1.0 };
const S: Unit = Unit { symbol: "s", factor: 1.0 };
const PER_S: Unit = Unit { symbol: "s⁻¹", factor: 1.0 };
const M_PER_S: Unit = Unit { symbol: "m/s", factor: 1.0 };
const M_PER_S2: Unit = Unit { symbol: "m/s²", factor: 1.0 };
const M2_PER_S: Unit = Unit { symbol: "m²/s", factor: 1.0 };
const MM_PER_H: Unit = Unit { symbol: "mm/h", factor: 1e-3 / 3600.0 };
const YEARS: Unit = Unit { symbol: "yr", factor: 1.0 };
const M_PER_YEAR: Unit = Unit { symbol: "m/yr", factor: 1.0 };
const M2_PER_YEAR: Unit = Unit { symbol: "m²/yr", factor: 1.0 };
pub const DEGREES: Unit = Unit { symbol: "degrees", factor: std::f64::consts::PI / 180.0 };
const HOURS: Unit = Unit { symbol: "h", factor: 1.0 };
const LUX: Unit = Unit { symbol: "lx", factor: 1.0 };
const CD_PER_M2: Unit = Unit { symbol: "cd/m²", factor: 1.0 };
const M2_PER_CD: Unit = Unit { symbol: "m²/cd", factor: 1.0 };

section! {
    /// A world: land, sea, light and a camera. Every section may be left out; what a world does not say has its
    /// default, and `"none"` switches off what can be switched off. Numbers in brackets are equations of Korošec & Lebar
    /// Bajec, "Procedural generation of a tropical island and coral reef".
    struct World {
        /// Version of the format, 1.
        format: () = Format,
        /// Where randomness starts. Every consumer derives its own seed from it and its key, so that adding one
        /// never changes another.
        seed: u32 = whole(1, 0..=u32::MAX),
        /// The grid and the land before erosion.
        terrain: Terrain = table::<Terrain>(),
        /// Maps that scale the processes from place to place.
        controls: Controls = table::<Controls>(),
        /// Water and gravity at work on the land.
        erosion: Option<Erosion> = or_none(table::<Erosion>()),
        /// Coral that grows round the land after erosion.
        reef: Option<reef::Params> = or_none(table::<reef::Params>()),
        /// Level and optics of the sea.
        sea: scene::Sea = table::<scene::Sea>(),
        /// How bare ground is coloured.
        surface: scene::Surface = table::<scene::Surface>(),
        /// Light of the sky.
        sky: Sky = one_of([
            tag("preetham", Sky::Preetham),
            tag("hosek_wilkie", Sky::HosekWilkie),
            tag("constant", Sky::Constant),
            tag("map", Sky::Map),
            word("none", "No light from the sky.", Sky::None),
        ]),
        /// Light of the sun.
        sun: Sun = one_of([
            tag("place", Sun::Place),
            tag("direct", Sun::Direct),
            word("none", "No sun.", Sun::None),
        ]),
        /// Kinds of plants, by names of your own.
        species: Vec<(String, species::Entry)> = named(Names::Words, species::EntryKind, "{}"),
        /// Models from files: rocks, houses, plants of other programs.
        models: Vec<models::Model> = list(table::<models::Model>(), 0..=256, "[]"),
        /// Where plants stand: rules, from the largest plants to the smallest.
        plants: Vec<planting::Rule> = list(planting::rule(), 0..=64, "[]"),
        /// An endless approach to a fractal surface, in place of land and sea.
        zoom: Option<Zoom> = word_or("none", "A world of land and sea.", table::<Zoom>()),
        /// Where the picture is seen from.
        camera: Camera = table::<Camera>(),
        /// The picture itself.
        render: Render = table::<Render>(),
    }
}

/// The version of the format: `1`, always written.
pub struct Format;

impl Kind for Format {
    type Value = ();

    fn shape(&self) -> Shape {
        Shape::Whole { range: [1, 1] }
    }

    fn default(&self) -> String {
        REQUIRED.into()
    }

    fn start(&self) -> String {
        "1".into()
    }

    fn read(&self, place: &Place) {
        match place.item() {
            None => place.refuse(Complaint::new("is missing", "begin the file with `format = 1`")),
            Some(item) if item.as_integer() == Some(1) => {}
            Some(item) if item.as_integer().is_some() => {
                place.refuse(Complaint::new("is not one that this version reads", "allowed: 1"));
            }
            Some(item) => {
                place.refuse(Complaint::new(format!("must be 1, not {}", noun(item)), "allowed: 1"))
            }
        }
    }
}

// Land ---------------------------------------------------------------------------------------------------------------

section! {
    /// The grid and the land before erosion. Samples are vertices: the first and the last of a row are `extent` apart.
    struct Terrain {
        /// Samples along one side.
        cells: u32 = whole(512, 64..=8192),
        /// Length of one side.
        extent: f32 = number(8000.0, M, 1.0..=1e6),
        /// What the land is made of, from the first layer to the last; each is combined with what the ones before
        /// it made. A layer's randomness comes from the world's seed and its place in the list: give it a `seed` of
        /// its own to keep its pattern when layers are inserted before it.
        layers: Vec<Layer> = list(layer(), 1..=64, DEFAULT_LAYERS),
    }
}

/// Level of a sea that no ground can reach down to, metres.
pub const NO_SEA: f64 = -FARTHEST_GROUND as f64;

const DEFAULT_LAYERS: &str = r#"[
    { cone = { height = 1100, radius = 3100, exponent = 0.8 } },
    { simplex = { combine = "power", amplitude = 0.22, wavelength = 1900, octaves = 8, warp = 300 } },
]"#;

#[derive(Clone, Debug)]
pub enum Layer {
    Cone(Cone),
    Simplex(Simplex),
    Crater(Crater),
    DiamondSquare(DiamondSquare),
    Heightmap(Heightmap),
}

fn layer() -> OneOf<Layer> {
    one_of([
        tag("cone", Layer::Cone),
        tag("simplex", Layer::Simplex),
        tag("crater", Layer::Crater),
        tag("diamond_square", Layer::DiamondSquare),
        tag("heightmap", Layer::Heightmap),
    ])
}

section! {
    /// A cone with a curved flank: `height · (1 − (r/radius)^exponent)`, r from its centre (1, 2).
    struct Cone {
        /// Height of the tip above the foot, H (1).
        height: f32 = number(900.0, M, 1.0..=20_000.0),
        /// Radius of the foot, R (1).
        radius: f32 = number(3100.0, M, 1.0..=1e6),
        /// Shape of the flank, P (1): below 1 hollow as a volcano's, 1 straight, above 1 a dome with a flat top.
        exponent: f32 = number(0.8, NONE, 0.1..=64.0).usual(0.6..=4.0),
        /// Where the tip stands (2): metres east and south of the middle.
        center: [f32; 2] = numbers([0.0, 0.0], M, -1e6..=1e6),
        /// How the cone joins what lies below it.
        combine: Combine = combine(),
        /// With `combine = "power"`: the height that the power leaves as it is.
        reference: Option<f32> = reference(),
    }
}

section! {
    /// Fractal simplex noise, `offset + amplitude · Σ η(p·2^i/wavelength)/2^i` (3), with η of Perlin 2002 and
    /// Gustavson 2005.
    struct Simplex {
        /// Height of the first octave's hills; with `combine = "power"` or `"multiply"` a plain number (K_N
        /// (4), usual: 0.05 to 0.25).
        amplitude: Option<f32> = optional(number(0.2, NONE, -20_000.0..=20_000.0), "0.2 with power and multiply, else 20"),
        /// Added to the noise.
        offset: Option<f32> = optional(number(0.0, NONE, -20_000.0..=20_000.0), "1 with multiply, else 0"),
        /// Distance between hills in the first octave.
        wavelength: f32 = number(1600.0, M, 1.0..=1e6),
        /// Number of octaves, N (3): each has half the wavelength and half the height of the one before.
        octaves: u32 = whole(8, 1..=16),
        /// How far the pattern is bent by noise of its own (three octaves): breaks straight lines.
        warp: f32 = number(0.0, M, 0.0..=1e5),
        /// Its own seed.
        seed: Option<u32> = optional(whole(1, 0..=u32::MAX), "from the world's seed and the layer's number"),
        /// How the noise joins what lies below it.
        combine: Combine = combine(),
        /// With `combine = "power"`: the height that the power leaves as it is.
        reference: Option<f32> = reference(),
    }
}

section! {
    /// Mirrors everything above `level` down: a caldera (5). A floor below the sea makes an atoll.
    struct Crater {
        /// Height of the rim, C (5).
        level: f32 = number(700.0, M, -20_000.0..=20_000.0),
    }
}

section! {
    /// Diamond–square (Fournier, Fussell & Carpenter 1982) on a grid of 2^n + 1 points a side, stretched over the
    /// terrain.
    struct DiamondSquare {
        /// Size of its grid: 2^n + 1 points a side.
        n: u32 = whole(9, 1..=13),
        /// The corners lie within this far of 0.
        init_height: f32 = number(0.0, M, 0.0..=20_000.0),
        /// Greatest random step at the first level.
        spread: f32 = number(200.0, M, 0.0..=20_000.0),
        /// What the step is multiplied by from level to level: less is smoother.
        reduction: f32 = number(0.5, NONE, 0.0..=1.0),
        /// Its own seed.
        seed: Option<u32> = optional(whole(1, 0..=u32::MAX), "from the world's seed and the layer's number"),
        /// How it joins what lies below it.
        combine: Combine = combine(),
        /// With `combine = "power"`: the height that the power leaves as it is.
        reference: Option<f32> = reference(),
    }
}

section! {
    /// Heights from a file, stretched over the terrain: a grey PNG (16 bits), a RAW or R16, an EXR, a TIFF. `docs/formats.md`
    /// says what is read.
    struct Heightmap {
        /// The file.
        file: Option<String> = required_file(),
        /// Height of black, or of the least of an EXR's or TIFF's values.
        min: Option<f32> = optional(number(0.0, M, -20_000.0..=20_000.0), "from the sidecar; EXR and TIFF hold metres"),
        /// Height of white, or of the greatest of an EXR's or TIFF's values.
        max: Option<f32> = optional(number(1000.0, M, -20_000.0..=20_000.0), "from the sidecar; EXR and TIFF hold metres"),
        /// Byte order of a RAW file.
        byte_order: Option<ByteOrder> = optional(choice([
            ("little", "the least byte first (\"Windows\", \"PC\")", ByteOrder::Little),
            ("big", "the greatest byte first (\"Mac\")", ByteOrder::Big),
        ]), "from the sidecar, else \"little\""),
        /// The edge that the first row is.
        first_row: Option<FirstRow> = optional(choice([
            ("north", "as in pictures", FirstRow::North),
            ("south", "as Unity has it in RAW files", FirstRow::South),
        ]), "from the sidecar, else \"north\""),
        /// How it joins what lies below it.
        combine: Combine = combine(),
        /// With `combine = "power"`: the height that the power leaves as it is.
        reference: Option<f32> = reference(),
    }
}

fn reference() -> Optional<Number> {
    optional(number(900.0, M, 1.0..=20_000.0), "height of the cone before it")
}

/// How a layer `v` joins the height `h` of those before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Combine {
    Add,
    Multiply,
    Power,
    Max,
    Min,
}

fn combine() -> Choice<Combine> {
    choice([
        ("add", "h + v", Combine::Add),
        ("multiply", "h · v", Combine::Multiply),
        (
            "power",
            "H · (h/H)^(1 + v), H the `reference`: rough where the land is low, and nothing where it is 0 (4)",
            Combine::Power,
        ),
        ("max", "the higher one", Combine::Max),
        ("min", "the lower one", Combine::Min),
    ])
}

section! {
    /// Maps that scale the processes from place to place: grey PNG or RAW (black 0, white 1), EXR or TIFF, stretched over
    /// the terrain.
    struct Controls {
        /// Multiplies the rain.
        rain: Option<String> = file(),
        /// Multiplies what water takes from the ground: soft rock is 1, hard rock 0.
        erodibility: Option<String> = file(),
        /// Multiplies every change of the ground, from 0 to 1: erosion, sea bed and reef where it is white.
        mask: Option<String> = file(),
    }
}

// Erosion ------------------------------------------------------------------------------------------------------------

section! {
    /// Water and gravity at work on the land.
    struct Erosion {
        /// What happens to water and sediment at the rim of the terrain and in the sea.
        boundary: Boundary = choice([
            ("sea", "the sea swallows rivers and keeps its level; nothing flows over the rim", Boundary::Sea),
            ("closed", "nothing flows over the rim and there is no sea (the paper)", Boundary::Closed),
            ("open", "the rim drains", Boundary::Open),
        ]),
        /// Rain that runs off, carves and drops what it carries.
        hydraulic: Option<hydraulic::Params> = or_none(table::<hydraulic::Params>()),
        /// Debris that slides from slopes that are too steep.
        thermal: Option<Thermal> = or_none(table::<Thermal>()),
        /// Length over which the sea bed is smoothed before the reef grows; 0 leaves it (23).
        seabed_smoothing: f32 = number(40.0, M, 0.0..=10_000.0).usual(30.0..=61.0),
    }
}

section! {
    /// Erosion by running water: virtual pipes (6)–(19) (Mei, Decaudin & Hu 2007), with the
    /// changes that let valleys grow. Seconds are model seconds: geological time runs faster.
    for hydraulic::Params, presets HYDRAULIC_PRESETS {
        /// How long it rains.
        duration = number(5000.0, S, 1.0..=1e6).usual(500.0..=8000.0),
        /// Rain, r (6).
        rain = number(100.0, MM_PER_H, 0.0..=10_000.0).usual(50.0..=300.0),
        /// Share of the water that evaporates each second, K_T (19).
        evaporation = number(0.0, PER_S, 0.0..=1.0),
        /// Gravity, g (7).
        gravity = number(9.81, M_PER_S2, 0.1..=100.0),
        /// Neighbours that a cell sends water to (7)–(9).
        pipes = choice([
            ("eight", "isotropic", hydraulic::Pipes::Eight),
            ("four", "cuts trenches along the axes (the paper)", hydraulic::Pipes::Four),
        ]),
        /// Cross-section of a pipe, A (7).
        section = choice([
            ("depth", "as deep as the water, up to `pipe_depth`", hydraulic::Section::Depth),
            ("fixed", "always `pipe_depth` deep (the paper)", hydraulic::Section::Fixed),
        ]),
        /// Depth of a pipe, or the cap on it, D in A = ℓ·D (7): sets the fastest wave and so the time step.
        pipe_depth = number(4.0, M, 0.1..=100.0).usual(1.0..=8.0),
        /// Quadratic drag of the bed, c_f: v = sqrt(g·d·slope/c_f); 0 is frictionless.
        drag = number(0.15, NONE, 0.0..=10.0).usual(0.05..=0.3),
        /// Capacity, K_S (11): metres of ground carried for each m/s of speed.
        capacity = number(200.0, S, 0.0..=10_000.0).usual(50.0..=400.0),
        /// Least sin α in the capacity, so that flats still work (11).
        min_slope = number(0.01, NONE, 0.0..=1.0).usual(0.005..=0.05),
        /// Depth over which the capacity rises from nothing to all of it (Jákó & Tóth 2011): without it rills don't
        /// grow. 0 = no ramp.
        ramp_depth = number(0.5, M, 0.0..=100.0).usual(0.3..=2.0),
        /// Depth at which that rise begins: keeps sheets of rain from eroding.
        ramp_start = number(0.01, M, 0.0..=10.0).usual(0.0..=0.03),
        /// The slope α in the capacity (11).
        slope = choice([
            ("outflow", "drop of the water surface, weighted by the outflow", hydraulic::Slope::Outflow),
            ("central", "central differences of the ground (12) (the paper)", hydraulic::Slope::Central),
        ]),
        /// Rate of erosion, K_E (15, 16).
        erosion_rate = number(0.005, PER_S, 0.0..=10.0).usual(0.001..=0.01),
        /// Rate of deposition, K_D (15, 16).
        deposition_rate = number(0.015, PER_S, 0.0..=10.0).usual(0.005..=0.05),
        /// Fastest change of the ground by water (15).
        rate_limit = number(1.0, M_PER_S, 0.0..=1000.0),
        /// How suspended sediment travels (17).
        transport = choice([
            ("flux", "with the water that carries it; nothing is lost", hydraulic::Transport::Flux),
            ("semi_lagrangian", "traced back along the velocity; loses mass (the paper)", hydraulic::Transport::SemiLagrangian),
        ]),
        /// Diffusivity of suspended sediment, D_s (18).
        sediment_diffusivity = number(12.0, M2_PER_S, 0.0..=1000.0),
        /// Soil creep: diffusivity of the ground. Sets where valleys begin, keeps ridges smooth.
        creep = number(0.1, M2_PER_S, 0.0..=10.0).usual(0.02..=0.3),
        /// Extra diffusivity of the bed for each m²/s of flow, β: widens rivers.
        bank_diffusion = number(3.0, NONE, 0.0..=100.0).usual(0.5..=6.0),
        /// Depth of the sea over which rivers lose their force: fans and beaches. With `boundary = "sea"`.
        sea_fade = number(3.0, M, 0.0..=1000.0),
        /// The time step, as a share of the largest stable one.
        safety = number(0.9, NONE, 0.05..=1.0),
        /// Ground under more water than this counts as wet …
        wet_depth = number(0.05, M, 0.0..=100.0),
        /// … and remembers it for this long: river beds stay bare.
        wet_memory = number(600.0, S, 1.0..=1e6),
    }
}

const HYDRAULIC_PRESETS: &[Preset] = &[
    Preset {
        name: "island",
        about: "the defaults below: valleys with branches, whatever the grid",
        keys: "",
    },
    Preset {
        name: "paper",
        about: "the model as Korošec & Lebar Bajec print it",
        keys: r#"
pipes = "four"
capacity = 2
section = "fixed"
drag = 0
ramp_depth = 0
ramp_start = 0
slope = "central"
rate_limit = 1000
transport = "semi_lagrangian"
creep = 0
bank_diffusion = 0
"#,
    },
];

section! {
    /// Thermal erosion: debris slides to lower neighbours past the angle of repose (20)–(22) (Jákó & Tóth
    /// 2011).
    struct Thermal {
        /// What moves (21).
        law: thermal::Law = choice([
            ("excess", "half of the excess over the repose slope: no terraces", thermal::Law::Excess),
            ("drop", "half of the whole drop (the paper)", thermal::Law::Drop),
        ]),
        /// Angle of repose on land, K_α (20).
        repose: f32 = number(38.0, DEGREES, 1.0..=85.0).usual(30.0..=42.0),
        /// Angle of repose under water (20).
        repose_under_water: f32 = number(30.0, DEGREES, 1.0..=85.0),
        /// Speed of sliding.
        diffusivity: f32 = number(1.7, M2_PER_S, 0.0..=1000.0),
        /// Runs every this many iterations of hydraulic erosion, and makes up for the others.
        every: Option<u32> = optional(whole(4, 1..=10_000), "4, with hydraulic erosion"),
        /// How long debris slides, in a world without hydraulic erosion.
        duration: Option<f32> = optional(number(5000.0, S, 1.0..=1e6), "5000, without hydraulic erosion"),
        /// Collapse of slopes that are too steep, before anything else.
        settle: Option<thermal::Settle> = or_none(table::<thermal::Settle>()),
    }
}

section! {
    /// Slopes of the base terrain that are too steep collapse before erosion begins.
    for thermal::Settle {
        /// Angle of repose.
        repose = number(40.0, DEGREES, 1.0..=85.0),
        /// How far material slides.
        length = number(60.0, M, 0.0..=10_000.0),
    }
}

// Reef ---------------------------------------------------------------------------------------------------------------

section! {
    /// Coral reef: it grows where light and carbon reach, and keeps up with a rising sea (24)–(30) (after Nakamura &
    /// Nakamori 2007, 2011).
    for reef::Params {
        /// Time step, τ (26, 29).
        step = number(25.0, YEARS, 0.1..=1000.0).usual(10.0..=25.0),
        /// History of the sea level, stage by stage: a rising sea parts the reef from the shore.
        stages = list(table::<reef::Stage>(), 1..=64, "[{ duration = 36_000, rise = 108 }, { duration = 2500, rise = 0 }]"),
        /// Growth at the surface in the open ocean, K_B (25). With rubble at least 5 times the rise per year, or the
        /// reef drowns.
        growth = number(0.016, M_PER_YEAR, 0.0..=1.0).usual(0.008..=0.02),
        /// Decay of light with depth, K_A (25).
        light_decay = number(0.06, PER_M, 0.0..=10.0).usual(0.03..=0.12),
        /// Deepest growth, G (25).
        max_depth = number(40.0, M, 1.0..=500.0).usual(30.0..=50.0),
        /// Carbon used for each metre grown and metre of water, K_U (26).
        uptake = number(0.15, NONE, 0.0..=10.0).usual(0.02..=0.3),
        /// Diffusivity of carbon, D_O (27, 28).
        diffusivity = number(8.0, M2_PER_YEAR, 0.0..=1000.0).usual(2.0..=40.0),
        /// Carbon of the open ocean and of all water at first, O0 (25).
        ocean_carbon = number(1.0, NONE, 0.0..=10.0),
        /// Water deeper than this is open ocean: feeds the outer rim, while the lagoon starves.
        ocean_depth = number(60.0, M, 1.0..=10_000.0),
        /// Growth (29) stops this far below the surface.
        keep = number(0.6, M, 0.0..=100.0),
        /// Coral rubble that slides under water.
        rubble = or_none(table::<reef::Rubble>()),
    }
}

section! {
    /// A stage of the sea's history.
    for reef::Stage {
        /// How long it takes.
        duration = number(1000.0, YEARS, 0.0..=1e6),
        /// How far the sea rises meanwhile, K_W·τ in sum (30); negative where it falls.
        rise = number(0.0, M, -1000.0..=1000.0),
    }
}

section! {
    /// Coral rubble that slides under water, the crest included: keeps reef walls from standing upright.
    for reef::Rubble {
        /// Angle of repose.
        repose = number(40.0, DEGREES, 1.0..=85.0).usual(30.0..=45.0),
        /// Slides every this many steps of the reef …
        every = whole(10, 1..=10_000),
        /// … in this many passes.
        passes = whole(2, 1..=1000),
    }
}

// Sea and ground -----------------------------------------------------------------------------------------------------

section! {
    /// The sea: its level, and what its water does to light.
    for scene::Sea {
        /// Height of the surface above the datum at the start; a reef's stages move it. No ground lies below the least level:
        /// there is no sea then.
        level = number(210.0, M, NO_SEA..=20_000.0),
        /// Attenuation along the line of sight, for red, green and blue, K_A (32).
        attenuation = numbers([0.28, 0.032, 0.014], PER_M, 0.0..=100.0),
        /// Colour of water without a bottom.
        deep_colour = colour("#0a243f"),
        /// How rough the surface is: standard deviation of its slope.
        roughness = number(0.12, NONE, 0.0..=1.0),
    }
}

section! {
    /// How bare ground is coloured: materials, and where each lies.
    for scene::Surface {
        /// Grass.
        grass = colour("#576c30"),
        /// Grass on high or steep ground: paler and yellower.
        dry_grass = colour("#8b8653"),
        /// Rock.
        rock = colour("#675f58"),
        /// Sand.
        sand = colour("#c5b8a0"),
        /// Sea floor.
        sea_floor = colour("#c5bfad"),
        /// Living coral just below the surface.
        reef = colour("#6f634b"),
        /// Slope at which grass begins to give way to rock, and at which only rock is left.
        rock_slope = numbers([38.0, 50.0], DEGREES, 0.0..=90.0),
        /// Height above the sea at which grass begins to dry, and at which it is dry.
        dry_height = numbers([450.0, 1000.0], M, -20_000.0..=20_000.0),
        /// How high above the sea beaches reach.
        beach_height = number(3.0, M, 0.0..=1000.0),
        /// Steepest beach.
        beach_slope = number(14.0, DEGREES, 0.0..=90.0),
        /// Size of the largest patches of colour.
        patch_size = number(400.0, M, 0.01..=100_000.0),
        /// How far grass is painted as a forest seen from afar: 1 is an island without plants, 0 where they stand themselves.
        crowns = number(1.0, NONE, 0.0..=1.0),
        /// Snow on high ground.
        snow = or_none(table::<scene::Snow>()),
        /// Two materials by height alone, in place of all that is above, but for snow.
        by_height = word_or("none", "All that is above decides.", table::<scene::ByHeight>()),
    }
}

section! {
    /// Snow on high ground that is not too steep for it.
    for scene::Snow {
        /// Its colour.
        colour = colour("#e8ecf2"),
        /// Height above the sea at which the first patches lie, and above which all is covered.
        height = numbers([1200.0, 1800.0], M, -20_000.0..=20_000.0),
        /// Slope at which it begins to slide off, and at which none stays.
        slope = numbers([35.0, 55.0], DEGREES, 0.0..=90.0),
    }
}

section! {
    /// Ground below and rock above, mixed in between in proportion to the height (Rudzki 2020, section 2.3).
    for scene::ByHeight {
        /// The ground.
        ground = table::<scene::Mixture>(),
        /// The rock.
        rock = table::<scene::Mixture>(),
        /// Height above the datum at which rock begins.
        rock_start = number(10.0, M, -1e5..=1e5),
        /// Height above the datum at which only rock is left.
        ground_end = number(20.0, M, -1e5..=1e5),
    }
}

section! {
    /// A colour that noise mixes of two: `mix(reflectance, second_reflectance, clamp(noise(p · position_factor) ·
    /// value_factor, 0, 1))`, with Perlin's noise of 2002 from 0 to 1 at the place p (Rudzki 2020, equation 2.1).
    for scene::Mixture {
        /// Light that it scatters back.
        reflectance = colour("#576c30"),
        /// The other colour.
        second_reflectance = colour("#675f58"),
        /// How fine the mixture is.
        position_factor = number(1.0, PER_M, 0.0..=10_000.0),
        /// How strong it is.
        value_factor = number(1.0, NONE, 0.0..=100.0),
    }
}

// Light --------------------------------------------------------------------------------------------------------------

#[derive(Clone, Debug)]
pub enum Sky {
    Preetham(Preetham),
    HosekWilkie(HosekWilkie),
    Constant(Constant),
    Map(SkyMap),
    None,
}

section! {
    /// The daylight of Preetham, Shirley & Smits 1999, with the coefficients of the authors' program (the printed
    /// ones are rounded).
    struct Preetham {
        /// Haze: 2 is a clear day, 10 a hazy one. Below 1.7 the model turns negative.
        turbidity: f32 = number(2.2, NONE, 1.7..=10.0).usual(2.0..=8.0),
        /// How much of the horizon fair-weather clouds cover: 0 is none, 1 nearly all.
        clouds: f32 = number(0.5, NONE, 0.0..=1.0),
    }
}

section! {
    /// The daylight of Hosek & Wilkie 2012: light from the ground brightens it, and low suns look better.
    struct HosekWilkie {
        /// Haze: 2 is a clear day, 10 a hazy one.
        turbidity: f32 = number(2.2, NONE, 1.0..=10.0),
        /// Share of light that the ground far and wide scatters back.
        albedo: f32 = number(0.2, NONE, 0.0..=1.0),
        /// How much of the horizon fair-weather clouds cover: 0 is none, 1 nearly all.
        clouds: f32 = number(0.5, NONE, 0.0..=1.0),
    }
}

section! {
    /// A picture of the whole sky by latitude and longitude, below the horizon, too: its first row is straight up, and its columns
    /// go clockwise. A sun that it shows lights the land; `sun` is a second one.
    struct SkyMap {
        /// The file: OpenEXR or Radiance HDR (.hdr), twice as wide as high. More than 4096 × 2048 pixels are made fewer.
        file: Option<String> = required_file(),
        /// What its values are multiplied by.
        scale: f32 = number(1.0, CD_PER_M2, 0.0..=1e12),
        /// Where its left edge lies, clockwise from north.
        rotation: f32 = number(0.0, DEGREES, -360.0..=360.0),
    }
}

section! {
    /// The same light from everywhere.
    struct Constant {
        /// Red, green and blue.
        radiance: [f32; 3] = numbers([4000.0, 5000.0, 7000.0], CD_PER_M2, 0.0..=1e9),
    }
}

#[derive(Clone, Debug)]
pub enum Sun {
    Place(SunPlace),
    Direct(SunDirect),
    None,
}

section! {
    /// The sun as it stands over a place on Earth (Preetham, Shirley & Smits 1999, appendix A.6); its strength follows from
    /// its height and the sky's turbidity.
    struct SunPlace {
        /// Latitude, north-positive.
        latitude: f32 = number(-16.5, DEGREES, -90.0..=90.0),
        /// Longitude, east-positive.
        longitude: f32 = number(-151.7, DEGREES, -180.0..=360.0),
        /// Hours that clocks are ahead of UTC; no summer time.
        utc_offset: f32 = number(-10.0, HOURS, -12.0..=14.0),
        /// Day of the year.
        day: f32 = number(80.0, NONE, 0.0..=366.0),
        /// Time of day on the clock.
        time: f32 = number(9.5, HOURS, 0.0..=24.0),
    }
}

section! {
    /// A sun at a given place in the sky.
    struct SunDirect {
        /// Where it stands, clockwise from north.
        azimuth: f32 = number(60.0, DEGREES, -360.0..=360.0),
        /// How high it stands above the horizon.
        elevation: f32 = number(45.0, DEGREES, 0.0..=90.0),
        /// Illuminance on a plane that faces it: red, green and blue.
        irradiance: [f32; 3] = numbers([100_000.0, 95_000.0, 88_000.0], LUX, 0.0..=1e9),
        /// Angle under which its disc is seen.
        diameter: f32 = number(0.53, DEGREES, 0.0..=90.0),
    }
}

// Picture ------------------------------------------------------------------------------------------------------------

section! {
    /// Where the picture is seen from.
    struct Camera {
        /// Where the camera stands and looks.
        view: View = one_of([
            tag("frame_island", View::FrameIsland),
            tag("look_at", View::LookAt),
            tag("stand", View::Stand),
        ]),
        /// Vertical field of view.
        fov: f32 = number(38.0, DEGREES, 1.0..=170.0),
        /// Diameter of the lens: what is not at `focus` is blurred, when the picture is traced. 0 is a pinhole.
        aperture: f32 = number(0.0, M, 0.0..=10.0),
        /// Distance of what is sharp.
        focus: f32 = number(10.0, M, 1e-3..=1e6),
        /// Where the camera is in some frames of a film, in their order: `terrane render --frames` makes pictures of these and of all
        /// between them, where it moves smoothly and never beyond its keyframes. A picture by itself is seen from `view`.
        keyframes: Vec<Keyframe> = list(table::<Keyframe>(), 0..=10_000, "[]"),
    }
}

section! {
    /// The camera in a numbered frame. What a keyframe does not say is as in the one before it.
    struct Keyframe {
        /// Number of the frame.
        frame: u32 = whole(0, 0..=MOST_FRAMES),
        /// Where the camera stands: metres east, up and south of the middle of the terrain at the datum; above the sea.
        position: Option<[f32; 3]> = optional(numbers([0.0; 3], M, -1e7..=1e7), "as in the keyframe before"),
        /// What it looks at.
        target: Option<[f32; 3]> = optional(numbers([0.0; 3], M, -1e7..=1e7), "as in the keyframe before"),
        /// How far it is turned clockwise. From 0 to 720 it turns twice.
        roll: Option<f32> = optional(number(0.0, DEGREES, -36_000.0..=36_000.0), "as before, 0 in the first"),
        /// Vertical field of view.
        fov: Option<f32> = optional(number(38.0, DEGREES, 1.0..=170.0), "as before, `camera.fov` in the first"),
        /// Distance of what is sharp.
        focus: Option<f32> = optional(number(10.0, M, 1e-3..=1e6), "as before, `camera.focus` in the first"),
    }
}

/// Largest number of a frame.
pub const MOST_FRAMES: u32 = 10_000_000;

#[derive(Clone, Debug)]
pub enum View {
    FrameIsland(FrameIsland),
    LookAt(LookAt),
    Stand(Stand),
}

section! {
    /// Stands so that the land above the sea fills the picture.
    struct FrameIsland {
        /// Side of the island on which the camera stands, clockwise from north.
        azimuth: f32 = number(150.0, DEGREES, -360.0..=360.0),
        /// Angle at which it looks down.
        elevation: f32 = number(12.0, DEGREES, 0.0..=90.0),
        /// How far away it stands: 1 just shows all of the land.
        distance: f32 = number(1.0, NONE, 0.01..=100.0),
    }
}

section! {
    /// Stands at a point and looks at another.
    struct LookAt {
        /// Where the camera stands: metres east, up and south of the middle of the terrain at the datum; above the sea.
        position: [f32; 3] = numbers([3000.0, 1500.0, 5000.0], M, -1e7..=1e7),
        /// What it looks at.
        target: [f32; 3] = numbers([0.0, 300.0, 0.0], M, -1e7..=1e7),
        /// How far it is turned clockwise: the horizon leans to the left.
        roll: f32 = number(0.0, DEGREES, -360.0..=360.0),
    }
}

section! {
    /// Stands on the ground and looks ahead: uphill where the ground rises, downhill where it falls (Rudzki 2020, section
    /// 3.4).
    struct Stand {
        /// Where the camera stands: metres east and south of the middle of the terrain.
        at: Option<[f32; 2]> = optional(numbers([0.0, 0.0], M, -1e6..=1e6), "chosen by height"),
        /// Without `at`: stands where the ground is nearest to this height.
        expected_height: Option<f32> = optional(number(0.0, M, -1e6..=1e6), "0, without `at`"),
        /// Without `at`: least distance from the edge of the terrain.
        edge_offset: Option<f32> = optional(number(EDGE_OFFSET, M, 0.0..=1e6), "10, without `at`"),
        /// Height of the eye above the ground.
        height: f32 = number(1.7, M, 0.0..=10_000.0),
        /// Where the camera looks, clockwise from north.
        azimuth: f32 = number(0.0, DEGREES, -360.0..=360.0),
        /// Looks so far ahead, as high above the ground there as it stands here.
        distance: f32 = number(20.0, M, 0.01..=1e6),
    }
}

/// Least distance of a camera on the ground from the edge, metres.
pub const EDGE_OFFSET: f64 = 10.0;

// Zoom ---------------------------------------------------------------------------------------------------------------

section! {
    /// A surface with detail at every scale, and a flight down to a spot on it, for ever. Lengths are in cells of its coarsest
    /// lattice; each level has cells half as large.
    struct Zoom {
        /// How near the spot the picture is, or the first frame: 2 to the power of −depth cells. Without `from`.
        depth: f64 = exact(number(0.0, NONE, 0.0..=1e6)),
        /// Where the picture is seen from, in place of `depth`: the location code of a place on this surface, as the viewer and
        /// `terrane render --json` tell it. The field of view is `camera.fov`. Frames are those of the way out, straight up from there.
        from: Option<Location> = location_code(),
        /// Levels from one frame to the next.
        levels_per_frame: f64 = exact(number(0.03125, NONE, 0.0..=1e3)),
        /// What is between the vertices of a coarser level.
        refinement: Refinement = choice([
            ("triangles", "the triangles that are drawn: finer levels begin as what they replace", Refinement::Triangles),
            ("bilinear", "bilinear patches, rounded down (Tunković 2018)", Refinement::Bilinear),
        ]),
        /// How high a level's noise is.
        roughness: Roughness = choice([
            ("quarter", "a quarter of its cells: hills", Roughness::Quarter),
            ("half", "half of its cells: crags", Roughness::Half),
            ("whole", "its cells: needles", Roughness::Whole),
        ]),
        /// Log₂ of the quads along a side of a tile.
        tile: u32 = whole(5, 2..=7),
        /// Tiles nearer than this many of their sides are split.
        detail: f32 = number(2.0, NONE, 1.72..=5.0).usual(1.72..=3.0),
        /// Octaves of distance, from the nearest ground on, to where nothing is seen but sky.
        visibility: u32 = whole(64, 4..=1024),
        /// The share of these octaves that is clear, before there is haze.
        clear: f32 = number(0.5, NONE, 0.0..=1.0),
        /// With `--stereo`: from eye to eye, in distances to the surface.
        eyes: f32 = number(0.0625, NONE, 0.0..=1.0).usual(0.0..=0.2),
        /// Tiles that the device keeps.
        tiles: u32 = whole(12_000, 1000..=65_536),
    }
}

section! {
    /// The picture itself.
    struct Render {
        /// Width and height in pixels.
        size: [u32; 2] = wholes([1280, 720], 1..=16_384),
        /// What radiance is multiplied by before the tone map: white is then 1 with `tone_map = "none"`, and 6 with
        /// `"filmic"`, which leaves middle grey (0.18) as it is.
        exposure: f32 = number(6e-5, M2_PER_CD, 1e-12..=1e12),
        /// From radiance to the screen's colours, in PNG.
        tone_map: scene::ToneMap = choice([
            ("filmic", "colours pale as they brighten, and keep their hue (after Lottes 2016)", scene::ToneMap::Filmic),
            ("none", "cut off at white", scene::ToneMap::None),
        ]),
        /// Aerial perspective: air that veils what is far (Preetham, Shirley & Smits 1999, section 3.2).
        aerial: bool = switch(true),
        /// How the picture is made, unless the command line says so.
        renderer: Renderer = choice([
            ("raster", "by rasterisation: quick, light from other surfaces is estimated", Renderer::Raster),
            ("trace", "by path tracing: light as it goes, and the longer the cleaner", Renderer::Trace),
        ]),
        /// Samples a pixel, when it is traced.
        spp: u32 = whole(64, 1..=MOST_SAMPLES),
        /// Most scatterings that light takes on its way to the eye, when it is traced. With 0 only lights are seen.
        bounces: u32 = whole(8, 0..=1000),
        /// Materials have the mean of their colours and nothing else, neither noise nor relief nor gloss, and there is neither water
        /// nor clouds, when the picture is traced: for comparisons with other renderers.
        constant_materials: bool = switch(false),
    }
}

/// How pictures are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Renderer {
    Raster,
    Trace,
}
