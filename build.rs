//! Compiles every shader under `glsl/` and writes the Rust side of its interface.

#[path = "build/bindgen.rs"]
mod bindgen;
#[path = "build/shader.rs"]
mod shader;

use std::{env, fs, path::Path, process::ExitCode};

fn main() -> ExitCode {
    println!("cargo::rerun-if-changed=glsl");
    println!("cargo::rerun-if-changed=build");
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
    write(&out.join("shaders.rs"), bindgen::rust(&programs)?.as_bytes())
}

fn little_endian(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}
