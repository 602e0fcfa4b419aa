//! Compiles every shader under `glsl/` and writes the Rust side of its interface.

#[path = "build/bindgen.rs"]
mod bindgen;
#[path = "build/shader.rs"]
mod shader;
#[path = "build/worlds.rs"]
mod worlds;

use std::{
    env, fs,
    hash::{DefaultHasher, Hash, Hasher},
    io,
    path::Path,
    process::ExitCode,
};

/// The folders whose code makes land, together with the shaders in `glsl/terrain`.
const MAKERS: [&str; 3] = ["src/terrain", "src/gpu", "src/core"];

fn main() -> ExitCode {
    println!("cargo::rerun-if-changed=glsl");
    println!("cargo::rerun-if-changed=build");
    println!("cargo::rerun-if-changed=configs");
    MAKERS.iter().for_each(|folder| println!("cargo::rerun-if-changed={folder}"));
    let out = env::var_os("OUT_DIR").expect("cargo sets OUT_DIR");
    match build(Path::new("glsl"), Path::new(&out)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

fn build(glsl: &Path, out: &Path) -> Result<(), String> {
    let programs = shader::compile_all(glsl)?;
    let write = |path: &Path, bytes: &[u8]| {
        fs::write(path, bytes).map_err(|error| format!("cannot write {}: {error}", path.display()))
    };
    for program in &programs {
        for stage in &program.stages {
            write(&out.join(program.spirv_file(stage.kind)), little_endian(&stage.spirv).as_slice())?;
        }
    }
    write(&out.join("shaders.rs"), bindgen::rust(&programs)?.as_bytes())?;
    write(&out.join("worlds.rs"), worlds::rust(Path::new("configs"))?.as_bytes())?;
    println!("cargo::rustc-env=TERRANE_CODE={:016x}", code(&programs)?);
    println!("cargo::rustc-env=TERRANE_SHADERS={:016x}", shaders(&programs));
    Ok(())
}

/// A hash of all programs that run on devices: samples of another build are added to only if they were traced by the same ones.
fn shaders(programs: &[shader::Program]) -> u64 {
    let mut hasher = DefaultHasher::new();
    programs.iter().flat_map(|program| &program.stages).for_each(|stage| stage.spirv.hash(&mut hasher));
    hasher.finish()
}

/// A hash of all code that makes land: what another build has made is reused only if it was made by the same code.
fn code(programs: &[shader::Program]) -> Result<u64, String> {
    let mut hasher = DefaultHasher::new();
    env::var_os("TARGET").hash(&mut hasher);
    for program in programs.iter().filter(|program| program.room == "terrain") {
        program.stages.iter().for_each(|stage| stage.spirv.hash(&mut hasher));
    }
    for folder in MAKERS {
        hash_folder(Path::new(folder), &mut hasher)
            .map_err(|error| format!("cannot read {folder}: {error}"))?;
    }
    Ok(hasher.finish())
}

fn hash_folder(folder: &Path, hasher: &mut impl Hasher) -> io::Result<()> {
    let mut paths: Vec<_> =
        fs::read_dir(folder)?.map(|found| Ok(found?.path())).collect::<io::Result<_>>()?;
    paths.sort();
    for path in paths {
        if path.is_dir() {
            hash_folder(&path, hasher)?;
        } else {
            path.hash(hasher);
            fs::read(&path)?.hash(hasher);
        }
    }
    Ok(())
}

fn little_endian(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}
