//! What keys and mouse do: one table, which the viewer listens by and the help page shows.

use egui::{Event, InputState, Key, Modifiers};

/// What a key that is pressed once asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Action {
    // Window
    TogglePanels,
    Help,
    FullScreen,
    Screenshot,
    Quit,
    // Files
    Open,
    Save,
    SaveAs,
    Reload,
    Export,
    Undo,
    Redo,
    // View
    /// The mouse turns the view, or points at things.
    MouseLook,
    /// Orbit or fly.
    OtherCamera,
    FrameAll,
    /// What lies over the picture is closed; else the mouse is not taken, and no plant is marked any more.
    LetGo,
    /// Back to the place of this number.
    Bookmark(u8),
    /// Remembers the place under this number.
    SetBookmark(u8),
    CopyCommand,
    // Simulation
    PlayPause,
    Step,
    Restart,
    // Path tracer
    Trace,
    // Zoom
    Autopilot,
    WayBack,
    CopyLocation,
}

/// What a key does for as long as it is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    Forward,
    Back,
    Left,
    Right,
    Up,
    Down,
    RollLeft,
    RollRight,
    TurnLeft,
    TurnRight,
    TurnUp,
    TurnDown,
    /// Everything goes faster.
    Fast,
}

/// Where the help page shows a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    Flying,
    View,
    Simulation,
    Zoom,
    File,
    Window,
}

impl Group {
    pub const ALL: [Group; 6] =
        [Group::Flying, Group::View, Group::Simulation, Group::Zoom, Group::File, Group::Window];

    pub fn name(self) -> &'static str {
        match self {
            Group::Flying => "Flying",
            Group::View => "View and picture",
            Group::Simulation => "Simulation",
            Group::Zoom => "Endless zoom",
            Group::File => "World file",
            Group::Window => "Window",
        }
    }
}

/// One row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    pub group: Group,
    pub input: Input,
    pub text: &'static str,
}

