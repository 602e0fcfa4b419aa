use super::foresight::Question;
use super::*;
use crate::app::viewer::theme;
use crate::terrain::{Plan, Stage};
use crate::world::{Overrides, World};
use egui::{Context, Event, Key as Stroke, Modifiers, PointerButton, Pos2, RawInput, Rect, pos2};
use std::path::{Path, PathBuf};
use std::sync::mpsc::channel;

const WIDTH: f32 = 300.0;
/// A filter that every key passes.
const ALL: &str = "e";

/// The panel without a window.
struct Screen {
    context: Context,
    document: Document,
    foresight: Foresight,
    stage: Stage,
    filter: String,
    height: f32,
    time: f64,
    texts: Vec<(String, Rect)>,
}

impl Screen {
    fn new(world: &str, filter: &str, height: f32) -> Screen {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs").join(world);
        let document = Document::open(&path, &Overrides::default()).expect("a world");
        let context = Context::default();
        theme::apply(&context);
        let mut screen = Screen {
            context,
            document,
            foresight: Foresight::asking(channel().0, channel().1),
            stage: Stage::Base,
            filter: filter.into(),
            height,
            time: 0.0,
            texts: Vec::new(),
        };
        for _ in 0..3 {
            assert!(screen.frame(Vec::new()).is_empty(), "{world}: shown, and changed");
        }
        screen
    }

    /// One frame, in which the user does this.
    fn frame(&mut self, events: Vec<Event>) -> Vec<Edit> {
        self.time += 0.1;
        let input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, vec2(WIDTH, self.height))),
            time: Some(self.time),
            events,
            ..RawInput::default()
        };
        let mut edits = Vec::new();
        let Screen { context, document, foresight, filter, .. } = self;
        foresight.look_at(document, self.stage);
        let output = context.run_ui(input, |ui| edits = show(ui, document, foresight, filter).edits);
        self.texts.clear();
        for clipped in output.shapes {
            texts(&clipped.shape, clipped.clip_rect, &mut self.texts);
        }
        edits
    }

    /// Frames for each of the events; the edits of all.
    fn act(&mut self, events: Vec<Event>) -> Vec<Edit> {
        let mut edits: Vec<Edit> = events.into_iter().flat_map(|event| self.frame(vec![event])).collect();
        edits.extend(self.frame(Vec::new()));
        edits
    }

    /// Every key has the sign that it begins the world again.
    fn sign_all(&mut self) {
        let ((questions, asked), (answer, answers)) = (channel(), channel());
        self.foresight = Foresight::asking(questions, answers);
        self.frame(Vec::new());
        for Question { path, .. } in asked.try_iter() {
            answer.send((path, true)).expect("it is awaited");
        }
        self.frame(Vec::new());
    }

    fn place(&self, text: &str) -> Pos2 {
        let found = self.texts.iter().find(|(other, _)| other == text);
        let all: Vec<&str> = self.texts.iter().map(|(text, _)| text.as_str()).collect();
        found.unwrap_or_else(|| panic!("no {text:?} in {all:?}")).1.center()
    }

    /// The text `what` right of and beside `name`, or below it.
    fn beside(&self, name: &str, what: &str) -> Pos2 {
        let row = self.place(name);
        let found = self.texts.iter().filter(|(text, rect)| text == what && rect.center().y >= row.y - 4.0);
        let nearest = found.min_by(|a, b| a.1.top().total_cmp(&b.1.top()));
        nearest.unwrap_or_else(|| panic!("no {what:?} beside {name:?}")).1.center()
    }

    fn click(&mut self, at: Pos2) -> Vec<Edit> {
        self.act(vec![Event::PointerMoved(at), button(at, true), button(at, false)])
    }

    fn has(&self, text: &str) -> bool {
        self.texts.iter().any(|(other, _)| other == text)
    }

    fn apply(&mut self, edits: &[Edit]) {
        for edit in edits {
            assert!(self.document.edit(edit), "{edit:?}: {:?}", self.document.refused());
        }
        self.frame(Vec::new());
    }
}

