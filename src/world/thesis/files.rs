//! Every parameter of every file of the folder (Rudzki 2020, §4.3).

use super::parameters::{Choice, FileName, choice, number, numbers, settings, whole, wholes};
use super::productions::{Production, Productions, Symbol};

settings! {
    /// `pathTracer.conf`: the picture.
    PathTracer {
        /// Name of the picture, an EXR file in the folder `photos`.
        photo_name: String = PhotoName(FileName),
        /// Width and height of the picture, pixels.
        resolution: [f64; 2] = Resolution(wholes::<2>(1..=16_384)),
        /// Rays through each pixel.
        samples: f64 = Samples(whole(1..=1_000_000).or(1.0)),
        /// Most times that light is scattered on its way.
        max_ray_bounces: f64 = MaxRayBounces(whole(0..=1000).or(5.0)),
        /// Accepted, and of no effect.
        debug_mode: bool = DebugMode(SWITCH),
    }
}

settings! {
    /// `camera.conf`: where the picture is seen from.
    Camera {
        /// Height of the eye above the ground, metres.
        look_height: f64 = LookHeight(number(0.0..=10_000.0).or(1.0)),
        /// Where the camera looks: east, up, south. How far up or down follows from the ground.
        look_direction: [f64; 3] = LookDirection(numbers::<3>(-1e6..=1e6).or([0.0, 0.0, 1.0])),
        /// How far ahead lies the ground whose height decides how far up or down the camera looks, metres.
        look_distance: f64 = LookDistance(number(0.01..=1e6).or(2.0)),
        /// Least distance from the edge of the terrain, metres.
        edge_min_offset: f64 = EdgeMinOffset(number(0.0..=1e6).or(10.0)),
        /// Height of the ground that is looked for, metres.
        expected_position_y: f64 = ExpectedPositionY(number(-1e6..=1e6).or(0.0)),
    }
}

settings! {
    /// `viewMode.conf`: the window.
    ViewMode {
        /// Whether there is one.
        enabled: bool = Enabled(SWITCH),
        /// Width and height, pixels.
        resolution: [f64; 2] = Resolution(wholes::<2>(1..=16_384).or([800.0, 600.0])),
        /// How fast the camera moves, metres a second.
        camera_velocity: f64 = CameraVelocity(number(0.0..=1e6).or(10.0)),
    }
}

settings! {
    /// `sky.conf`: sun and sky.
    Sky {
        /// Colour of the sun, linear.
        sun_color: [f64; 3] = SunColor(numbers::<3>(0.0..=1000.0)),
        /// Strength of the sun.
        sun_power: f64 = SunPower(number(1.0..=1e9)),
        /// What the sky's light is multiplied by.
        sky_luminance_factor: f64 = SkyLuminanceFactor(number(1e-7..=1000.0)),
        /// Latitude, north-positive, degrees.
        latitude: f64 = Latitude(number(-90.0..=90.0)),
        /// Longitude, east-positive, degrees.
        longitude: f64 = Longitude(number(-180.0..=360.0)),
        /// Time zone, hours east of Greenwich.
        standard_meridian: f64 = StandardMeridian(whole(-12..=23)),
        /// Day of the year.
        julian_day: f64 = JulianDay(whole(0..=366)),
        /// Hours of the clock, as a decimal.
        time_of_day: f64 = TimeOfDay(number(0.0..=24.0)),
        /// Haze.
        turbidity: f64 = Turbidity(number(1.7..=10.0)),
    }
}

settings! {
    /// `terrain.conf`: the land.
    Terrain {
        /// Size of the grid: 2^N + 1 points a side.
        n: f64 = N(whole(1..=12)),
        /// Length of one side, metres.
        size: f64 = Size(number(1.0..=1e6)),
        /// The corners lie within this far of 0, metres.
        init_height: f64 = InitHeight(number(0.0..=20_000.0)),
        /// Greatest random step at the first level, metres.
        spread: f64 = Spread(number(0.0..=20_000.0)),
        /// What the step is multiplied by from level to level.
        spread_reduction_rate: f64 = SpreadReductionRate(number(0.0..=1.0)),
        /// Height at which rock begins, metres.
        rock_start: f64 = RockStartY(number(-1e5..=1e5).or(10.0)),
        /// Height at which only rock is left, metres.
        ground_end: f64 = GroundEndY(number(-1e5..=1e5).or(20.0)),
    }
}

settings! {
    /// `materials/NAME.mat`: a colour that noise mixes of two.
    Material {
        /// The first colour, linear.
        color1: [f64; 3] = Color1(numbers::<3>(0.0..=1.0)),
        /// The second colour, linear.
        color2: [f64; 3] = Color2(numbers::<3>(0.0..=1.0)),
        /// How fine the mixture is, 1/m.
        noise_position_factor: f64 = NoisePositionFactor(number(0.0..=1e4).or(1.0)),
        /// How much of the second colour.
        noise_value_factor: f64 = NoiseValueFactor(number(0.0..=100.0).or(1.0)),
    }
}

/// What something is made of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Substance {
    Leaf,
    Bark,
    #[default]
    Plant,
}

impl Substance {
    /// As species call it.
    pub fn name(self) -> &'static str {
        match self {
            Substance::Leaf => "leaf",
            Substance::Bark => "bark",
            Substance::Plant => "plant",
        }
    }
}

