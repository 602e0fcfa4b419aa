//! Programs from shaders that have been edited since the build: for development, behind the feature `reload`.
//!
//! An edited program is compiled as the build does it, and taken if the build would write the same Rust for it: so shaders and Rust
//! still share one definition of every layout. Anything else needs a build.

#[allow(dead_code, reason = "the build writes it into a file")]
#[path = "../../build/bindgen.rs"]
mod bindgen;
#[allow(dead_code, reason = "the build compiles all at once")]
#[path = "../../build/shader.rs"]
mod shader;

use super::device::{Gpu, lock};
use bindgen::Structs;
use rayon::prelude::*;
use shader::{Source, label};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The Rust side of all programs, as the build has written it.
const BUILT: &str = include_str!(concat!(env!("OUT_DIR"), "/shaders.rs"));

/// A program that may take the place of the build's: its interface is the same.
#[derive(Clone, Debug)]
pub struct Edited {
    room: String,
    stem: String,
    /// SPIR-V, in the order of [`super::Interface::STAGES`].
    stages: Vec<Vec<u32>>,
}

impl Edited {
    /// The folder that its shaders are in, under `glsl/`.
    pub fn room(&self) -> &str {
        &self.room
    }
}

impl Gpu {
    /// From now on, pipelines of this program are made from what was edited.
    pub fn replace(&self, program: Edited) {
        let mut edited = lock(&self.shared().edited);
        edited.retain(|other| (&other.room, &other.stem) != (&program.room, &program.stem));
        edited.push(program);
        // Those that are in use stay what they are; new ones are new.
        lock(&self.shared().programs).clear();
    }

    /// Whether any program of a room has been replaced.
    pub fn has_replaced(&self, room: &str) -> bool {
        lock(&self.shared().edited).iter().any(|program| program.room == room)
    }

    /// SPIR-V of a stage of the program `name`, if that has been replaced.
    pub(super) fn edited(&self, name: &str, stage: usize) -> Option<Vec<u32>> {
        let edited = lock(&self.shared().edited);
        let program = edited.iter().find(|program| format!("{}/{}", program.room, program.stem) == name)?;
        program.stages.get(stage).cloned()
    }
}

/// The shaders in a folder, as they were when they were looked at last.
pub struct Sources {
    glsl: PathBuf,
    programs: Vec<Source>,
    texts: Texts,
}

/// What is in each file; nothing if it can't be read.
type Texts = BTreeMap<PathBuf, Option<String>>;

/// What has become of shaders.
#[derive(Debug, Default)]
pub struct Changes {
    pub programs: Vec<Edited>,
    /// The files that made them other programs.
    pub files: Vec<String>,
    /// Why others stay as they were, with file and line.
    pub refusals: Vec<String>,
}

impl Sources {
    /// The programs in the folder `glsl`.
    ///
    /// # Errors
    /// When it is no such folder.
    pub fn new(glsl: &Path) -> Result<Sources, String> {
        let programs = shader::sources(glsl)?;
        let texts = programs.iter().fold(Texts::new(), |mut texts, program| {
            parts(glsl, program, &mut texts);
            texts
        });
        Ok(Sources { glsl: glsl.into(), programs, texts })
    }

    /// Compiles every program that a file has changed of since the last look.
    pub fn changes(&mut self) -> Changes {
        let mut now = Texts::new();
        let mut touched = Vec::new();
        for program in &self.programs {
            let mut own = Texts::new();
            parts(&self.glsl, program, &mut own);
            let new = own.iter().filter(|(path, text)| self.texts.get(*path) != Some(*text));
            let new: Vec<String> = new.map(|(path, _)| label(&self.glsl, path)).collect();
            if !new.is_empty() {
                touched.push((program, new));
            }
            now.extend(own);
        }
        let compiled: Vec<_> =
            touched.into_par_iter().map(|(program, new)| (compile(program, &self.glsl, &new), new)).collect();
        self.texts = now;
        let mut changes = Changes::default();
        for (program, new) in compiled {
            match program {
                Ok(program) => {
                    changes.programs.push(program);
                    changes.files.extend(new);
                }
                Err(refusal) => changes.refusals.push(refusal.trim_end().into()),
            }
        }
        // Programs share files, and what is wrong with them.
        for list in [&mut changes.files, &mut changes.refusals] {
            list.sort();
            list.dedup();
        }
        changes
    }
}

/// Adds the files of a program, and what they include.
fn parts(glsl: &Path, program: &Source, texts: &mut Texts) {
    let mut left: Vec<PathBuf> = program.files.iter().map(|(_, path)| path.clone()).collect();
    while let Some(path) = left.pop() {
        if texts.contains_key(&path) {
            continue;
        }
        let text = fs::read_to_string(&path).ok();
        let included = text.iter().flat_map(|text| text.lines()).filter_map(|line| {
            let name = line.trim_start().strip_prefix("#include \"")?;
            Some(glsl.join(name.split('"').next()?))
        });
        left.extend(included);
        texts.insert(path, text);
    }
}

/// Compiles a program of which files have changed.
fn compile(program: &Source, glsl: &Path, changed: &[String]) -> Result<Edited, String> {
    let compiler = shaderc::Compiler::new().map_err(|error| error.to_string())?;
    let program = program.compile(&compiler, glsl)?;
    let mut structs = Structs::default();
    let files = changed.join(", ");
    let module =
        bindgen::program_module(&program, &mut structs).map_err(|error| format!("{files}: {error}"))?;
    for text in structs.definitions().chain([&module]) {
        if !BUILT.contains(text.as_str()) {
            let (room, stem) = (&program.room, &program.stem);
            return Err(format!(
                "{files}: glsl/{room}/{stem} has another interface than it was built with{}; build it again",
                difference(text)
            ));
        }
    }
    let stages = program.stages.into_iter().map(|stage| stage.spirv).collect();
    Ok(Edited { room: program.room, stem: program.stem, stages })
}

/// Where a struct or a module begins to be another than the build's.
fn difference(text: &str) -> String {
    let head = text.split_inclusive("{\n").next().unwrap_or_default();
    let Some((_, built)) = BUILT.split_once(head) else { return String::new() };
    let rest = text.get(head.len()..).unwrap_or_default();
    match rest.lines().zip(built.lines()).find(|(new, old)| new != old) {
        Some((new, "}" | "    }")) => format!(" (`{}` is new)", new.trim()),
        Some(("}" | "    }", old)) => format!(" (`{}` is gone)", old.trim()),
        Some((new, old)) => format!(" (`{}` in place of `{}`)", new.trim(), old.trim()),
        None => String::new(),
    }
}