fn button(pos: Pos2, pressed: bool) -> Event {
    Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE }
}

fn key(key: Stroke) -> Event {
    Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers: Modifiers::NONE }
}

/// The texts of a shape, with what of their places is seen.
fn texts(shape: &egui::Shape, clip: Rect, found: &mut Vec<(String, Rect)>) {
    match shape {
        egui::Shape::Vec(shapes) => shapes.iter().for_each(|shape| texts(shape, clip, found)),
        egui::Shape::Text(text) => {
            let rect = text.galley.rect.translate(text.pos.to_vec2()).intersect(clip);
            let shown: String = text.galley.text().into();
            if !shown.trim().is_empty() {
                found.push((shown, rect));
            }
        }
        _ => {}
    }
}

fn worlds() -> Vec<String> {
    let configs = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs");
    let files = |kind: &str| -> Vec<PathBuf> {
        std::fs::read_dir(configs.join(kind)).expect("worlds").flatten().map(|found| found.path()).collect()
    };
    let all = ["island", "forest", "landscape", "zoom"].into_iter().flat_map(files);
    let worlds = all.filter(|path| path.extension().is_some_and(|extension| extension == "toml"));
    worlds.map(|path| path.strip_prefix(&configs).expect("it lies there").display().to_string()).collect()
}

fn set<'a>(edits: &'a [Edit], path: &str) -> &'a toml_edit::Value {
    match edits.iter().rfind(|edit| *edit.path() == KeyPath::from(path)) {
        Some(Edit::Set(_, value)) => value,
        other => panic!("{path} is not set: {other:?} in {edits:?}"),
    }
}

#[test]
fn every_world_is_shown_unchanged_and_nothing_overlaps() {
    for world in worlds() {
        let mut screen = Screen::new(&world, ALL, 30_000.0);
        // A zoom has no keys of land.
        let least = if world.starts_with("zoom") { 60 } else { 300 };
        assert!(screen.texts.len() > least, "{world}: {} texts", screen.texts.len());
        screen.sign_all();
        assert!(screen.has(AGAIN), "{world}");
        for (index, (text, rect)) in screen.texts.iter().enumerate() {
            assert!(rect.left() >= 0.0 && rect.right() <= WIDTH + 0.5, "{world}: {text:?} at {rect:?}");
            for (other, over) in &screen.texts[index + 1..] {
                let common = rect.intersect(*over);
                assert!(
                    !(common.width() > 1.0 && common.height() > 1.0),
                    "{world}: {text:?} at {rect:?} over {other:?} at {over:?}"
                );
            }
        }
    }
}

#[test]
fn all_icons_are_in_the_fonts() {
    let screen = Screen::new("island/tiny.toml", "", 600.0);
    let font = egui::TextStyle::Body.resolve(&screen.context.global_style());
    let missing: String = "⟲⏮×⏶⏷²³⁻¹→°…·↑↓←"
        .chars()
        .filter(|icon| !screen.context.fonts_mut(|fonts| fonts.has_glyph(&font, *icon)))
        .collect();
    assert_eq!(missing, "");
}

#[test]
fn numbers_are_dragged() {
    let mut screen = Screen::new("island/volcano.toml", "hydraulic rain", 4000.0);
    let from = screen.beside("rain", "100");
    let drag = |by: f32| Event::PointerMoved(from + vec2(by, 0.0));
    let edits = screen.act(vec![Event::PointerMoved(from), button(from, true), drag(10.0), drag(30.0)]);
    let value = number(&Item::Value(set(&edits, "erosion.hydraulic.rain").clone())).expect("a number");
    assert!((110.0..=200.0).contains(&value), "{value}");
    screen.apply(&edits);
    assert_eq!(screen.document.undo_name(), Some("erosion.hydraulic.rain"));
    let back = screen.frame(vec![drag(-5000.0)]);
    assert_eq!(
        number(&Item::Value(set(&back, "erosion.hydraulic.rain").clone())),
        Some(0.0),
        "within its range"
    );
    assert!(screen.act(vec![button(from, false)]).is_empty());
}