const SUBSTANCES: Choice<Substance> =
    choice(&[("Leaf", Substance::Leaf), ("Bark", Substance::Bark), ("Plant", Substance::Plant)]);

const SWITCH: Choice<bool> = choice(&[("0", false), ("1", true), ("false", false), ("true", true)]).or("0");

settings! {
    /// `trees/*.lsys`, `plants/*.lsys`, `leafs/*.lsys`: an L-system.
    LSystem {
        /// How often the productions are applied.
        n: f64 = N(whole(0..=1000)),
        /// Height that the model is scaled to, metres.
        height: f64 = Height(number(1e-3..=1000.0)),
        /// Sides of a cylinder.
        cone_base_points: f64 = ConeBasePoints(whole(3..=1000).or(3.0)),
        /// What it is made of.
        material: Substance = Material(SUBSTANCES.or("Plant")),
        /// Radius of the cylinders, in steps of the turtle.
        init_radius: f64 = InitRadius(number(1e-6..=500.0).or(0.3)),
        /// Angle of `+` and `-`, degrees.
        turn_angle: f64 = TurnAngle(number(-360.0..=360.0).or(0.0)),
        /// Angle of `^` and `&`, degrees.
        pitch_angle: f64 = PitchAngle(number(-360.0..=360.0).or(0.0)),
        /// Angle of `\` and `/`, degrees.
        roll_angle: f64 = RollAngle(number(-360.0..=360.0).or(0.0)),
        /// The symbol that growth begins with.
        axiom: char = Axiom(Symbol),
        /// `Prod A > WORD`: what becomes of a symbol in one step.
        productions: Vec<Production> = Prod(Productions),
    }
}

settings! {
    /// `trees/*.honda`: a tree of Honda (1971).
    Honda {
        /// Steps of growth.
        n: f64 = N(whole(0..=1000)),
        /// Contraction ratio of the trunk.
        r1: f64 = R1(number(1e-3..=10.0)),
        /// Contraction ratio of branches.
        r2: f64 = R2(number(1e-3..=10.0)),
        /// Branching angle from the trunk, degrees.
        a0: f64 = A0(number(-360.0..=360.0)),
        /// Branching angle of lateral axes, degrees.
        a2: f64 = A2(number(-360.0..=360.0)),
        /// Divergence angle, degrees.
        d: f64 = D(number(-360.0..=360.0)),
        /// Width decrease rate.
        wr: f64 = Wr(number(1e-3..=10.0)),
        /// Height that the tree is scaled to, metres.
        height: f64 = Height(number(1e-3..=1000.0).or(2.0)),
        /// Sides of a cylinder.
        cone_base_points: f64 = ConeBasePoints(whole(3..=1000).or(6.0)),
        /// What it is made of.
        material: Substance = Material(SUBSTANCES.or("Bark")),
        /// Radius of the trunk; its first segment is 1 long.
        init_radius: f64 = InitRadius(number(1e-6..=500.0).or(0.2)),
    }
}

settings! {
    /// `leafs/*.family`: a leaf.
    Family {
        /// Steps of growth.
        n: f64 = N(whole(0..=1000)),
        /// Angle of the lateral segments, degrees.
        delta: f64 = Delta(number(-360.0..=360.0)),
        /// Initial length of the main segments.
        la: f64 = LA(number(0.0..=1e4)),
        /// Growth rate of the main segments.
        ra: f64 = RA(number(0.0..=10.0)),
        /// Initial length of the lateral segments.
        lb: f64 = LB(number(0.0..=1e4)),
        /// Growth rate of the lateral segments.
        rb: f64 = RB(number(0.0..=10.0)),
        /// Growth potential decrement of the lateral segments.
        pd: f64 = PD(number(0.0..=1e4)),
        /// Height that the leaf is scaled to, in the units of the tree that bears it.
        height: f64 = Height(number(1e-3..=1000.0).or(0.4)),
        /// What it is made of.
        material: Substance = Material(SUBSTANCES.or("Leaf")),
    }
}

/// What a spawner places.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Generator {
    #[default]
    Tree,
    Plant,
}

settings! {
    /// `spawners/*.spawner`: a grid of plants.
    Spawner {
        /// Where its middle lies, seen from the camera: metres east and south.
        camera_offset: [f64; 2] = CameraOffset(numbers::<2>(-1e6..=1e6)),
        /// Cells from west to east.
        x_grid_n: f64 = XGridN(whole(1..=10_000).or(1.0)),
        /// Cells from north to south.
        z_grid_n: f64 = ZGridN(whole(1..=10_000).or(1.0)),
        /// Side of a cell, metres.
        cell_size: f64 = CellSize(number(0.0..=1e4).or(0.0)),
        /// What stands in the cells: any of the trees, or of the plants.
        generator_type: Generator =
            GeneratorType(choice(&[("Tree", Generator::Tree), ("Plant", Generator::Plant)])),
        /// Share of the cells where something stands.
        spawn_probability: f64 = SpawnProbability(number(0.0..=1.0).or(1.0)),
        /// Share of a cell in which the place is chosen at random.
        random_position_percentage: f64 = RandomPositionPercentage(number(0.0..=1.0).or(0.5)),
        /// Least of the factors that sizes are multiplied by.
        min_element_scale: f64 = MinElementScale(number(1e-3..=1000.0).or(0.5)),
        /// Greatest of them.
        max_element_scale: f64 = MaxElementScale(number(1e-3..=1000.0).or(2.0)),
    }
}
