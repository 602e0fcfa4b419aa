//! Expressions: read in one pass into code for a small stack machine. Constants are folded, and the commonest forms need
//! no machine at all.
//!
//! Transcendental functions are those of `libm`, so that a derivation has the same bits on every machine.

use super::{Error, text::Cursor};
use crate::core::text::cut;
use std::collections::HashMap;
use std::ops::Range;

/// How deep brackets, signs and powers may be nested.
const DEEPEST: usize = 64;
/// Values that the machine holds at a time.
const STACK: usize = 32;

/// An expression, ready to be evaluated.
#[derive(Clone, Debug)]
pub struct Code {
    pub span: Range<usize>,
    /// Operations that an evaluation takes about, in units of the simplest.
    pub cost: u64,
    form: Form,
}

#[derive(Clone, Debug)]
enum Form {
    Number(f64),
    Parameter(usize),
    /// One operation on a parameter: most of what successors and conditions hold.
    Single {
        operator: Binary,
        parameter: usize,
        number: f64,
    },
    Program(Program),
}

#[derive(Clone, Debug, Default)]
struct Program {
    ops: Vec<Op>,
    /// Of the expression that each operation ends.
    spans: Vec<Range<usize>>,
}

#[derive(Clone, Copy, Debug)]
enum Op {
    Number(f64),
    Parameter(usize),
    Binary(Binary),
    /// With a number on the right.
    With(Binary, f64),
    Function(Function),
    Random {
        site: u32,
    },
    /// Where the left side of `&&` or `||` decides, the right one is not evaluated.
    UnlessTrue {
        end: usize,
    },
    UnlessFalse {
        end: usize,
    },
    Truth,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Binary {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Equal,
    Unequal,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Min,
    Max,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Function {
    Negate,
    Not,
    Abs,
    Sqrt,
    Exp,
    Ln,
    Sin,
    Cos,
    Tan,
    Floor,
    Ceil,
    Sign,
}

/// Why an expression has no value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Undefined {
    #[error("division by zero")]
    DivisionByZero,
    #[error("a value that is no number")]
    NoNumber,
    #[error("a number that is too large")]
    TooLarge,
}

/// Where random numbers come from: a number is a hash of the seed, the step, the place in the word and the place in the
/// grammar, so that it does not depend on what is evaluated before.
#[derive(Clone, Copy, Debug)]
pub struct Chance {
    key: u64,
    position: u64,
}

/// The name's place among the parameters of a rule, or its value.
pub struct Scope<'a> {
    pub constants: &'a mut HashMap<String, Constant>,
    pub parameters: &'a [Parameter],
    /// Calls of `rnd` so far in the grammar.
    pub sites: &'a mut u32,
    pub randomness: Randomness,
}

/// Whether there may be chance: constants are the same for all seeds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Randomness {
    Allowed,
    Refused,
}

#[derive(Clone, Debug)]
pub struct Constant {
    pub value: f64,
    pub span: Range<usize>,
    pub used: bool,
}

#[derive(Clone, Debug)]
pub struct Parameter {
    pub name: String,
    pub span: Range<usize>,
}

impl Code {
    /// Reads an expression up to where it can't go on.
    pub fn read(cursor: &mut Cursor, scope: &mut Scope) -> Result<Code, Error> {
        let start = cursor.place();
        let mut reader = Reader { cursor, scope, program: Program::default(), nesting: 0, held: 0 };
        reader.either()?;
        let program = reader.program;
        let span = start..cursor.last();
        let form = match program.ops.as_slice() {
            [Op::Number(number)] => Form::Number(*number),
            [Op::Parameter(parameter)] => Form::Parameter(*parameter),
            [Op::Parameter(parameter), Op::With(operator, number)] => {
                Form::Single { operator: *operator, parameter: *parameter, number: *number }
            }
            ops if !ops.iter().any(|op| matches!(op, Op::Parameter(_) | Op::Random { .. })) => {
                let value = program.run(&[], Chance::none()).map_err(|(why, span)| refuse(why, span))?;
                Form::Number(value)
            }
            _ => Form::Program(program),
        };
        Ok(Code { span, cost: form.cost(), form })
    }

    /// The value, if it is the same everywhere.
    pub fn constant(&self) -> Option<f64> {
        match self.form {
            Form::Number(number) => Some(number),
            _ => None,
        }
    }

    pub fn is_random(&self) -> bool {
        matches!(&self.form, Form::Program(program) if program.ops.iter().any(|op| matches!(op, Op::Random { .. })))
    }

