//! Between the simulation and the cache: what a run takes up from earlier ones, and when it keeps its state.

use super::cli::options::bytes;
use super::error::Kept;
use super::{Error, Session};
use crate::gpu::Gpu;
use crate::terrain::{Position, Simulation, Stage};
use crate::world::World;
use crate::world::cache::{self, Cache, Key};
use etcetera::BaseStrategy;
use std::env;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// What is lost at most when a run is killed.
const INTERVAL: Duration = Duration::from_secs(30);
/// Less work than this is not worth a file when a stage is over.
const LEAST: Duration = Duration::from_secs(1);
/// Bytes of the cache, unless the environment says otherwise: a state of 8192 × 8192 samples has 4.25 GiB.
const LIMIT: u64 = 8 << 30;

/// The cache that the environment asks for: `TERRANE_CACHE` names its folder, `TERRANE_CACHE_LIMIT` its largest size.
/// `None` where the user has no folder for such things.
pub fn cache(session: &mut Session) -> Result<Option<Cache>, Error> {
    let limit = match env::var("TERRANE_CACHE_LIMIT") {
        Ok(limit) => bytes(&limit).map_err(|reason| {
            Error::Usage(format!("the variable TERRANE_CACHE_LIMIT is `{limit}`: {reason}"))
        })?,
        Err(_) => LIMIT,
    };
    let named = env::var_os("TERRANE_CACHE").filter(|folder| !folder.is_empty()).map(PathBuf::from);
    let folder =
        named.or_else(|| Some(etcetera::choose_base_strategy().ok()?.cache_dir().join("terrane/land")));
    if folder.is_none() {
        session.warn("nothing is kept for later runs: name a folder in TERRANE_CACHE".into());
    }
    Ok(folder.map(|folder| Cache { folder, limit }))
}

/// Keeps the state of one run.
pub struct Keeper<'a> {
    gpu: &'a Gpu,
    world: &'a World,
    /// `None` where nothing can be kept: the run goes on without.
    cache: Option<Cache>,
    /// Whether a failure has been told: the next state may fare better, and needs no more words if not.
    told: bool,
    /// Of each stage, in their order.
    keys: Vec<(Stage, Key)>,
    interval: Duration,
    /// When the state was last in the cache.
    last: Instant,
    position: Option<Position>,
}

impl<'a> Keeper<'a> {
    pub fn new(gpu: &'a Gpu, world: &'a World, session: &mut Session) -> Self {
        let mut keeper = Keeper {
            gpu,
            world,
            cache: session.cache.clone(),
            told: false,
            keys: Vec::new(),
            interval: interval(),
            last: Instant::now(),
            position: None,
        };
        if keeper.cache.is_some() {
            match cache::keys(&world.plan, gpu.info()) {
                Ok(keys) => {
                    let stages = world.plan.stages().into_iter().map(|(stage, _)| stage);
                    keeper.keys = stages.zip(keys).collect();
                }
                Err(error) => keeper.failed(&error, session),
            }
        }
        keeper
    }

    /// A run of the world, as far on as the cache knows it.
    pub fn begin(&mut self, session: &mut Session) -> Result<Simulation, Error> {
        let mut simulation = Simulation::new(self.gpu, &self.world.plan)?;
        let Some(cache) = &self.cache else { return Ok(simulation) };
        for (_, key) in self.keys.iter().rev() {
            match cache.load(self.gpu, key, &mut simulation) {
                Ok(true) => break,
                Ok(false) => {}
                Err(cache::Error::Gpu(error)) => return Err(error.into()),
                Err(error) => {
                    session.warn(format!("{error}; that land is made again"));
                    cache.remove(key);
                    // Some images hold what was read, and their memory is needed for new ones.
                    drop(simulation);
                    simulation = Simulation::new(self.gpu, &self.world.plan)?;
                }
            }
        }
        self.position = simulation.position();
        self.last = Instant::now();
        Ok(simulation)
    }

    /// Keeps the state if it is time: behind a stage that took long, and now and then within one.
    pub fn watch(&mut self, simulation: &Simulation, session: &mut Session) {
        let (now, position) = (simulation.progress(), simulation.position());
        let between_stages = now.finished || position.is_some_and(|position| position.stage != now.stage);
        let due = if between_stages { self.interval.min(LEAST) } else { self.interval };
        if self.last.elapsed() >= due {
            self.keep(simulation, session);
        }
    }

    /// Keeps the state now.
    pub fn keep(&mut self, simulation: &Simulation, session: &mut Session) -> Option<Kept> {
        let cache = self.cache.as_ref()?;
        let position = simulation.position()?;
        if self.position != Some(position) {
            let (_, key) = self.keys.iter().find(|(stage, _)| *stage == position.stage)?;
            let stored = cache.store(self.gpu, key, self.world, simulation);
            self.last = Instant::now();
            if let Err(error) = stored {
                self.failed(&error, session);
                return None;
            }
            self.position = Some(position);
        }
        Some(Kept::Land)
    }

    /// A disk may have room again a while later; a state that is too large stays so.
    fn failed(&mut self, error: &cache::Error, session: &mut Session) {
        let hopeless = matches!(error, cache::Error::TooLarge { .. } | cache::Error::Hash(_));
        if !self.told {
            let until = if hopeless { "" } else { " until that is mended" };
            session.warn(format!("this run keeps nothing for later ones{until}: {error}"));
        }
        self.told = true;
        if hopeless {
            self.cache = None;
        }
    }
}

/// Tests can't wait for half a minute: `TERRANE_CACHE_INTERVAL` is in seconds.
pub fn interval() -> Duration {
    let seconds = env::var("TERRANE_CACHE_INTERVAL").ok().and_then(|seconds| seconds.parse().ok());
    seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok()).unwrap_or(INTERVAL)
}
