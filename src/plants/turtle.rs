//! The turtle, which reads a word and leaves axes, polygons and places of sub-models in space
//! (Prusinkiewicz & Lindenmayer 1990, §1.5).
//!
//! Where the book's text and the matrices printed beside it disagree about the sense of rotations, the text holds.

use super::derive::{Module, Word};
use super::grammar::sin_cos;
use super::watch::{Pace, Stopped, Watch};
use glam::{DMat3, DVec3};

/// What the symbols of a word mean.
#[derive(Clone, Debug, PartialEq)]
pub struct Interpretation {
    /// Of turns without a parameter, radians.
    pub angle: f64,
    /// Of pitch (`&`, `^`) and roll (`\\`, `/`), radians, where they differ from it.
    pub pitch: Option<f64>,
    pub roll: Option<f64>,
    /// Symbols that move and draw, move, and move without recording a vertex of a polygon. One that is drawn and silent
    /// does both.
    pub draw: String,
    pub moves: String,
    pub silent: String,
    /// Which way `+` turns.
    pub plus: Side,
    /// Width (diameter) at the start, metres.
    pub width: f64,
    /// What `!` without a parameter multiplies the width by.
    pub taper: f64,
    pub tropism: Option<Tropism>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Side {
    #[default]
    Left,
    Right,
}

/// Segments turn towards `direction` (not normalised) by `strength · |H × direction|` radians each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tropism {
    pub direction: DVec3,
    pub strength: f64,
}

impl Default for Interpretation {
    fn default() -> Self {
        Interpretation {
            angle: 0.0,
            pitch: None,
            roll: None,
            draw: "F".into(),
            moves: "f".into(),
            silent: "G".into(),
            plus: Side::Left,
            width: 0.1,
            // The cross-section is halved, as where a branch forks in two.
            taper: std::f64::consts::FRAC_1_SQRT_2,
            tropism: None,
        }
    }
}

/// What a turtle drew.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    pub axes: Vec<Axis>,
    pub polygons: Vec<Polygon>,
    pub placements: Vec<Placement>,
    pub measure: Measure,
}

/// A strand of segments without a gap: from where a branch leaves its parent's axis to its tip. Edges of polygons belong
/// to none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Axis {
    /// At least two.
    pub nodes: Vec<Node>,
    /// How many brackets deep the first segment lies.
    pub depth: u32,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Node {
    /// Metres.
    pub position: DVec3,
    /// The width (diameter) in force when the next segment begins, or at the end of the axis, metres.
    pub width: f64,
    /// How often `'` was met: index of the colour.
    pub color: u32,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Polygon {
    /// At least three.
    pub vertices: Vec<DVec3>,
    /// The turtle's up vector where the polygon was opened: the side that is above.
    pub up: DVec3,
    pub color: u32,
}

/// Where a sub-model stands (`~X(s)`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    pub symbol: char,
    pub position: DVec3,
    /// Columns: heading, left, up.
    pub frame: DMat3,
    pub scale: f64,
    pub color: u32,
}

/// Figures of a drawing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measure {
    /// Least and greatest coordinates of the start and every place that the turtle moved to.
    pub bounds: [DVec3; 2],
    pub segments: u64,
    /// Of all segments, metres.
    pub length: f64,
    pub brackets: u64,
    /// Greatest depth of brackets.
    pub depth: u32,
    pub polygons: u64,
    pub polygon_vertices: u64,
    /// Σ |vector area|, m².
    pub polygon_area: f64,
    pub end: DVec3,
}