    /// Evaluates.
    ///
    /// # Errors
    /// What part is no finite number, by its span.
    #[inline]
    pub fn value(&self, parameters: &[f64], chance: Chance) -> Result<f64, (Undefined, Range<usize>)> {
        match &self.form {
            Form::Number(number) => Ok(*number),
            Form::Parameter(parameter) => Ok(parameters[*parameter]),
            Form::Single { operator, parameter, number } => operator
                .apply(parameters[*parameter], *number)
                .map_err(|undefined| (undefined, self.span.clone())),
            Form::Program(program) => program.run(parameters, chance),
        }
    }
}

impl Form {
    fn cost(&self) -> u64 {
        let Form::Program(program) = self else { return 1 };
        let costly =
            |op: &&Op| matches!(op, Op::Function(_) | Op::Binary(Binary::Power) | Op::With(Binary::Power, _));
        (program.ops.len() + 15 * program.ops.iter().filter(costly).count()) as u64
    }
}

impl Program {
    fn run(&self, parameters: &[f64], chance: Chance) -> Result<f64, (Undefined, Range<usize>)> {
        let mut stack = [0.0; STACK];
        // Below the top, which is in `top`.
        let mut held = 0;
        let mut top = 0.0;
        let mut at = 0;
        while let Some(op) = self.ops.get(at) {
            let result = match *op {
                Op::Number(number) => {
                    stack[held] = top;
                    held += 1;
                    Ok(number)
                }
                Op::Parameter(parameter) => {
                    stack[held] = top;
                    held += 1;
                    Ok(parameters[parameter])
                }
                Op::Binary(operator) => {
                    held -= 1;
                    operator.apply(stack[held], top)
                }
                Op::With(operator, number) => operator.apply(top, number),
                Op::Function(function) => function.apply(top),
                Op::Random { site } => {
                    held -= 1;
                    finite(stack[held] + (top - stack[held]) * chance.unit(site))
                }
                Op::UnlessTrue { end } | Op::UnlessFalse { end } => {
                    let stays = matches!(op, Op::UnlessTrue { .. }) == (top != 0.0);
                    if stays {
                        held -= 1;
                        Ok(stack[held])
                    } else {
                        at = end - 1;
                        Ok(truth(top != 0.0))
                    }
                }
                Op::Truth => Ok(truth(top != 0.0)),
            };
            match result {
                Ok(value) => top = value,
                Err(undefined) => return Err((undefined, self.spans[at].clone())),
            }
            at += 1;
        }
        Ok(top)
    }
}

impl Binary {
    #[inline]
    fn apply(self, left: f64, right: f64) -> Result<f64, Undefined> {
        match self {
            Binary::Add => finite(left + right),
            Binary::Subtract => finite(left - right),
            Binary::Multiply => finite(left * right),
            Binary::Divide if right == 0.0 => Err(Undefined::DivisionByZero),
            Binary::Divide => finite(left / right),
            Binary::Power if left == 0.0 && right < 0.0 => Err(Undefined::DivisionByZero),
            Binary::Power => finite(libm::pow(left, right)),
            Binary::Equal => Ok(truth(left == right)),
            Binary::Unequal => Ok(truth(left != right)),
            Binary::Less => Ok(truth(left < right)),
            Binary::LessEqual => Ok(truth(left <= right)),
            Binary::Greater => Ok(truth(left > right)),
            Binary::GreaterEqual => Ok(truth(left >= right)),
            // Which of two zeros `f64::min` takes is the platform's choice.
            Binary::Min => Ok(if right < left { right } else { left }),
            Binary::Max => Ok(if right > left { right } else { left }),
        }
    }
}

impl Function {
    fn named(name: &str) -> Option<Function> {
        Some(match name {
            "abs" => Function::Abs,
            "sqrt" => Function::Sqrt,
            "exp" => Function::Exp,
            "ln" => Function::Ln,
            "sin" => Function::Sin,
            "cos" => Function::Cos,
            "tan" => Function::Tan,
            "floor" => Function::Floor,
            "ceil" => Function::Ceil,
            "sign" => Function::Sign,
            _ => return None,
        })
    }