#[derive(Clone, Copy, Debug)]
pub enum Input {
    /// Each of the shortcuts asks for it.
    Press(Action, &'static [Shortcut]),
    /// While one of the keys is held.
    Hold(Motion, &'static [Key]),
    /// What the mouse does, in a few words.
    Mouse(&'static str),
}

/// A key with what is held beside it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shortcut {
    /// Ctrl, or ⌘ on a Mac.
    pub command: bool,
    pub shift: bool,
    pub key: Key,
}

const fn key(key: Key) -> Shortcut {
    Shortcut { command: false, shift: false, key }
}

const fn command(key: Key) -> Shortcut {
    Shortcut { command: true, shift: false, key }
}

const fn command_shift(key: Key) -> Shortcut {
    Shortcut { command: true, shift: true, key }
}

const fn press(group: Group, action: Action, shortcuts: &'static [Shortcut], text: &'static str) -> Row {
    Row { group, input: Input::Press(action, shortcuts), text }
}

const fn hold(motion: Motion, keys: &'static [Key], text: &'static str) -> Row {
    Row { group: Group::Flying, input: Input::Hold(motion, keys), text }
}

const fn mouse(group: Group, what: &'static str, text: &'static str) -> Row {
    Row { group, input: Input::Mouse(what), text }
}

/// Everything that keys and mouse do.
pub const TABLE: &[Row] = &[
    hold(Motion::Forward, &[Key::W], "forward"),
    hold(Motion::Back, &[Key::S], "back"),
    hold(Motion::Left, &[Key::A], "left"),
    hold(Motion::Right, &[Key::D], "right"),
    hold(Motion::Up, &[Key::Space], "up"),
    hold(Motion::Down, &[Key::C], "down"),
    hold(Motion::RollLeft, &[Key::Q], "roll left"),
    hold(Motion::RollRight, &[Key::E], "roll right"),
    hold(Motion::TurnLeft, &[Key::ArrowLeft], "look left"),
    hold(Motion::TurnRight, &[Key::ArrowRight], "look right"),
    hold(Motion::TurnUp, &[Key::ArrowUp], "look up"),
    hold(Motion::TurnDown, &[Key::ArrowDown], "look down"),
    Row { group: Group::Flying, input: Input::Hold(Motion::Fast, &[]), text: "four times as fast" },
    press(
        Group::Flying,
        Action::MouseLook,
        &[key(Key::F)],
        "the mouse looks around, or points at things again",
    ),
    mouse(Group::Flying, "Wheel", "faster or slower; by itself speed follows the distance to the ground"),
    press(
        Group::View,
        Action::OtherCamera,
        &[key(Key::O)],
        "a drag goes round the middle of the picture, or looks round",
    ),
    mouse(
        Group::View,
        "Drag",
        "go round the middle of the picture; with the right button look round; the wheel goes near and far",
    ),
    mouse(Group::View, "Click", "mark a plant, and tell what it is; bare ground marks none"),
    press(
        Group::View,
        Action::LetGo,
        &[key(Key::Escape)],
        "close what lies over the picture; else the mouse points at things again, or no plant is marked",
    ),
    press(
        Group::View,
        Action::FrameAll,
        &[key(Key::Home)],
        "all of the land in the picture; in a zoom, the horizon level",
    ),
    press(Group::View, Action::Bookmark(1), &[key(Key::Num1)], "back to place 1; 2 to 9 likewise"),
    press(
        Group::View,
        Action::SetBookmark(1),
        &[command(Key::Num1)],
        "remember this place as 1; 2 to 9 likewise",
    ),
    press(
        Group::View,
        Action::CopyCommand,
        &[command(Key::K)],
        "copy the command line that renders this view",
    ),
    press(
        Group::View,
        Action::Trace,
        &[key(Key::P)],
        "trace paths whenever nothing moves, or show the rasterised picture again",
    ),
    press(Group::Simulation, Action::PlayPause, &[key(Key::Enter)], "run the simulation, or let it rest"),
    press(Group::Simulation, Action::Step, &[key(Key::Period)], "a single step"),
    press(Group::Simulation, Action::Restart, &[key(Key::Backspace)], "from the start again"),
    press(Group::Zoom, Action::Autopilot, &[key(Key::G)], "fly down by itself, or stop"),
    press(Group::Zoom, Action::WayBack, &[key(Key::B)], "fly back up the way it came, or stop"),
    press(Group::Zoom, Action::CopyLocation, &[command(Key::L)], "copy the code of this place"),
    press(Group::File, Action::Open, &[command(Key::O)], "open a world"),
    press(Group::File, Action::Save, &[command(Key::S)], "save the world; comments of the file stay"),
    press(Group::File, Action::SaveAs, &[command_shift(Key::S)], "save it under another name"),
    press(Group::File, Action::Reload, &[key(Key::F5)], "read the file again"),
    press(
        Group::File,
        Action::Export,
        &[command(Key::E)],
        "write layers, meshes and scenes for other programs",
    ),
    press(Group::File, Action::Undo, &[command(Key::Z)], "take the last change back"),
    press(Group::File, Action::Redo, &[command_shift(Key::Z), command(Key::Y)], "do it again"),
    press(Group::Window, Action::TogglePanels, &[key(Key::F1)], "show or hide the panels"),
    press(Group::Window, Action::Help, &[key(Key::F2), key(Key::Questionmark)], "this page"),
    press(Group::Window, Action::FullScreen, &[key(Key::F11)], "fill the screen"),
    press(Group::Window, Action::Screenshot, &[key(Key::F12)], "write the picture without panels"),
    press(Group::Window, Action::Quit, &[command(Key::Q)], "leave; what is not saved is asked about"),
];

const DIGITS: [Key; 9] =
    [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7, Key::Num8, Key::Num9];

/// What the keys that were pressed since the last frame ask for, in their order. While the user is `typing`, plain keys belong to
/// the text, and so do undo and redo.
pub fn of(input: &InputState, typing: bool) -> impl Iterator<Item = Action> {
    let pressed = input.events.iter().filter_map(|event| match event {
        Event::Key { key, pressed: true, repeat: false, modifiers, .. } => Some((*key, *modifiers)),
        _ => None,
    });
    pressed.filter_map(move |(key, modifiers)| {
        action(key, modifiers).filter(|action| !typing || heeds(*action, key))
    })
}

/// What a key with its modifiers asks for.
fn action(key: Key, modifiers: Modifiers) -> Option<Action> {
    if modifiers.alt {
        return None;
    }
    let pressed = Shortcut { command: modifiers.command, shift: modifiers.shift, key };
    // Where `?` needs Shift, it is one key nevertheless.
    let is = |shortcut: &Shortcut| {
        *shortcut == Shortcut { shift: pressed.shift && key != Key::Questionmark, ..pressed }
    };
    if let (Some(index), false) = (DIGITS.iter().position(|digit| *digit == key), pressed.shift) {
        let number = index as u8 + 1;
        return Some(if pressed.command { Action::SetBookmark(number) } else { Action::Bookmark(number) });
    }
    TABLE.iter().find_map(|row| match row.input {
        Input::Press(action, shortcuts) => shortcuts.iter().any(is).then_some(action),
        _ => None,
    })
}

/// Whether an action is asked for even while the user is typing.
fn heeds(action: Action, key: Key) -> bool {
    let is_function_key = matches!(key, Key::F1 | Key::F2 | Key::F5 | Key::F11 | Key::F12);
    let has_command = !matches!(action, Action::Undo | Action::Redo)
        && TABLE.iter().any(|row| match row.input {
            Input::Press(other, shortcuts) => {
                other == action && shortcuts.iter().any(|shortcut| shortcut.command && shortcut.key == key)
            }
            _ => false,
        });
    is_function_key || has_command
}

/// Whether a motion's key is held. With Ctrl or Alt none is: those are shortcuts.
pub fn held(input: &InputState, motion: Motion) -> bool {
    if input.modifiers.command || input.modifiers.alt {
        return false;
    }
    if motion == Motion::Fast {
        return input.modifiers.shift;
    }
    TABLE.iter().any(|row| match row.input {
        Input::Hold(other, keys) => other == motion && keys.iter().any(|key| input.key_down(*key)),
        _ => false,
    })
}

/// From −1 to 1: what two opposite keys make together.
pub fn axis(input: &InputState, back: Motion, forth: Motion) -> f32 {
    let held = |motion| if held(input, motion) { 1.0 } else { 0.0 };
    held(forth) - held(back)
}

impl Row {
    /// The keys as people write them.
    pub fn keys(&self) -> String {
        match self.input {
            Input::Press(_, shortcuts) => {
                shortcuts.iter().map(Shortcut::name).collect::<Vec<_>>().join(" or ")
            }
            Input::Hold(Motion::Fast, _) => "Shift".into(),
            Input::Hold(_, keys) => keys.iter().map(|key| name(*key)).collect::<Vec<_>>().join(" or "),
            Input::Mouse(what) => what.into(),
        }
    }
}

impl Shortcut {
    pub fn name(&self) -> String {
        let command = if cfg!(target_os = "macos") { "⌘" } else { "Ctrl+" };
        let modifiers = [(self.command, command), (self.shift, "Shift+")];
        let held: String = modifiers.into_iter().filter(|(held, _)| *held).map(|(_, name)| name).collect();
        held + name(self.key)
    }
}

fn name(key: Key) -> &'static str {
    match key {
        Key::ArrowLeft => "←",
        Key::ArrowRight => "→",
        Key::ArrowUp => "↑",
        Key::ArrowDown => "↓",
        Key::Questionmark => "?",
        Key::Period => ".",
        key => key.name(),
    }
}

/// The first shortcut of an action, for a menu.
pub fn shortcut(action: Action) -> Option<String> {
    // Of places the table has the first.
    if let Action::SetBookmark(number) = action {
        return DIGITS.get(usize::from(number).checked_sub(1)?).map(|digit| command(*digit).name());
    }
    TABLE.iter().find_map(|row| match row.input {
        Input::Press(other, shortcuts) if other == action => shortcuts.first().map(Shortcut::name),
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{Context, RawInput};
    use std::collections::HashSet;

    fn pressed(key: Key, modifiers: Modifiers, typing: bool) -> Vec<Action> {
        let context = Context::default();
        let event = |pressed| Event::Key { key, physical_key: None, pressed, repeat: false, modifiers };
        let input = RawInput { events: vec![event(true), event(false)], ..RawInput::default() };
        let mut actions = Vec::new();
        let _ = context.run_ui(input, |ui| actions = ui.input(|input| of(input, typing).collect()));
        actions
    }

    const SHIFT_COMMAND: Modifiers = Modifiers { shift: true, ..Modifiers::COMMAND };

    #[test]
    fn no_key_does_two_things() {
        let mut seen = HashSet::new();
        for row in TABLE {
            let keys: Vec<(bool, bool, Key)> = match row.input {
                Input::Press(_, shortcuts) => shortcuts
                    .iter()
                    .map(|shortcut| (shortcut.command, shortcut.shift, shortcut.key))
                    .collect(),
                Input::Hold(_, keys) => keys.iter().map(|key| (false, false, *key)).collect(),
                Input::Mouse(_) => Vec::new(),
            };
            keys.into_iter().for_each(|key| assert!(seen.insert(key), "{key:?}"));
            // egui makes its own events of these.
            assert!(![Key::X, Key::V].iter().any(|key| seen.contains(&(true, false, *key))));
            assert!(!seen.contains(&(true, false, Key::C)));
        }
    }

    #[test]
    fn shortcuts_ask_for_what_the_table_says() {
        for row in TABLE {
            let Input::Press(action, shortcuts) = row.input else { continue };
            for shortcut in shortcuts {
                let modifiers = match (shortcut.command, shortcut.shift) {
                    (false, false) => Modifiers::NONE,
                    (true, false) => Modifiers::COMMAND,
                    (false, true) => Modifiers::SHIFT,
                    (true, true) => SHIFT_COMMAND,
                };
                assert_eq!(pressed(shortcut.key, modifiers, false), [action], "{}", shortcut.name());
            }
        }
        assert_eq!(pressed(Key::Num7, Modifiers::NONE, false), [Action::Bookmark(7)]);
        assert_eq!(pressed(Key::Num3, Modifiers::COMMAND, false), [Action::SetBookmark(3)]);
        assert!(pressed(Key::P, Modifiers::COMMAND, false).is_empty());
    }

    #[test]
    fn every_place_has_its_key() {
        let names = [1, 9].map(|number| shortcut(Action::SetBookmark(number)));
        assert!(
            names
                .iter()
                .zip(["1", "9"])
                .all(|(name, key)| name.as_ref().is_some_and(|name| name.ends_with(key)))
        );
        assert_eq!([0, 10].map(|number| shortcut(Action::SetBookmark(number))), [None, None]);
    }

    #[test]
    fn who_types_keeps_his_keys() {
        for key in [Key::P, Key::F, Key::Num1, Key::Enter, Key::Backspace, Key::Home, Key::Period] {
            assert!(pressed(key, Modifiers::NONE, true).is_empty(), "{key:?}");
        }
        assert!(pressed(Key::Z, Modifiers::COMMAND, true).is_empty());
        assert_eq!(pressed(Key::S, Modifiers::COMMAND, true), [Action::Save]);
        assert_eq!(pressed(Key::F1, Modifiers::NONE, true), [Action::TogglePanels]);
    }

    #[test]
    fn opposite_keys_cancel() {
        let context = Context::default();
        let event = |key| Event::Key {
            key,
            physical_key: None,
            pressed: true,
            repeat: false,
            modifiers: Modifiers::NONE,
        };
        let forth = |events: Vec<Event>| {
            let mut axis_value = 0.0;
            let input = RawInput { events, focused: true, ..RawInput::default() };
            let _ = context.run_ui(input, |ui| {
                axis_value = ui.input(|input| axis(input, Motion::Back, Motion::Forward))
            });
            axis_value
        };
        assert_eq!(forth(vec![event(Key::W)]), 1.0);
        assert_eq!(forth(vec![event(Key::S)]), 0.0);
    }
}
