//! `terrane compare`: how far two pictures lie apart.

use super::options::OutputOptions;
use super::output::{check_extension, print};
use crate::app::report::Details;
use crate::app::{Error, Session};
use crate::formats::{self, layers::Layers};
use crate::scene::difference::{Difference, Flip, Seen};
use clap::{Args, ValueEnum, ValueHint};
use serde_json::json;
use std::path::PathBuf;

/// Tell how far two pictures lie apart
///
/// Two EXR files or two PNG files of one size with the same channels; the exit code is 0 if they are the same as far as
/// --metric and --threshold ask for it, and 9 if they are not.
#[derive(Args)]
pub struct Arguments {
    /// Picture to compare with: the reference
    #[arg(value_name = "A", value_hint = ValueHint::FilePath)]
    reference: PathBuf,

    /// Picture to judge
    #[arg(value_name = "B", value_hint = ValueHint::FilePath)]
    other: PathBuf,

    /// Picture of the differences to write, as an eye sees them (FLIP): black where there are none, yellow where they are
    /// largest
    #[arg(short, value_name = "DIFF.png", value_hint = ValueHint::FilePath)]
    out: Option<PathBuf>,

    /// What decides
    #[arg(long, value_name = "NAME", value_enum, default_value_t = Metric::Max)]
    metric: Metric,

    /// Largest value of the metric at which the pictures count as the same
    #[arg(long, value_name = "T", value_parser = threshold, default_value_t = 0.0)]
    threshold: f64,

    #[command(flatten)]
    pub output: OutputOptions,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Metric {
    /// Largest absolute difference of any value in any channel
    Max,
    /// Root of the mean squared difference of the colours
    Rmse,
    /// Mean of the squared difference of the colours over the squared reference plus 0.01
    Relmse,
    /// What an eye sees, from 0 to 1
    Flip,
}

/// Values of channels that are in memory at once, of each picture.
const MOST_VALUES: usize = 32 << 20;

pub fn run(arguments: &Arguments, session: &mut Session) -> Result<(), Error> {
    if let Some(out) = &arguments.out {
        check_extension(out, &["png"])?;
        formats::file::check_writable(out)?;
    }
    let (a, b) = (Layers::open(&arguments.reference)?, Layers::open(&arguments.other)?);
    let (first, second) = (arguments.reference.display(), arguments.other.display());
    if a.scale != b.scale {
        return Err(Error::Usage(format!(
            "{first} and {second} can't be compared: an EXR holds light, and a PNG what a screen shows"
        )));
    }
    if a.size != b.size {
        let size = |[width, height]: [u32; 2]| format!("{width} × {height} pixels");
        return Err(Error::Differs(format!("{first} has {}, and {second} {}", size(a.size), size(b.size))));
    }
    if a.names != b.names {
        let (only_a, only_b) = (lacking(&a.names, &b.names), lacking(&b.names, &a.names));
        return Err(Error::Differs(format!(
            "only {first} has channels {only_a}, and only {second} {only_b}"
        )));
    }
    let colored = COLORS.iter().all(|color| a.names.iter().any(|name| name == color));
    if !colored && (arguments.metric == Metric::Flip || arguments.out.is_some()) {
        return Err(Error::Usage(format!(
            "{first} has no channels R, G and B, so that there is nothing to see"
        )));
    }

    let compared = compare(&a, &b, colored)?;
    let found = Found::of(&compared, a.size[0] as usize);
    if let (Some(out), Some(flip)) = (&arguments.out, &compared.flip) {
        let written = formats::png::write_picture(out, a.size, &flip.picture())?;
        session.report.wrote(&written);
    }
    let value = found.value(arguments.metric).unwrap_or(0.0);
    let differs = value > arguments.threshold;
    session.report.details = Some(Details::Comparison(json!({
        "metric": arguments.metric.name(),
        "threshold": arguments.threshold,
        "differs": differs,
        "max": found.max,
        "rmse": found.rmse,
        "relmse": found.relmse,
        "flip": found.flip,
        "channels": compared.channels.iter().map(|(name, difference)| json!({
            "name": name, "max": difference.max, "rmse": difference.rmse, "relmse": difference.relmse,
        })).collect::<Vec<_>>(),
    })));
    if !arguments.output.json {
        print(found.text().as_bytes())?;
    }
    if differs {
        let (name, threshold) = (arguments.metric.name(), arguments.threshold);
        return Err(Error::Differs(format!("the pictures differ: {name} is {value}, above {threshold}")));
    }
    Ok(())
}

const COLORS: [&str; 3] = ["R", "G", "B"];

/// What two pictures differ by.
struct Compared {
    /// Of all channels, the colours first.
    channels: Vec<(String, Difference)>,
    /// Of the colours, where there are any.
    flip: Option<Flip>,
}

fn compare(a: &Layers, b: &Layers, colored: bool) -> Result<Compared, formats::Error> {
    let mut compared = Compared { channels: Vec::new(), flip: None };
    let is_color = |name: &str| colored && COLORS.contains(&name);
    if colored {
        let names = COLORS.map(String::from);
        let (of_a, of_b) = (a.read(&names)?, b.read(&names)?);
        compared.add(&names, &of_a, &of_b);
        let (of_a, of_b) = (pixels(&of_a), pixels(&of_b));
        let seen = |pixels| match a.scale {
            formats::Scale::Share => Seen::Encoded(pixels),
            formats::Scale::Absolute => Seen::Linear(pixels),
        };
        compared.flip = Some(Flip::of(a.size, &seen(&of_a), &seen(&of_b)));
    }
    let others: Vec<String> = a.names.iter().filter(|name| !is_color(name)).cloned().collect();
    let pixels = a.size[0] as usize * a.size[1] as usize;
    for names in others.chunks((MOST_VALUES / pixels).max(1)) {
        compared.add(names, &a.read(names)?, &b.read(names)?);
    }
    Ok(compared)
}

impl Compared {
    fn add(&mut self, names: &[String], a: &[Vec<f32>], b: &[Vec<f32>]) {
        for (name, (a, b)) in names.iter().zip(a.iter().zip(b)) {
            self.channels.push((name.clone(), Difference::of(a, b)));
        }
    }
}

fn pixels(planes: &[Vec<f32>]) -> Vec<[f32; 3]> {
    let [red, green, blue] = planes else { return Vec::new() };
    red.iter().zip(green).zip(blue).map(|((&red, &green), &blue)| [red, green, blue]).collect()
}

/// The figures of both pictures as a whole.
struct Found {
    max: f64,
    /// Where the largest difference is: channel, column and row.
    place: Option<(String, usize, usize)>,
    /// Over the colours, or over all channels where there are none.
    rmse: f64,
    relmse: f64,
    flip: Option<f64>,
}

impl Found {
    fn of(compared: &Compared, width: usize) -> Found {
        let channels = &compared.channels;
        let worst = channels.iter().max_by(|(_, a), (_, b)| a.max.total_cmp(&b.max));
        let place = worst.filter(|(_, worst)| worst.max > 0.0);
        let colors = if compared.flip.is_some() { &channels[..COLORS.len()] } else { &channels[..] };
        let mean = |of: fn(&Difference) -> f64| {
            colors.iter().map(|(_, difference)| of(difference)).sum::<f64>() / colors.len().max(1) as f64
        };
        Found {
            max: worst.map_or(0.0, |(_, worst)| worst.max),
            place: place.map(|(name, worst)| (name.clone(), worst.at % width, worst.at / width)),
            rmse: mean(|difference| difference.rmse * difference.rmse).sqrt(),
            relmse: mean(|difference| difference.relmse),
            flip: compared.flip.as_ref().map(|flip| flip.mean),
        }
    }