    fn apply(self, value: f64) -> Result<f64, Undefined> {
        match self {
            Function::Negate => Ok(-value),
            Function::Not => Ok(truth(value == 0.0)),
            Function::Abs => Ok(value.abs()),
            Function::Sqrt => finite(value.sqrt()),
            Function::Exp => finite(libm::exp(value)),
            Function::Ln if value == 0.0 => Err(Undefined::NoNumber),
            Function::Ln => finite(libm::log(value)),
            Function::Sin => Ok(sin_cos(value)[0]),
            Function::Cos => Ok(sin_cos(value)[1]),
            Function::Tan => {
                let [sin, cos] = sin_cos(value);
                if cos == 0.0 { Err(Undefined::DivisionByZero) } else { finite(sin / cos) }
            }
            Function::Floor => Ok(value.floor()),
            Function::Ceil => Ok(value.ceil()),
            Function::Sign => Ok(if value == 0.0 { 0.0 } else { value.signum() }),
        }
    }
}

fn truth(holds: bool) -> f64 {
    f64::from(u8::from(holds))
}

#[inline]
fn finite(value: f64) -> Result<f64, Undefined> {
    if value.is_finite() {
        Ok(value)
    } else if value.is_nan() {
        Err(Undefined::NoNumber)
    } else {
        Err(Undefined::TooLarge)
    }
}

/// Of an angle in degrees; exact where it is a multiple of 90°.
pub fn sin_cos(degrees: f64) -> [f64; 2] {
    let turns = (degrees / 90.0).round();
    let (sin, cos) = libm::sincos((degrees - 90.0 * turns).to_radians());
    match turns.rem_euclid(4.0) as u8 {
        0 => [sin, cos],
        1 => [cos, -sin],
        2 => [-sin, -cos],
        _ => [-cos, sin],
    }
}

impl Chance {
    /// Of a step; the axiom is step 0.
    pub fn new(seed: u32, step: u32) -> Chance {
        Chance { key: scatter(u64::from(seed) << 32 | u64::from(step)), position: 0 }
    }

    fn none() -> Chance {
        Chance { key: 0, position: 0 }
    }

    #[inline]
    pub fn at(self, position: usize) -> Chance {
        Chance { position: position as u64, ..self }
    }

