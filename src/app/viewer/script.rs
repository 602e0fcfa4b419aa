//! Scripts: keys, mouse, waits and screenshots from a text file, one a line.

use super::desk::Wish;
use crate::app::Error;
use crate::formats;
use egui::{Event, Key, Modifiers, MouseWheelUnit, PointerButton, Pos2, RawInput, TouchPhase, Vec2};
use std::collections::VecDeque;
use std::path::{Path, PathBuf};

/// What a script does, in order.
#[derive(Clone, Debug, PartialEq)]
pub struct Script(Vec<Act>);

#[derive(Clone, Debug, PartialEq)]
enum Act {
    /// So many frames.
    Wait(u64),
    /// Until the world has nothing left to do, at most so many frames.
    Quiet(u64),
    Press(Key, Modifiers),
    Release(Key, Modifiers),
    Move(Pos2),
    /// Moves to what has this name.
    Find(String),
    Button(PointerButton, bool),
    Wheel(f32),
    Type(String),
    Wish(Wish),
}

/// Longer files are no scripts.
const MOST_BYTES: usize = 1 << 20;

/// Frames that a `wait quiet` without a number waits at most.
const LONG: u64 = 100_000;

/// Frames that are waited for what is to be pushed.
const PATIENCE: u64 = 3000;

/// Frames that a `wait quiet` draws at once: news of what was done just before may be on their way.
const PROMPT: u64 = 3;

/// Frames that a drag takes.
const DRAG: u32 = 8;

impl Script {
    /// # Errors
    /// A file that can't be read, or a line that says nothing known, with its number.
    pub fn read(path: &Path) -> Result<Script, Error> {
        let bytes = formats::read_bytes(path, MOST_BYTES)?;
        let text = String::from_utf8_lossy(&bytes);
        Script::parse(&text).map_err(|(line, why)| {
            Error::Usage(format!(
                "{}, line {line}: {why}; docs/viewer.md tells what may stand there",
                path.display()
            ))
        })
    }

    /// Whether anything is found by its name.
    pub fn has_names(&self) -> bool {
        self.0.iter().any(|act| matches!(act, Act::Find(_)))
    }

    fn parse(text: &str) -> Result<Script, (usize, String)> {
        let mut acts = Vec::new();
        for (index, line) in text.lines().enumerate() {
            let line = line.split_once('#').map_or(line, |(line, _)| line).trim();
            if !line.is_empty() {
                acts.extend(parse_line(line).map_err(|why| (index + 1, why))?);
            }
        }
        Ok(Script(acts))
    }
}