#[test]
fn numbers_are_typed() {
    let mut screen = Screen::new("island/volcano.toml", "sea level", 4000.0);
    let at = screen.place("250");
    assert!(screen.click(at).is_empty());
    let typed = screen.act(vec![Event::Text("1e2".into())]);
    assert!(typed.is_empty(), "not before it is complete: {typed:?}");
    let edits = screen.act(vec![key(Stroke::Enter)]);
    assert_eq!(set(&edits, "sea.level").to_string().trim(), "100");
    screen.apply(&edits);
    assert!(screen.has("100"));
    // What is no number changes nothing.
    let at = screen.place("100");
    screen.click(at);
    assert!(screen.act(vec![Event::Text("high".into()), key(Stroke::Enter)]).is_empty());
}

#[test]
fn what_is_written_goes_back_to_its_default() {
    let mut screen = Screen::new("island/volcano.toml", "hydraulic wet_memory", 4000.0);
    let at = screen.beside("wet memory", "⟲");
    let edits = screen.click(at);
    assert!(
        matches!(edits.as_slice(), [Edit::Remove(path)] if path.to_string() == "erosion.hydraulic.wet_memory")
    );
}

#[test]
fn words_are_chosen_with_their_meaning() {
    let mut screen = Screen::new("island/volcano.toml", "erosion boundary", 4000.0);
    let at = screen.beside("boundary", "sea");
    assert!(screen.click(at).is_empty());
    let entry = "open\nthe rim drains";
    let at = screen.place(entry);
    let edits = screen.click(at);
    assert_eq!(set(&edits, "erosion.boundary").as_str(), Some("open"));
}

#[test]
fn sections_are_switched_off_and_on() {
    let mut screen = Screen::new("island/volcano.toml", "", 900.0);
    let row = screen.place("reef");
    // The box stands at the right end.
    let edits = (230..295).rev().find_map(|x| {
        let edits = screen.click(pos2(x as f32, row.y));
        (!edits.is_empty()).then_some(edits)
    });
    let edits = edits.expect("a switch");
    assert_eq!(set(&edits, "reef").as_str(), Some("none"));
    screen.apply(&edits);
    assert!(screen.has("none"));
    let at = screen.beside("reef", "none");
    let edits = screen.click(at);
    assert!(matches!(edits.as_slice(), [Edit::Remove(path)] if path.to_string() == "reef"), "{edits:?}");
}

#[test]
fn alternatives_replace_each_other() {
    let mut screen = Screen::new("island/volcano.toml", "", 900.0);
    let at = screen.beside("sky", "preetham");
    assert!(screen.click(at).is_empty());
    let entry = screen.texts.iter().find(|(text, _)| text.starts_with("hosek wilkie\n")).expect("an entry").1;
    let edits = screen.click(entry.center());
    assert_eq!(set(&edits, "sky").to_string().trim(), "{ hosek_wilkie = {} }");
    screen.apply(&edits);
    assert!(screen.document.text().contains("[sky]\nhosek_wilkie"), "{}", screen.document.text());
}

#[test]
fn an_alternative_that_asks_for_more_is_a_draft() {
    let mut screen = Screen::new("island/volcano.toml", "", 900.0);
    let at = screen.beside("sky", "preetham");
    screen.click(at);
    let entry = screen.texts.iter().find(|(text, _)| text.starts_with("map\n")).expect("an entry").1;
    assert!(screen.click(entry.center()).is_empty());
    assert!(screen.has("Apply") && screen.has("Cancel"));
    let at = screen.place("Apply");
    screen.frame(vec![Event::PointerMoved(at)]);
    screen.frame(vec![button(at, true)]);
    let edits = screen.frame(vec![button(at, false)]);
    assert_eq!(set(&edits, "sky").to_string().trim(), "{ map = {} }");
    assert!(!screen.document.edit(&edits[0]));
    screen.frame(Vec::new());
    assert!(screen.has("Apply"), "refused, it stays");
    let at = screen.place("Cancel");
    assert!(screen.click(at).is_empty());
    assert!(!screen.has("Apply"));
}