    fn value(&self, metric: Metric) -> Option<f64> {
        match metric {
            Metric::Max => Some(self.max),
            Metric::Rmse => Some(self.rmse),
            Metric::Relmse => Some(self.relmse),
            Metric::Flip => self.flip,
        }
    }

    fn text(&self) -> String {
        let place = match &self.place {
            Some((channel, column, row)) => format!("   in {channel}, column {column}, row {row}"),
            None => String::new(),
        };
        let figure = |value: f64| format!("{value:.6e}");
        let flip = self.flip.map_or(String::new(), |flip| format!("flip    {}\n", figure(flip)));
        let (max, rmse, relmse) = (figure(self.max), figure(self.rmse), figure(self.relmse));
        format!("max     {max}{place}\nrmse    {rmse}\nrelmse  {relmse}\n{flip}")
    }
}

impl Metric {
    fn name(self) -> &'static str {
        match self {
            Metric::Max => "max",
            Metric::Rmse => "rmse",
            Metric::Relmse => "relmse",
            Metric::Flip => "flip",
        }
    }
}

/// The names that are in `of` and not in `other`.
fn lacking(of: &[String], other: &[String]) -> String {
    let names: Vec<&str> = of.iter().filter(|name| !other.contains(name)).map(String::as_str).collect();
    if names.is_empty() { "none".into() } else { names.join(", ") }
}

fn threshold(text: &str) -> Result<f64, String> {
    let threshold = text.parse::<f64>().ok().filter(|threshold| *threshold >= 0.0 && threshold.is_finite());
    threshold.ok_or_else(|| "it must be a number, at least 0".into())
}