    /// From 0 to 1, without 1.
    pub fn unit(self, site: u32) -> f64 {
        let word = scatter(scatter(self.key ^ self.position) ^ u64::from(site));
        (word >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }
}

/// A bijection that scatters neighbouring integers: the output function of SplitMix (Steele, Lea & Flood 2014), with the
/// constants of Stafford's variant 13, after one step of its sequence.
fn scatter(value: u64) -> u64 {
    let value = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let value = (value ^ (value >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let value = (value ^ (value >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    value ^ (value >> 31)
}

/// Reads by recursive descent, a method for each rank of operators, and writes code in the same order.
struct Reader<'a, 'text, 'scope> {
    cursor: &'a mut Cursor<'text>,
    scope: &'a mut Scope<'scope>,
    program: Program,
    nesting: usize,
    /// Values on the machine's stack after what is written so far.
    held: usize,
}

impl Reader<'_, '_, '_> {
    fn either(&mut self) -> Result<(), Error> {
        let start = self.cursor.place();
        self.both()?;
        while self.cursor.take_pair('|', '|') || self.cursor.take('|') {
            self.shortcut(start, |end| Op::UnlessFalse { end }, Self::both)?;
        }
        Ok(())
    }

    fn both(&mut self) -> Result<(), Error> {
        let start = self.cursor.place();
        self.comparison()?;
        while self.cursor.take_pair('&', '&') || self.cursor.take('&') {
            self.shortcut(start, |end| Op::UnlessTrue { end }, Self::comparison)?;
        }
        Ok(())
    }

    /// The right side of `&&` or `||`, and the jump over it.
    fn shortcut(
        &mut self,
        start: usize,
        jump: impl Fn(usize) -> Op,
        right: impl Fn(&mut Self) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let hole = self.program.ops.len();
        self.write(jump(0), start)?;
        self.held -= 1;
        right(self)?;
        self.write(Op::Truth, start)?;
        self.program.ops[hole] = jump(self.program.ops.len());
        Ok(())
    }

    fn comparison(&mut self) -> Result<(), Error> {
        let start = self.cursor.place();
        self.sum()?;
        let Some(operator) = self.comparator() else { return Ok(()) };
        self.binary(start, operator, Self::sum)?;
        let again = self.cursor.place();
        if self.comparator().is_some() {
            let problem = "comparisons can't be chained";
            return Err(Error::new(again..self.cursor.last(), problem, "`&&` between two comparisons"));
        }
        Ok(())
    }

    fn comparator(&mut self) -> Option<Binary> {
        let cursor = &mut self.cursor;
        if cursor.take_pair('=', '=') || cursor.take('=') {
            Some(Binary::Equal)
        } else if cursor.take_pair('!', '=') {
            Some(Binary::Unequal)
        } else if cursor.take_pair('<', '=') {
            Some(Binary::LessEqual)
        } else if cursor.take_pair('>', '=') {
            Some(Binary::GreaterEqual)
        } else if cursor.take('<') {
            Some(Binary::Less)
        } else if cursor.take('>') {
            Some(Binary::Greater)
        } else {
            None
        }
    }

    fn sum(&mut self) -> Result<(), Error> {
        let start = self.cursor.place();
        self.product()?;
        loop {
            let operator = match self.cursor.peek() {
                Some('+') => Binary::Add,
                Some('-') => Binary::Subtract,
                _ => return Ok(()),
            };
            self.cursor.bump();
            self.binary(start, operator, Self::product)?;
        }
    }

    fn product(&mut self) -> Result<(), Error> {
        let start = self.cursor.place();
        self.signed()?;
        loop {
            let operator = match self.cursor.peek() {
                Some('*') => Binary::Multiply,
                Some('/') => Binary::Divide,
                _ => return Ok(()),
            };
            self.cursor.bump();
            self.binary(start, operator, Self::signed)?;
        }
    }

    fn signed(&mut self) -> Result<(), Error> {
        let start = self.cursor.place();
        let function = match self.cursor.peek() {
            Some('-') => Function::Negate,
            Some('!') => Function::Not,
            _ => return self.power(),
        };
        self.cursor.bump();
        self.deeper(start, Self::signed)?;
        self.function(start, function)
    }

    fn power(&mut self) -> Result<(), Error> {
        let start = self.cursor.place();
        self.operand()?;
        if !self.cursor.take('^') {
            return Ok(());
        }
        self.binary(start, Binary::Power, |reader| reader.deeper(start, Self::signed))
    }

    fn operand(&mut self) -> Result<(), Error> {
        let start = self.cursor.place();
        match self.cursor.peek() {
            Some('(') => {
                self.cursor.bump();
                self.deeper(start, Self::either)?;
                self.close(start)
            }
            Some(digit) if digit.is_ascii_digit() || digit == '.' => {
                let number = self.number()?;
                self.write(Op::Number(number), start)
            }
            Some(letter) if letter.is_alphabetic() || letter == '_' => {
                let name = self.cursor.name();
                if self.cursor.peek() == Some('(') {
                    self.call(name, start)
                } else {
                    self.variable(name, start)
                }
            }
            _ => Err(self.cursor.unexpected("a number, a name or `(`")),
        }
    }

    fn number(&mut self) -> Result<f64, Error> {
        let (text, span) = self.cursor.number();
        let refused = || {
            Error::new(span.clone(), format!("`{}` is no number", cut(text)), "digits, as in `0.5` or `1e-3`")
        };
        let value: f64 = text.parse().map_err(|_| refused())?;
        if value.is_finite() { Ok(value) } else { Err(refuse(Undefined::TooLarge, span)) }
    }

    fn variable(&mut self, name: &str, start: usize) -> Result<(), Error> {
        let parameter = self.scope.parameters.iter().position(|parameter| parameter.name == name);
        if let Some(parameter) = parameter {
            return self.write(Op::Parameter(parameter), start);
        }
        if let Some(constant) = self.scope.constants.get_mut(name) {
            constant.used = true;
            let value = constant.value;
            return self.write(Op::Number(value), start);
        }
        let known = self.scope.parameters.iter().map(|parameter| &parameter.name);
        let mut known: Vec<&str> = known.chain(self.scope.constants.keys()).map(String::as_str).collect();
        known.sort_unstable();
        let similar = |known: &&&str| strsim::damerau_levenshtein(known, name) <= 1 && name.len() > 1;
        let expected = match (known.iter().find(similar), known.is_empty() || known.len() > 20) {
            (Some(known), _) => format!("did you mean `{}`?", cut(known)),
            (None, true) => "a parameter of the rule, or a constant from a line above".into(),
            (None, false) => {
                let known: Vec<String> = known.iter().map(|name| cut(name)).collect();
                format!("one of `{}`", known.join("`, `"))
            }
        };
        Err(Error::new(start..self.cursor.last(), format!("`{}` is not known here", cut(name)), expected))
    }

    fn call(&mut self, name: &str, start: usize) -> Result<(), Error> {
        let span = start..self.cursor.last();
        let function = Function::named(name);
        let random = name == "rnd";
        if random && self.scope.randomness == Randomness::Refused {
            let problem = "a constant is the same for every seed";
            return Err(Error::new(span, problem, "`rnd` in the axiom or in a rule"));
        }
        let pair = match name {
            "min" => Some(Binary::Min),
            "max" => Some(Binary::Max),
            _ => None,
        };
        if function.is_none() && pair.is_none() && !random {
            let expected = "one of `min`, `max`, `abs`, `sqrt`, `exp`, `ln`, `sin`, `cos`, `tan`, `floor`, `ceil`, `sign`, `rnd`";
            return Err(Error::new(span, format!("there is no function `{}`", cut(name)), expected));
        }
        let open = self.cursor.place();
        self.cursor.bump();
        self.deeper(open, Self::either)?;
        if let Some(function) = function {
            self.close(open)?;
            return self.function(start, function);
        }
        if !self.cursor.take(',') {
            return Err(self.cursor.unexpected(&format!("`,`: `{name}` has two arguments")));
        }
        let Some(pair) = pair else {
            self.deeper(open, Self::either)?;
            self.close(open)?;
            let site = *self.scope.sites;
            *self.scope.sites += 1;
            self.held -= 1;
            return self.write(Op::Random { site }, start);
        };
        self.binary(start, pair, |reader| {
            reader.deeper(open, Self::either)?;
            reader.close(open)
        })
    }

    fn close(&mut self, open: usize) -> Result<(), Error> {
        if self.cursor.take(')') {
            return Ok(());
        }
        if self.cursor.peek().is_none() {
            return Err(Error::new(open..open + 1, "this `(` is not closed", "`)`"));
        }
        Err(self.cursor.unexpected("an operator or `)`"))
    }

    fn deeper(
        &mut self,
        start: usize,
        inner: impl FnOnce(&mut Self) -> Result<(), Error>,
    ) -> Result<(), Error> {
        if self.nesting == DEEPEST {
            return Err(too_deep(start..start + 1));
        }
        self.nesting += 1;
        inner(self)?;
        self.nesting -= 1;
        Ok(())
    }

    /// Reads the right operand and writes the operation.
    fn binary(
        &mut self,
        start: usize,
        operator: Binary,
        right: impl FnOnce(&mut Self) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let middle = self.program.ops.len();
        right(self)?;
        let span = start..self.cursor.last();
        self.held -= 1;
        if let [Op::Number(number)] = self.program.ops[middle..] {
            self.program.pop();
            // Code in which a number comes last is that number alone.
            if let Some(Op::Number(left)) = self.program.ops.last().copied() {
                let value = operator.apply(left, number).map_err(|why| refuse(why, span.clone()))?;
                self.program.pop();
                self.program.push(Op::Number(value), span);
            } else {
                self.program.push(Op::With(operator, number), span);
            }
            return Ok(());
        }
        self.program.push(Op::Binary(operator), span);
        Ok(())
    }

    fn function(&mut self, start: usize, function: Function) -> Result<(), Error> {
        let span = start..self.cursor.last();
        if let Some(Op::Number(value)) = self.program.ops.last().copied() {
            let value = function.apply(value).map_err(|why| refuse(why, span.clone()))?;
            self.program.pop();
            self.program.push(Op::Number(value), span);
        } else {
            self.program.push(Op::Function(function), span);
        }
        Ok(())
    }

    fn write(&mut self, op: Op, start: usize) -> Result<(), Error> {
        let span = start..self.cursor.last();
        if matches!(op, Op::Number(_) | Op::Parameter(_)) {
            self.held += 1;
            if self.held >= STACK {
                return Err(too_deep(span));
            }
        }
        self.program.push(op, span);
        Ok(())
    }
}

impl Program {
    fn push(&mut self, op: Op, span: Range<usize>) {
        self.ops.push(op);
        self.spans.push(span);
    }

    fn pop(&mut self) {
        self.ops.pop();
        self.spans.pop();
    }
}

fn too_deep(span: Range<usize>) -> Error {
    Error::new(
        span,
        "this is nested too deeply",
        format!("at most {DEEPEST} levels: give a part of it a name"),
    )
}

fn refuse(why: Undefined, span: Range<usize>) -> Error {
    Error::new(span, why.to_string(), "a finite number")
}