#[test]
fn lists_grow_shrink_and_turn() {
    let mut screen = Screen::new("island/volcano.toml", "layers", 4000.0);
    let at = screen.beside("1  cone: max", "⏶");
    let edits = screen.click(at);
    assert!(
        matches!(&edits[..], [Edit::Move { list, from: 1, to: 0 }] if list.to_string() == "terrain.layers")
    );
    screen.apply(&edits);
    let at = screen.beside("5  crater", "×");
    let edits = screen.click(at);
    assert!(matches!(&edits[..], [Edit::Remove(path)] if path.to_string() == "terrain.layers.5"));
    screen.apply(&edits);
    let at = screen.beside("5  simplex: add", "+ Add");
    let edits = screen.click(at);
    assert!(
        matches!(&edits[..], [Edit::Insert(path, _)] if path.to_string() == "terrain.layers.6"),
        "{edits:?}"
    );
    screen.apply(&edits);
    assert!(screen.has("6  cone"));
}

#[test]
fn a_list_that_is_not_written_is_written_as_a_whole() {
    let mut screen = Screen::new("forest/tiny.toml", "stages", 4000.0);
    // A world without a reef shows none of it.
    assert!(!screen.has("0  duration 36_000"));
    screen = Screen::new("island/tiny.toml", "reef stages duration", 4000.0);
    if screen.document.item().get("reef").is_some() {
        let edits = [Edit::Remove("reef".into())];
        screen.apply(&edits);
    }
    let at = screen.place("36000");
    assert!(screen.click(at).is_empty());
    let edits = screen.act(vec![Event::Text("9".into()), key(Stroke::Enter)]);
    let stages = set(&edits, "reef.stages").as_array().expect("an array");
    assert_eq!((stages.len(), stages.to_string().contains("duration = 9")), (2, true), "{stages}");
}

#[test]
fn names_are_given_and_changed() {
    let mut screen = Screen::new("forest/default.toml", "species file", 8000.0);
    let row = screen.place("+");
    screen.click(row + vec2(60.0, 0.0));
    assert!(screen.act(vec![Event::Text("rose".into()), key(Stroke::Enter)]).is_empty());
    assert!(screen.has("rose") && screen.has("Apply"), "a species asks for more than a name");
    let at = screen.beside("rose", "Cancel");
    screen.click(at);
    assert!(!screen.has("Apply"));
    let at = screen.beside("called", "oak");
    screen.click(at);
    let select = Event::Key {
        key: Stroke::A,
        physical_key: None,
        pressed: true,
        repeat: false,
        modifiers: Modifiers::COMMAND,
    };
    let edits = screen.act(vec![select, Event::Text("tree".into()), key(Stroke::Enter)]);
    assert!(
        matches!(&edits[..], [Edit::Rename(path, name)] if path.to_string() == "species.oak" && name == "tree"),
        "{edits:?}"
    );
}

#[test]
fn keys_reach_everything() {
    let opens = |tabs: usize| {
        let mut screen = Screen::new("island/volcano.toml", "", 900.0);
        for _ in 0..tabs {
            screen.act(vec![key(Stroke::Tab)]);
        }
        screen.act(vec![key(Stroke::Enter)]);
        screen.has("extent")
    };
    assert!((1..8).any(opens), "no key opens `terrain`");
}

#[test]
fn the_filter_finds_names_and_meanings() {
    let screen = Screen::new("island/volcano.toml", "cross-section pipe", 4000.0);
    assert!(
        screen.has("section")
            && !screen.has("pipe depth")
            && !screen.has("capacity")
            && !screen.has("camera")
    );
    let screen = Screen::new("island/volcano.toml", "wet memory", 4000.0);
    assert!(screen.has("wet memory"));
    let screen = Screen::new("island/volcano.toml", "xyzzy", 4000.0);
    assert_eq!(screen.texts.len(), 1);
}