fn parse_line(line: &str) -> Result<Vec<Act>, String> {
    let (verb, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    let rest = rest.trim();
    let words: Vec<&str> = rest.split_whitespace().collect();
    let acts = match (verb, words.as_slice()) {
        ("wait", ["quiet"]) => vec![Act::Quiet(LONG)],
        ("wait", ["quiet", most]) => vec![Act::Quiet(number(most)?)],
        ("wait", [frames]) => vec![Act::Wait(number(frames)?)],
        ("key", [key]) => {
            let (key, modifiers) = self::key(key)?;
            vec![Act::Press(key, modifiers), Act::Release(key, modifiers)]
        }
        ("press", [key]) => vec![self::key(key).map(|(key, modifiers)| Act::Press(key, modifiers))?],
        ("release", [key]) => vec![self::key(key).map(|(key, modifiers)| Act::Release(key, modifiers))?],
        ("move", [x, y]) => vec![Act::Move(point(x, y)?)],
        ("click", [x, y, button @ ..]) => {
            let (at, button) = (point(x, y)?, self::button(button)?);
            vec![Act::Move(at), Act::Button(button, true), Act::Button(button, false)]
        }
        ("drag", [x, y, to_x, to_y, button @ ..]) => {
            let (from, to, button) = (point(x, y)?, point(to_x, to_y)?, self::button(button)?);
            let way = |step| Act::Move(from + (to - from) * (step as f32 / DRAG as f32));
            let mut acts = vec![Act::Move(from), Act::Button(button, true)];
            acts.extend((1..=DRAG).map(way));
            acts.push(Act::Button(button, false));
            acts
        }
        ("push", [_, ..]) => {
            let primary = PointerButton::Primary;
            vec![Act::Find(rest.into()), Act::Button(primary, true), Act::Button(primary, false)]
        }
        ("wheel", [by]) => vec![Act::Wheel(number(by)?)],
        ("type", [_, ..]) => vec![Act::Type(rest.into())],
        ("screenshot", [_, ..]) => vec![Act::Wish(Wish::Screenshot(PathBuf::from(rest)))],
        ("resize", [width, height]) => vec![Act::Wish(Wish::Resize([number(width)?, number(height)?]))],
        ("fullscreen", []) => vec![Act::Wish(Wish::FullScreen)],
        ("open", [_, ..]) => vec![Act::Wish(Wish::Open(PathBuf::from(rest)))],
        ("quit", []) => vec![Act::Wish(Wish::Close)],
        _ => return Err(format!("`{line}` is no act")),
    };
    Ok(acts)
}

fn number<T: std::str::FromStr>(word: &str) -> Result<T, String> {
    word.parse().map_err(|_| format!("`{word}` is no number that can stand here"))
}

fn point(x: &str, y: &str) -> Result<Pos2, String> {
    Ok(Pos2::new(number(x)?, number(y)?))
}

fn button(words: &[&str]) -> Result<PointerButton, String> {
    match words {
        [] | ["left"] => Ok(PointerButton::Primary),
        ["right"] => Ok(PointerButton::Secondary),
        ["middle"] => Ok(PointerButton::Middle),
        _ => Err("the button is left, right or middle".into()),
    }
}

/// `W`, `Space`, `ctrl+Z`, `ctrl+shift+S`.
fn key(text: &str) -> Result<(Key, Modifiers), String> {
    let mut modifiers = Modifiers::NONE;
    let mut parts: Vec<&str> = text.split('+').collect();
    let name = parts.pop().unwrap_or_default();
    for part in parts {
        modifiers |= match part {
            "ctrl" => Modifiers::CTRL | Modifiers::COMMAND,
            "shift" => Modifiers::SHIFT,
            "alt" => Modifiers::ALT,
            _ => return Err(format!("`{part}` is none of ctrl, shift and alt")),
        };
    }
    let key = Key::from_name(name).ok_or_else(|| format!("`{name}` is no key"))?;
    Ok((key, modifiers))
}

/// A script on its way.
pub struct Player {
    acts: VecDeque<Act>,
    pointer: Pos2,
    /// Frames of the wait under way.
    waited: u64,
    time: f64,
}

impl Player {
    pub fn new(Script(acts): Script) -> Player {
        Player { acts: acts.into(), pointer: Pos2::ZERO, waited: 0, time: 0.0 }
    }

    pub fn is_done(&self) -> bool {
        self.acts.is_empty()
    }

    /// Whether it waits for the world, which frames that show nothing new would only hold up.
    pub fn is_patient(&self) -> bool {
        matches!(self.acts.front(), Some(Act::Quiet(_))) && self.waited >= PROMPT
    }

    /// Adds the next act to the input of a frame. `quiet` tells whether the world has nothing left to do, `find` where something is.
    ///
    /// # Errors
    /// If something is to be pushed that is not there.
    pub fn play(
        &mut self,
        input: &mut RawInput,
        quiet: bool,
        find: impl Fn(&str) -> Option<Pos2>,
    ) -> Result<Vec<Wish>, Error> {
        input.focused = true;
        self.time = input.time.unwrap_or(self.time);
        let Some(act) = self.acts.front() else { return Ok(Vec::new()) };
        let (mut wishes, mut done) = (Vec::new(), true);
        match act {
            Act::Wait(frames) => {
                self.waited += 1;
                done = self.waited >= *frames;
            }
            Act::Quiet(most) => {
                self.waited += 1;
                done = quiet && self.waited > PROMPT || self.waited >= *most;
            }
            Act::Press(key, modifiers) => self.key(input, *key, *modifiers, true),
            Act::Release(key, modifiers) => self.key(input, *key, *modifiers, false),
            Act::Move(to) => {
                let by = *to - self.pointer;
                input.events.push(Event::PointerMoved(*to));
                input.events.push(Event::MouseMoved(by));
                self.pointer = *to;
            }
            Act::Find(name) => match find(name) {
                Some(at) => {
                    input.events.push(Event::PointerMoved(at));
                    self.pointer = at;
                }
                None => {
                    self.waited += 1;
                    done = false;
                    if self.waited >= PATIENCE {
                        return Err(Error::Usage(format!(
                            "the script pushes `{name}`, and nothing of that name is shown"
                        )));
                    }
                }
            },
            Act::Button(button, pressed) => input.events.push(Event::PointerButton {
                pos: self.pointer,
                button: *button,
                pressed: *pressed,
                modifiers: Modifiers::NONE,
            }),
            Act::Wheel(by) => input.events.push(Event::MouseWheel {
                unit: MouseWheelUnit::Line,
                delta: Vec2::new(0.0, *by),
                phase: TouchPhase::Move,
                modifiers: Modifiers::NONE,
            }),
            Act::Type(text) => input.events.push(Event::Text(text.clone())),
            Act::Wish(wish) => wishes.push(wish.clone()),
        }
        if done {
            self.acts.pop_front();
            self.waited = 0;
        }
        Ok(wishes)
    }

    fn key(&self, input: &mut RawInput, key: Key, modifiers: Modifiers, pressed: bool) {
        input.events.push(Event::ModifiersChanged(if pressed { modifiers } else { Modifiers::NONE }));
        input.events.push(Event::Key { key, physical_key: Some(key), pressed, repeat: false, modifiers });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_become_acts() {
        let script = Script::parse(
            "wait 3\n# nothing\nkey ctrl+Z\n  click 10 20 right  # there\nscreenshot a b.png\n",
        );
        let undo = Modifiers::CTRL | Modifiers::COMMAND;
        let expected = vec![
            Act::Wait(3),
            Act::Press(Key::Z, undo),
            Act::Release(Key::Z, undo),
            Act::Move(Pos2::new(10.0, 20.0)),
            Act::Button(PointerButton::Secondary, true),
            Act::Button(PointerButton::Secondary, false),
            Act::Wish(Wish::Screenshot("a b.png".into())),
        ];
        assert_eq!(script, Ok(Script(expected)));
    }

    /// How often a script is patient in so many frames of a world that is not quiet.
    fn patient(text: &str, frames: usize) -> Vec<bool> {
        let mut player = Player::new(Script::parse(text).expect("a script"));
        let frame = |_| {
            player.play(&mut RawInput::default(), false, |_| None).expect("nothing to be found");
            player.is_patient()
        };
        (0..frames).map(frame).collect()
    }

    #[test]
    fn frames_are_saved_while_the_world_is_waited_for() {
        assert_eq!(patient("wait quiet 7", 7), [false, false, true, true, true, true, false]);
        assert_eq!(patient("wait 7", 7), [false; 7], "every frame is asked for");
        assert_eq!(patient("key W\nwait quiet", 6)[..4], [false, false, false, false], "keys do not wait");
    }

    #[test]
    fn what_is_no_act_is_told_with_its_line() {
        for wrong in [
            "jump",
            "wait",
            "wait -1",
            "key Q Q",
            "key ctrl+Nothing",
            "click 1",
            "click 1 2 left right",
            "move a b",
            "type",
        ] {
            let text = format!("wait 1\n{wrong}\n");
            assert!(matches!(Script::parse(&text), Err((2, _))), "{wrong}");
        }
    }
}