/// Why a word is no drawing.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("module {place} of the word, `{symbol}`: {problem}")]
pub struct Error {
    pub problem: Problem,
    /// Which module of the word, counted from 1.
    pub place: u64,
    pub symbol: char,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Problem {
    #[error("there is no `[` that it closes")]
    NoBracket,
    #[error("it is never closed by `]`")]
    OpenBracket,
    #[error("there is no `{{` that it closes")]
    NoBrace,
    #[error("it is never closed by `}}`")]
    OpenBrace,
    #[error("no module comes behind it that names a sub-model")]
    NoModel,
    #[error("the turtle leaves the range of numbers")]
    NotFinite,
    #[error("more than {MOST_DEPTH} brackets, one in the other")]
    TooDeep,
    #[error("more than {MOST_POINTS} points are drawn")]
    TooMany,
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// Brackets or braces, one in the other.
pub const MOST_DEPTH: usize = 100_000;
/// Nodes, vertices and placements of a drawing; an axis and a polygon take a few each.
pub const MOST_POINTS: usize = 2_000_000;
/// Operations that a module takes about.
const MODULE: u64 = 4;

/// Follows the turtle through a word. It starts at the origin with heading +Y, left −X and up +Z.
///
/// # Errors
/// Brackets or braces that don't match, places that are no numbers, more points than a plant can have; when it is stopped.
pub fn draw(word: &Word, how: &Interpretation, watch: Watch) -> Result<Drawing, Error> {
    let mut turtle = Turtle::new(how, Some(Drawing::default()));
    turtle.follow(word, watch.pace())?;
    let measure = turtle.measure;
    Ok(Drawing { measure, ..turtle.drawing.unwrap_or_default() })
}

/// The figures of what [`draw`] would draw, without keeping it.
///
/// # Errors
/// As [`draw`], but for the number of points.
pub fn measure(word: &Word, how: &Interpretation) -> Result<Measure, Error> {
    let mut turtle = Turtle::new(how, None);
    turtle.follow(word, Watch::NONE.pace())?;
    Ok(turtle.measure)
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Command {
    Nothing,
    Move {
        draws: bool,
        records: bool,
    },
    Turn(Axle, Sense),
    /// Half a turn about up.
    About,
    Level,
    Open,
    Close,
    BeginPolygon,
    Vertex,
    EndPolygon,
    Width,
    Color,
    Place,
}

/// What a rotation leaves where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Axle {
    Up,
    Left,
    Heading,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Sense {
    /// Left, down, and roll to the left.
    Positive,
    Negative,
}

/// What `[` keeps and `]` restores.
#[derive(Clone, Copy, Debug)]
struct State {
    position: DVec3,
    heading: DVec3,
    left: DVec3,
    up: DVec3,
    width: f64,
    color: u32,
    /// Index of the axis that a segment would continue.
    axis: Option<usize>,
}

struct Turtle<'a> {
    how: &'a Interpretation,
    /// Of the symbols in ASCII; others are looked up.
    commands: [Command; 128],
    /// Sine and cosine of turn, pitch and roll without a parameter.
    angles: [[f64; 2]; 3],
    state: State,
    /// With the places of their brackets in the word.
    states: Vec<(State, u64)>,
    /// With the places of their braces. `]` leaves these as they are.
    polygons: Vec<(Polygon, u64)>,
    measure: Measure,
    drawing: Option<Drawing>,
    points: usize,
}

impl<'a> Turtle<'a> {
    fn new(how: &'a Interpretation, drawing: Option<Drawing>) -> Self {
        let angles = [how.angle, how.pitch.unwrap_or(how.angle), how.roll.unwrap_or(how.angle)];
        Turtle {
            how,
            commands: std::array::from_fn(|code| command(how, code as u8 as char)),
            angles: angles.map(|angle| sin_cos(angle.to_degrees())),
            state: State {
                position: DVec3::ZERO,
                heading: DVec3::Y,
                left: DVec3::NEG_X,
                up: DVec3::Z,
                width: how.width,
                color: 0,
                axis: None,
            },
            states: Vec::new(),
            polygons: Vec::new(),
            measure: Measure::default(),
            drawing,
            points: 0,
        }
    }

    fn follow(&mut self, word: &Word, mut pace: Pace) -> Result<(), Error> {
        let mut modules = word.modules().zip(1..);
        while let Some((module, place)) = modules.next() {
            let fail = |problem| Error { problem, place, symbol: module.symbol };
            pace.count(MODULE).map_err(|stopped| fail(stopped.into()))?;
            let command = match self.commands.get(module.symbol as usize) {
                Some(command) => *command,
                None => command(self.how, module.symbol),
            };
            if command == Command::Place {
                let (name, _) = modules.next().ok_or_else(|| fail(Problem::NoModel))?;
                self.place(name).map_err(fail)?;
            } else {
                self.obey(command, module.parameters.first().copied(), place).map_err(fail)?;
            }
        }
        self.leave_axis();
        if let Some(&(_, place)) = self.states.last() {
            return Err(Error { problem: Problem::OpenBracket, place, symbol: '[' });
        }
        if let Some(&(_, place)) = self.polygons.last() {
            return Err(Error { problem: Problem::OpenBrace, place, symbol: '{' });
        }
        self.measure.end = self.state.position;
        Ok(())
    }

    fn obey(&mut self, command: Command, parameter: Option<f64>, place: u64) -> Result<(), Problem> {
        match command {
            Command::Nothing | Command::Place => {}
            Command::Move { draws, records } => {
                return self.advance(parameter.unwrap_or(1.0), draws, records);
            }
            Command::Turn(axle, sense) => {
                let angle = parameter.map_or(self.angles[axle as usize], sin_cos);
                self.state.turn(axle, sense, angle);
            }
            Command::About => {
                self.state.heading = -self.state.heading;
                self.state.left = -self.state.left;
            }
            Command::Level => self.state.level(),
            Command::Open => {
                if self.states.len() == MOST_DEPTH {
                    return Err(Problem::TooDeep);
                }
                self.states.push((self.state, place));
                self.state.axis = None;
                self.measure.brackets += 1;
                self.measure.depth = self.measure.depth.max(self.states.len() as u32);
            }
            Command::Close => {
                self.leave_axis();
                let Some((state, _)) = self.states.pop() else { return Err(Problem::NoBracket) };
                self.state = state;
            }
            Command::BeginPolygon => {
                if self.polygons.len() == MOST_DEPTH {
                    return Err(Problem::TooDeep);
                }
                let State { up, color, .. } = self.state;
                self.polygons.push((Polygon { vertices: Vec::new(), up, color }, place));
            }
            Command::Vertex => return self.record(),
            Command::EndPolygon => return self.end_polygon(),
            Command::Width => {
                let width = parameter.unwrap_or(self.state.width * self.how.taper);
                self.state.width = width.max(0.0);
            }
            Command::Color => {
                self.state.color = parameter.map_or(self.state.color.saturating_add(1), |color| color as u32);
            }
        }
        Ok(())
    }

    fn advance(&mut self, length: f64, draws: bool, records: bool) -> Result<(), Problem> {
        let from = self.state.position;
        let to = from + length * self.state.heading;
        if !to.is_finite() {
            return Err(Problem::NotFinite);
        }
        let in_polygon = self.polygons.last().map(|(polygon, _)| polygon.vertices.is_empty());
        if records && in_polygon == Some(true) {
            self.record()?;
        }
        let continues = draws && in_polygon.is_none();
        if continues && to != from {
            self.segment(to)?;
        } else if !continues {
            self.leave_axis();
        }
        self.state.position = to;
        let [least, greatest] = self.measure.bounds;
        self.measure.bounds = [least.min(to), greatest.max(to)];
        if draws {
            self.measure.segments += 1;
            self.measure.length += length.abs();
            if let Some(tropism) = self.how.tropism {
                self.state.bend(tropism);
            }
        }
        if records && in_polygon.is_some() { self.record() } else { Ok(()) }
    }

    /// Adds to the axis, which begins here if there is none.
    fn segment(&mut self, to: DVec3) -> Result<(), Problem> {
        let Some(drawing) = &mut self.drawing else { return Ok(()) };
        let State { position, width, color, axis, .. } = self.state;
        let node = |position| Node { position, width, color };
        let index = axis.unwrap_or(drawing.axes.len());
        if axis.is_none() {
            let depth = self.states.len() as u32;
            drawing.axes.push(Axis { nodes: Vec::with_capacity(2), depth });
            self.points += 3;
        }
        let nodes = &mut drawing.axes[index].nodes;
        nodes.pop();
        nodes.extend([node(position), node(to)]);
        self.state.axis = Some(index);
        self.take_points(1)
    }

    /// What comes next does not continue the axis: its last node gets the width that is in force.
    fn leave_axis(&mut self) {
        let Some(index) = self.state.axis.take() else { return };
        let axis = self.drawing.as_mut().and_then(|drawing| drawing.axes.get_mut(index));
        if let Some(node) = axis.and_then(|axis| axis.nodes.last_mut()) {
            node.width = self.state.width;
        }
    }

    /// A vertex of the polygon that was opened last, if one is open.
    fn record(&mut self) -> Result<(), Problem> {
        let Some((polygon, _)) = self.polygons.last_mut() else { return Ok(()) };
        polygon.vertices.push(self.state.position);
        self.take_points(1)
    }

    fn end_polygon(&mut self) -> Result<(), Problem> {
        let Some((polygon, _)) = self.polygons.pop() else { return Err(Problem::NoBrace) };
        self.measure.polygons += 1;
        self.measure.polygon_vertices += polygon.vertices.len() as u64;
        self.measure.polygon_area += vector_area(&polygon.vertices).length();
        if !self.measure.polygon_area.is_finite() {
            return Err(Problem::NotFinite);
        }
        match &mut self.drawing {
            Some(drawing) if polygon.vertices.len() >= 3 => {
                drawing.polygons.push(polygon);
                self.take_points(3)
            }
            _ => {
                self.points -= polygon.vertices.len();
                Ok(())
            }
        }
    }

    fn place(&mut self, name: Module) -> Result<(), Problem> {
        if "[]{}.~@%".contains(name.symbol) {
            return Err(Problem::NoModel);
        }
        let Some(drawing) = &mut self.drawing else { return Ok(()) };
        let State { position, heading, left, up, color, .. } = self.state;
        let frame = DMat3::from_cols(heading, left, up);
        let scale = name.parameters.first().copied().unwrap_or(1.0);
        drawing.placements.push(Placement { symbol: name.symbol, position, frame, scale, color });
        self.take_points(4)
    }

    fn take_points(&mut self, points: usize) -> Result<(), Problem> {
        self.points += points;
        if self.points > MOST_POINTS { Err(Problem::TooMany) } else { Ok(()) }
    }
}

impl State {
    fn turn(&mut self, axle: Axle, sense: Sense, [sin, cos]: [f64; 2]) {
        let sin = if sense == Sense::Positive { sin } else { -sin };
        let State { heading, left, up, .. } = *self;
        match axle {
            Axle::Up => {
                self.heading = cos * heading + sin * left;
                self.left = cos * left - sin * heading;
            }
            Axle::Left => {
                self.heading = cos * heading - sin * up;
                self.up = cos * up + sin * heading;
            }
            Axle::Heading => {
                self.left = cos * left - sin * up;
                self.up = cos * up + sin * left;
            }
        }
    }

    /// Rolls until left is horizontal. A vertical heading has no such roll.
    fn level(&mut self) {
        let left = DVec3::Y.cross(self.heading);
        if left.length() >= 1e-9 {
            self.left = left.normalize();
            self.up = self.heading.cross(self.left);
        }
    }

    /// Prusinkiewicz & Lindenmayer 1990, p. 58.
    fn bend(&mut self, tropism: Tropism) {
        let torque = self.heading.cross(tropism.direction);
        let size = torque.length();
        if size == 0.0 {
            return;
        }
        let axis = torque / size;
        let (sin, cos) = libm::sincos(tropism.strength * size);
        let rotate =
            |vector: DVec3| cos * vector + sin * axis.cross(vector) + (1.0 - cos) * axis.dot(vector) * axis;
        self.heading = rotate(self.heading);
        self.left = rotate(self.left);
        self.up = rotate(self.up);
    }
}

fn command(how: &Interpretation, symbol: char) -> Command {
    let draws = how.draw.contains(symbol);
    let silent = how.silent.contains(symbol);
    if draws || silent || how.moves.contains(symbol) {
        return Command::Move { draws, records: !silent };
    }
    let [left, right] = match how.plus {
        Side::Left => [Sense::Positive, Sense::Negative],
        Side::Right => [Sense::Negative, Sense::Positive],
    };
    match symbol {
        '+' => Command::Turn(Axle::Up, left),
        '-' => Command::Turn(Axle::Up, right),
        '&' => Command::Turn(Axle::Left, Sense::Positive),
        '^' => Command::Turn(Axle::Left, Sense::Negative),
        '\\' => Command::Turn(Axle::Heading, Sense::Positive),
        '/' => Command::Turn(Axle::Heading, Sense::Negative),
        '|' => Command::About,
        '$' => Command::Level,
        '[' => Command::Open,
        ']' => Command::Close,
        '{' => Command::BeginPolygon,
        '.' => Command::Vertex,
        '}' => Command::EndPolygon,
        '!' => Command::Width,
        '\'' => Command::Color,
        '~' | '@' => Command::Place,
        _ => Command::Nothing,
    }
}

/// Half the sum of the cross products along the outline of a polygon (Newell's method): as long as the area that it
/// encloses in the plane across it, and standing on the side from which the outline runs counter-clockwise.
pub fn vector_area(vertices: &[DVec3]) -> DVec3 {
    let Some((&first, rest)) = vertices.split_first() else { return DVec3::ZERO };
    rest.windows(2).map(|edge| (edge[0] - first).cross(edge[1] - first)).sum::<DVec3>() / 2.0
}
