//! The viewer: every world in a window, alive under the hand.
//!
//! - `window` is the native window, its frame loop and its surface; `painter` draws the user interface.
//! - `engine` is a thread that makes and draws the world, in slices; the window listens to it and never waits.
//! - `desk` is what lies before the user: the picture and the `panels` round it, in the colours of `theme`; `keys` says what keys do.
//! - `document` is the world file as it is edited; `recovery` keeps what is not saved, `state` what is remembered from run to run.
//! - `camera` moves the eye over land; `script` plays a file of keys and mouse; `widgets` knows where things are by their names.
//! - `shipped` are the worlds that come with the program; `export` runs `terrane export` beside it.
//! - `shaders` looks whether shaders are edited, if the program was built for that.

mod camera;
mod desk;
mod document;
mod engine;
mod export;
mod keys;
mod painter;
mod panels;
mod recovery;
mod script;
#[cfg(feature = "reload")]
mod shaders;
mod shipped;
mod state;
mod theme;
mod widgets;
mod window;

use super::cli::options::{self, DeviceOptions, OutputOptions, Size};
use super::{Error, Session, interrupt};
use crate::world::Overrides;
use clap::{Args, ValueHint};
use document::Document;
use std::path::PathBuf;

/// Show a world in a window: fly, watch it change, change it, trace it
///
/// Without a world the window offers those that come with the program. Keys are explained behind F2, and in docs/viewer.md.
#[derive(Args)]
pub struct Arguments {
    /// World file (TOML), or a folder of settings
    #[arg(value_hint = ValueHint::AnyPath)]
    pub world: Option<PathBuf>,

    /// Change a key for this run, for example --set terrain.cells=256; may be repeated
    #[arg(long, value_name = "KEY=VALUE", requires = "world")]
    pub set: Vec<String>,

    /// Another seed, from 0 to 4294967295: another island
    #[arg(long, value_name = "N", requires = "world")]
    pub seed: Option<u32>,

    /// Size of the window's inside, in points [default: as it was last time, 1280x800 the first]
    #[arg(long, value_name = "WxH", value_parser = options::size)]
    pub size: Option<Size>,

    /// Play keys, mouse, waits and screenshots from a text file (docs/viewer.md)
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub script: Option<PathBuf>,

    /// Write the window as a PNG after so many frames, and exit
    #[arg(long, value_name = "FILE", requires = "after_frames", value_hint = ValueHint::FilePath)]
    pub screenshot: Option<PathBuf>,

    /// Frames before the screenshot; they are drawn even if nothing changes
    #[arg(long, value_name = "N", requires = "screenshot", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub after_frames: Option<u64>,

    /// Exit after so many frames, which are drawn even if nothing changes
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    pub exit_after: Option<u64>,

    #[command(flatten)]
    pub device: DeviceOptions,

    #[command(flatten)]
    pub output: OutputOptions,
}

/// Runs the viewer until its window is closed.
pub fn run(arguments: &Arguments, session: &mut Session) -> Result<(), Error> {
    interrupt::listen();
    let script = arguments.script.as_deref().map(script::Script::read).transpose()?;
    if let Some(folder) = state::folder()
        && let Err(error) = shipped::refresh(&folder)
    {
        session.warn(error.to_string());
    }
    let document = match &arguments.world {
        Some(path) => {
            session.report.world = Some(path.to_string_lossy().into_owned());
            let overrides = Overrides { set: arguments.set.clone(), seed: arguments.seed };
            let document = Document::open(path, &overrides)?;
            document.world().warnings.iter().for_each(|warning| session.warn(warning.clone()));
            Some(document)
        }
        None => None,
    };
    window::run(arguments, document, script, session)
}

impl From<document::Error> for Error {
    fn from(error: document::Error) -> Error {
        match error {
            document::Error::World(error) => Error::World(error),
            document::Error::File(error) => Error::File(error),
            document::Error::NoFile(_) | document::Error::Changed(_) => Error::Usage(error.to_string()),
        }
    }
}