#[test]
fn elements_say_what_they_are() {
    let summary = |text| sections::summary_of(text).unwrap_or_default();
    assert_eq!(
        summary("{ scatter = { spacing = 2, species = [\"oak\", \"beech\"] } }"),
        "scatter: oak, beech"
    );
    assert_eq!(summary("{ file = \"rock.glb\" }"), "rock.glb");
    assert_eq!(summary("{ duration = 36_000, rise = 1 }"), "duration 36_000");
    assert_eq!(summary("{ crater = { level = 1 } }"), "crater");
}

/// Every key that a world shows, with other worlds in which it says something else, and whether the sign stands beside it.
fn foreseen(world: &str, stage: Stage) -> Vec<(String, Vec<World>, bool)> {
    let (questions, asked) = channel();
    let (_answer, answers) = channel();
    let mut screen = Screen::new(world, ALL, 30_000.0);
    (screen.foresight, screen.stage) = (Foresight::asking(questions, answers), stage);
    screen.frame(Vec::new());
    let keys = asked.try_iter().map(|Question { of, path, edits }| {
        let asked = of.upgrade().expect("it is shown");
        let others = asked.others(&path, &edits);
        let again = others.iter().any(|other| asked.begins_again_as(other));
        (path.to_string(), others, again)
    });
    keys.collect()
}

#[test]
fn the_sign_stands_beside_what_is_over() {
    let signed = |stage| -> Vec<String> {
        foreseen("island/volcano.toml", stage).into_iter().filter(|key| key.2).map(|key| key.0).collect()
    };
    let has = |keys: &[String], key: &str| keys.iter().any(|other| other == key);
    let (first, last) = (signed(Stage::Hydraulic), signed(Stage::Reef));
    for key in [
        "seed",
        "terrain.cells",
        "terrain.extent",
        "terrain.layers",
        "sea.level",
        "erosion.boundary",
        "erosion",
    ] {
        assert!(has(&first, key) && has(&last, key), "{key}: {first:?}, {last:?}");
    }
    for key in ["erosion.hydraulic.rain", "erosion.hydraulic.transport", "erosion.thermal.repose"] {
        assert!(!has(&first, key) && has(&last, key), "{key}: {first:?}, {last:?}");
    }
    for key in
        ["render.exposure", "sea.roughness", "surface.grass", "reef.growth", "camera.fov", "controls.rain"]
    {
        assert!(!has(&first, key) && !has(&last, key), "{key}: {first:?}, {last:?}");
    }
    let zoom = foreseen("zoom/tiny.toml", Stage::Base);
    let again = |key: &str| zoom.iter().any(|(path, _, again)| path == key && *again);
    assert!(again("zoom.roughness") && again("zoom.depth") && again("seed"), "another place");
    assert!(!again("zoom.detail") && !again("render.exposure") && !again("sky"), "another look");
}

/// The cache knows land of each stage by a digest of all that has made it.
#[test]
fn the_sign_agrees_with_what_the_cache_knows_land_by() {
    for (world, stage) in [
        ("island/volcano.toml", Stage::Hydraulic),
        ("island/volcano.toml", Stage::Reef),
        ("forest/tiny.toml", Stage::Base),
    ] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs").join(world);
        let now = crate::world::load(&path, &Overrides::default()).expect("a world").plan;
        let made = |plan: &Plan| {
            let before = plan.stages().iter().filter(|(other, _)| *other < stage).count();
            plan.digests().expect("digests").into_iter().take(before).collect::<Vec<_>>()
        };
        for (key, others, again) in foreseen(world, stage) {
            // Rules need what they plant.
            assert!(!others.is_empty() || key.starts_with("species"), "{world}: nothing is known of {key}");
            let differs = others.iter().any(|other| made(&other.plan) != made(&now));
            let is_same = others.iter().all(|other| other.plan == now && other.zoom.is_none());
            // These are looked up as the land is made.
            assert!(
                again || !differs || key.starts_with("controls"),
                "{world}, {stage:?}: {key} changes what is over"
            );
            assert!(!again || !is_same, "{world}, {stage:?}: {key} changes no land");
        }
    }
}
