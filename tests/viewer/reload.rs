//! Edited shaders: taken where their interface is the one that the program was built with, refused otherwise.

use crate::kit;
use std::fs;
use std::path::Path;
use tempfile::TempDir;
use terrane::gpu::{Changes, Gpu, Image, Options, Recorder, Sources, format::Rgba8, format::Rgba32f};
use terrane::scene::{Developer, Development, ToneMap};

/// A copy of some shaders, to be edited.
struct Desk {
    folder: TempDir,
    sources: Sources,
}

impl Desk {
    fn new(rooms: &[&str]) -> Desk {
        let folder = tempfile::tempdir().expect("a folder");
        for room in rooms.iter().chain(&["lib"]) {
            let (from, to) = (Path::new("glsl").join(room), folder.path().join(room));
            fs::create_dir(&to).expect("a folder");
            for file in fs::read_dir(from).expect("shaders") {
                let path = file.expect("a file").path();
                fs::copy(&path, to.join(path.file_name().expect("a name"))).expect("a copy");
            }
        }
        let sources = Sources::new(folder.path()).expect("shaders");
        Desk { folder, sources }
    }

    fn edit(&mut self, file: &str, from: &str, to: &str) -> Changes {
        let path = self.folder.path().join(file);
        let text = fs::read_to_string(&path).expect("a shader");
        assert!(text.contains(from), "{file} has no `{from}`");
        fs::write(&path, text.replacen(from, to, 1)).expect("an edit");
        self.sources.changes()
    }
}

/// The only refusal, and no program beside it.
fn refusal(changes: &Changes) -> &str {
    assert!(changes.programs.is_empty());
    let [refusal] = changes.refusals.as_slice() else { panic!("one refusal: {:?}", changes.refusals) };
    refusal
}

/// A pixel of grey light, developed.
fn developed(gpu: &Gpu) -> [u8; 4] {
    let developer = Developer::new(gpu).expect("a program");
    let light = Image::<Rgba32f>::new(gpu, "light", [1, 1]).expect("an image");
    let target = Image::<Rgba8>::new(gpu, "picture", [1, 1]).expect("an image");
    let mut rec = Recorder::new(gpu);
    rec.upload(&light, &[[0.18, 0.18, 0.18, 1.0]]);
    let development = Development { exposure: 1.0, tone_map: ToneMap::None };
    developer.develop(&mut rec, &light, &target, development);
    let texels = rec.download(&target);
    let texels = texels.take(&rec.submit().expect("room").wait().expect("a device"));
    texels[0]
}

#[test]
fn an_edited_program_runs() {
    let gpu = kit::own_gpu(Options::default());
    let before = developed(&gpu);
    assert_eq!([before[0]; 2], [before[1], before[2]], "grey");
    let mut desk = Desk::new(&["scene"]);
    let Changes { programs, files, refusals } =
        desk.edit("lib/tone_map.glsl", "return encoded(", "return vec3(1.0, 0.0, 1.0) * encoded(");
    assert!(refusals.is_empty(), "{refusals:?}");
    assert_eq!(files, ["glsl/lib/tone_map.glsl"]);
    assert_eq!(programs.len(), 1, "one program includes it");
    assert!(!gpu.has_replaced("scene"));
    programs.into_iter().for_each(|program| gpu.replace(program));
    assert!(gpu.has_replaced("scene") && !gpu.has_replaced("terrain"));
    let after = developed(&gpu);
    assert_eq!([after[0], after[2]], [before[0], before[2]]);
    assert!(after[1] <= 1, "no green, but {after:?}");
}

#[test]
fn every_program_of_a_changed_file_is_compiled() {
    let mut desk = Desk::new(&["scene"]);
    let changes = desk.edit("lib/heightfield.glsl", "#ifndef", "// Edited.\n#ifndef");
    assert!(changes.refusals.is_empty(), "{:?}", changes.refusals);
    assert_eq!(changes.programs.len(), 2, "`openness` and `surf` include it");
    assert!(changes.programs.iter().all(|program| program.room() == "scene"));
    let again = desk.sources.changes();
    assert!(again.programs.is_empty() && again.files.is_empty(), "nothing was written since");
}

#[test]
fn another_interface_is_refused() {
    let mut desk = Desk::new(&["viewer", "scene"]);
    for (file, from, to, told) in [
        (
            "viewer/panel.vert",
            "vec2 size; ",
            "ivec2 size; ",
            "`pub size: [i32; 2],` in place of `pub size: [f32; 2],`",
        ),
        ("viewer/panel.frag", "rgba8", "rgba16f", "Rgba16f"),
        ("viewer/panel.frag", "location = 0) out", "location = 1) out", "Writes 1"),
        ("scene/develop.comp", "local_size_y = 8", "local_size_y = 4", "[8, 4, 1]"),
        ("viewer/panel.vert", "uint colour; ", "uint colour, depth; ", "`pub depth: u32,` is new"),
    ] {
        let changes = desk.edit(file, from, to);
        let refusal = refusal(&changes);
        assert!(refusal.contains(told) && refusal.contains(&format!("glsl/{file}")), "{refusal}");
        let back = desk.edit(file, to, from);
        assert_eq!((back.programs.len(), back.refusals.len()), (1, 0), "{:?}", back.refusals);
    }
}

#[test]
fn a_mistake_is_told_with_its_line() {
    let mut desk = Desk::new(&["viewer", "scene"]);
    let changes = desk.edit("viewer/panel.frag", "shown = colour", "shown = color");
    assert!(
        refusal(&changes).contains("glsl/viewer/panel.frag:22: error: 'color'"),
        "{:?}",
        changes.refusals
    );
    let changes = desk.edit("lib/heightfield.glsl", "#ifndef", "mistake\n#ifndef");
    assert!(refusal(&changes).contains("glsl/lib/heightfield.glsl:"), "told once: {:?}", changes.refusals);
}

#[test]
fn stages_that_do_not_fit_are_refused() {
    let mut desk = Desk::new(&["viewer"]);
    let changes = desk.edit(
        "viewer/panel.frag",
        "in vec4 colour",
        "in vec4 colour;\nlayout(location = 2) in float more",
    );
    let told = refusal(&changes);
    assert!(told.contains("glsl/viewer/panel.frag") && told.contains("`more`"), "{told}");
    let changes = desk.edit(
        "viewer/panel.vert",
        "out vec4 colour",
        "out vec4 colour;\nlayout(location = 2) out float more",
    );
    assert_eq!((changes.programs.len(), changes.refusals.len()), (1, 0), "{:?}", changes.refusals);
}
