//! Where the eye is: remembered, gone back to, written down.

use super::Desk;
use crate::app::viewer::camera::{Rig, Written};
use crate::app::viewer::engine::{Command, Pose, WorldStatus};
use crate::app::viewer::keys::{self, Action};
use crate::app::viewer::state::{self, Bookmark};
use crate::world::KeyPath;

impl Desk {
    /// Where the eye is.
    pub(super) fn pose(&self) -> Option<Pose> {
        match &self.status.world {
            WorldStatus::None => None,
            WorldStatus::Land { rig, .. } => Some(Pose::Land(*rig)),
            WorldStatus::Zoom { code, .. } => Some(Pose::Zoom(code.clone())),
        }
    }

    fn bookmark_view(&self) -> Option<state::View> {
        Some(match self.pose()? {
            Pose::Land(rig) => state::View::Land {
                position: rig.eye.to_array(),
                target: (rig.eye + rig.forward() * 100.0).to_array(),
                roll: rig.roll,
            },
            Pose::Zoom(code) => state::View::Zoom { code },
        })
    }

    pub(super) fn remember(&mut self, name: String) {
        let (Some(view), Some(document)) = (self.bookmark_view(), &self.document) else { return };
        let source = document.source().to_path_buf();
        self.state.bookmark(&source, Bookmark { name: name.clone(), view });
        self.say(format!("remembered this place as {name}"));
    }

    /// Goes to the place of a number, or says how it gets one.
    pub(super) fn go_back_to(&mut self, number: u8) {
        let Some(document) = &self.document else { return };
        let name = number.to_string();
        if self.state.bookmarks(document.source()).iter().any(|bookmark| bookmark.name == name) {
            return self.go_back(&name);
        }
        let key = keys::shortcut(Action::SetBookmark(number)).unwrap_or_default();
        self.say(format!("no place {number} is remembered yet: {key} remembers this one"));
    }

    pub(super) fn go_back(&mut self, name: &str) {
        let Some(document) = &self.document else { return };
        let bookmark = self.state.bookmarks(document.source()).iter().find(|bookmark| bookmark.name == name);
        let pose = match bookmark.map(|bookmark| &bookmark.view) {
            Some(state::View::Land { position, target, roll }) => {
                Pose::Land(Rig::looking((*position).into(), (*target).into(), *roll))
            }
            Some(state::View::Zoom { code }) => Pose::Zoom(code.clone()),
            None => return,
        };
        self.engine.send(Command::GoTo(pose));
    }

    /// The key of the world's file that says where the eye is, and what it says.
    fn written_view(&self) -> Option<(KeyPath, toml_edit::Value)> {
        let rig = match self.pose()? {
            Pose::Land(rig) => rig,
            Pose::Zoom(code) => return Some((KeyPath::from("zoom.from"), code.into())),
        };
        let Written { position, target, roll } = rig.written();
        let mut look = toml_edit::InlineTable::new();
        look.insert("position", position.into_iter().collect::<toml_edit::Array>().into());
        look.insert("target", target.into_iter().collect::<toml_edit::Array>().into());
        if roll != 0.0 {
            look.insert("roll", roll.into());
        }
        let mut view = toml_edit::InlineTable::new();
        view.insert("look_at", look.into());
        Some((KeyPath::from("camera.view"), view.into()))
    }

    /// The command line that renders what is seen, if the world's file says what is shown.
    pub(super) fn command_line(&self) -> Option<String> {
        let document = self.document.as_ref()?;
        let world = quoted(&document.source().display().to_string());
        let name = quoted(&self.name("png"));
        let [width, height] = self.size;
        Some(match self.pose()? {
            Pose::Zoom(code) => {
                format!("terrane render {world} --from {code} --size {width}x{height} -o {name}")
            }
            Pose::Land(_) => {
                let (path, value) = self.written_view()?;
                let value = value.to_string();
                let is_traced = matches!(self.status.world, WorldStatus::Land { tracing: true, .. });
                let renderer = if is_traced { "trace" } else { "raster" };
                format!(
                    "terrane render {world} --set {} --renderer {renderer} --size {width}x{height} -o {name}",
                    quoted(&format!("{path}={}", value.trim()))
                )
            }
        })
    }

    pub(super) fn write_view(&mut self) {
        let Some((path, value)) = self.written_view() else { return };
        if let Some(document) = &mut self.document {
            document.settle();
            document.set(&path, value);
        }
    }
}

/// A word of a command line.
fn quoted(word: &str) -> String {
    format!("'{}'", word.replace('\'', "'\\''"))
}
