//! A desktop that nobody sees: an X server, a window manager, and a hand at keyboard and mouse (Xvfb, openbox, xdotool).

use super::program;
use image::RgbImage;
use std::fs;
use std::io::{BufRead, BufReader};
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// The screen, with all that belongs to it.
pub struct Desktop {
    server: Child,
    manager: Child,
    display: String,
    folder: tempfile::TempDir,
}

/// The screen's size, pixels.
const SCREEN: [u32; 2] = [1280, 800];

/// How long anything may take. Shaders are compiled for minutes where that was never done.
const PATIENCE: Duration = Duration::from_secs(300);

impl Desktop {
    pub fn new() -> Desktop {
        let folder = tempfile::tempdir().expect("a folder");
        let screen = format!("{}x{}x24", SCREEN[0], SCREEN[1]);
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", &screen, "-nolisten", "tcp", "-noreset", "-fbdir"])
            .arg(folder.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb is installed (scripts/install.sh validation)");
        let mut number = String::new();
        let out = server.stdout.take().expect("it is piped");
        BufReader::new(out).read_line(&mut number).expect("the server tells its number");
        let display = format!(":{}", number.trim());
        let manager = Command::new("openbox")
            .env("DISPLAY", &display)
            .env("HOME", folder.path())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("openbox is installed (scripts/install.sh validation)");
        let desktop = Desktop { server, manager, display, folder };
        // A window that opens before the manager is there may never be shown.
        let begun = Instant::now();
        while !desktop.hand(&["get_num_desktops"]).status.success() {
            assert!(begun.elapsed() < PATIENCE, "openbox does not start");
            sleep(Duration::from_millis(20));
        }
        desktop
    }

    /// Starts the viewer with these arguments in a folder, and waits for its window.
    pub fn view(&self, folder: &Path, arguments: &[&str], environment: &[(&str, &str)]) -> Viewer<'_> {
        let mut command = program::command(folder, &["view"]);
        command.args(arguments).envs(environment.iter().copied());
        self.start(folder, command)
    }

    /// The same by a command of one's own.
    pub fn start(&self, folder: &Path, mut command: Command) -> Viewer<'_> {
        let widgets = folder.join("widgets.txt");
        // What another viewer has left there.
        let _ = fs::remove_file(&widgets);
        command.env("DISPLAY", &self.display).env_remove("WAYLAND_DISPLAY");
        command.env("TERRANE_STATE", folder.join("state")).env("TERRANE_WIDGETS", &widgets);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let child = command.spawn().expect("the program runs");
        let mut viewer = Viewer { desktop: self, child: Some(child), widgets, window: String::new() };
        viewer.window = viewer.wait_for_window();
        viewer
    }

    /// What is on the screen.
    pub fn screen(&self) -> RgbImage {
        let [width, height] = SCREEN;
        let rows = (0..height).flat_map(|y| self.row([0, y], width)).flatten().collect();
        RgbImage::from_raw(width, height, rows).expect("whole rows")
    }

    /// Pixels of the screen from a place to the right.
    pub fn row(&self, [x, y]: [u32; 2], width: u32) -> Vec<[u8; 3]> {
        let file = fs::File::open(self.folder.path().join("Xvfb_screen0")).expect("the server's screen");
        let read = |at: u64, bytes: usize| {
            let mut buffer = vec![0; bytes];
            file.read_exact_at(&mut buffer, at).expect("it is that long");
            buffer
        };
        // The header of an X window dump: numbers of 32 bits, the highest byte first.
        let header = read(0, 80);
        let field = |index: usize| {
            u32::from_be_bytes(header[4 * index..4 * index + 4].try_into().expect("four bytes"))
        };
        let [begin, line, colours] = [0, 12, 19].map(field);
        assert_eq!((field(7), field(11)), (0, 32), "the lowest byte first, 32 bits a pixel");
        let at = begin + 12 * colours + y * line + 4 * x;
        read(at.into(), 4 * width as usize).chunks_exact(4).map(|bgr| [bgr[2], bgr[1], bgr[0]]).collect()
    }

    fn hand(&self, words: &[&str]) -> Output {
        let done = Command::new("xdotool").args(words).env("DISPLAY", &self.display).output();
        done.expect("xdotool is installed (scripts/install.sh validation)")
    }
}

impl Drop for Desktop {
    fn drop(&mut self) {
        for child in [&mut self.manager, &mut self.server] {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// A viewer on the desktop.
pub struct Viewer<'a> {
    desktop: &'a Desktop,
    child: Option<Child>,
    widgets: PathBuf,
    window: String,
}

impl Viewer<'_> {
    #[track_caller]
    fn wait_for_window(&mut self) -> String {
        self.wait("a window", |viewer| {
            let found = viewer.desktop.hand(&["search", "--onlyvisible", "--name", "terrane"]);
            let text = String::from_utf8_lossy(&found.stdout).into_owned();
            text.lines().next().map(String::from).filter(|_| !viewer.shown().is_empty())
        })
    }

    /// Tries until there is something.
    #[track_caller]
    pub fn wait<T>(&mut self, what: &str, mut look: impl FnMut(&Self) -> Option<T>) -> T {
        let begun = Instant::now();
        loop {
            if let Some(found) = look(self) {
                return found;
            }
            let ended = self.child.as_mut().and_then(|child| child.try_wait().expect("it can be waited for"));
            if ended.is_some() || begun.elapsed() > PATIENCE {
                let shown = self.shown();
                let mut child = self.child.take().expect("it runs");
                let _ = child.kill();
                let output = child.wait_with_output().expect("it can be waited for");
                panic!("no {what}; shown was\n{shown}\n{}", program::stderr(&output));
            }
            sleep(Duration::from_millis(50));
        }
    }

    /// Everything that has a name, a line each: where it is and what it is called.
    pub fn shown(&self) -> String {
        fs::read_to_string(&self.widgets).unwrap_or_default()
    }

    /// Waits until something is shown whose name begins so.
    #[track_caller]
    pub fn see(&mut self, name: &str) {
        self.place(name);
    }

    /// Where that is, pixels.
    #[track_caller]
    pub fn place(&mut self, name: &str) -> [String; 2] {
        self.wait(name, |viewer| {
            let shown = viewer.shown();
            let named = || {
                shown.lines().filter_map(|line| {
                    let mut words = line.splitn(3, ' ');
                    let (x, y, found) = (words.next()?, words.next()?, words.next()?);
                    found.starts_with(name).then(|| (found, [x.into(), y.into()]))
                })
            };
            // One that is called so and nothing more, if there is one.
            let (_, place) = named().find(|(found, _)| *found == name).or_else(|| named().next())?;
            Some(place)
        })
    }

    /// Waits until nothing is shown any more whose name begins so.
    #[track_caller]
    pub fn see_no(&mut self, name: &str) {
        self.wait(&format!("end of {name}"), |viewer| {
            let is_there = viewer
                .shown()
                .lines()
                .any(|line| line.splitn(3, ' ').nth(2).is_some_and(|found| found.starts_with(name)));
            (!is_there).then_some(())
        });
    }

    /// Clicks on what has a name that begins so.
    #[track_caller]
    pub fn push(&mut self, name: &str) {
        let mut places = vec![self.place(name)];
        // Windows find their place in their first frames.
        while places.len() < 3 {
            sleep(Duration::from_millis(200));
            let place = self.place(name);
            if places.last() != Some(&place) {
                places.clear();
            }
            places.push(place);
        }
        self.click(&places[0]);
    }

    /// Writes something into what has a name that begins so.
    #[track_caller]
    pub fn enter(&mut self, name: &str, text: &str) {
        self.push(name);
        sleep(Duration::from_millis(600));
        self.key("ctrl+a");
        self.type_in(text);
        self.key("Return");
    }

    /// Clicks at a place, and waits for a few frames: what was clicked takes keys from the next one on.
    pub fn click(&self, [x, y]: &[String; 2]) {
        self.hand(&["mousemove", "--window", &self.window, x, y, "click", "1"]);
        sleep(Duration::from_millis(400));
    }

    /// Presses keys, `ctrl+z` for example.
    pub fn key(&self, key: &str) {
        self.hand(&["key", "--clearmodifiers", key]);
    }

    /// The same of a viewer that may end meanwhile.
    pub fn press(&self, key: &str) {
        self.desktop.hand(&["key", key]);
    }

    /// Holds a key down for a while.
    pub fn hold(&self, key: &str, time: Duration) {
        self.hand(&["keydown", key]);
        sleep(time);
        self.hand(&["keyup", key]);
    }

    pub fn type_in(&self, text: &str) {
        self.hand(&["type", "--delay", "20", text]);
    }

    /// Drags from one place of the window to another, pixels.
    pub fn drag(&self, [from_x, from_y]: [u32; 2], [to_x, to_y]: [u32; 2], button: &str) {
        self.take([from_x, from_y], button);
        for step in 1..=10 {
            let between = |from: u32, to: u32| (from * (10 - step) + to * step) / 10;
            self.point([between(from_x, to_x), between(from_y, to_y)]);
            // No hand is so fast that all of it happens between two frames.
            sleep(Duration::from_millis(30));
        }
        self.hand(&["mouseup", button]);
    }

    /// Presses a button of the mouse at a place of the window, pixels, and holds it.
    pub fn take(&self, at: [u32; 2], button: &str) {
        self.point(at);
        self.hand(&["mousedown", button]);
    }

    /// Moves the mouse to a place of the window, pixels.
    pub fn point(&self, at: [u32; 2]) {
        let [x, y] = at.map(|side| side.to_string());
        self.hand(&["mousemove", "--window", &self.window, &x, &y]);
    }

    /// Turns the wheel at a place.
    pub fn wheel(&self, [x, y]: [u32; 2], up: bool) {
        let (x, y) = (x.to_string(), y.to_string());
        self.hand(&["mousemove", "--window", &self.window, &x, &y, "click", if up { "4" } else { "5" }]);
    }

    pub fn resize(&self, [width, height]: [u32; 2]) {
        self.hand(&["windowsize", &self.window, &width.to_string(), &height.to_string()]);
    }

    /// Where its inside begins on the screen, pixels.
    pub fn origin(&self) -> [u32; 2] {
        let told = self.desktop.hand(&["getwindowgeometry", "--shell", &self.window]);
        let told = String::from_utf8_lossy(&told.stdout);
        ["X=", "Y="].map(|name| {
            let line = told.lines().find_map(|line| line.strip_prefix(name)).expect("it is told");
            line.parse().expect("a place on the screen")
        })
    }

    pub fn minimise(&self) {
        self.hand(&["windowminimize", &self.window]);
    }

    pub fn restore(&self) {
        self.hand(&["windowmap", &self.window, "windowactivate", "--sync", &self.window]);
    }

    /// Memory of its process, KiB.
    pub fn resident(&self) -> u64 {
        let id = self.child.as_ref().expect("it runs").id();
        let status = fs::read_to_string(format!("/proc/{id}/status")).expect("it runs");
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).expect("it is told");
        line.trim().trim_end_matches("kB").trim().parse().expect("a number")
    }

    pub fn is_running(&mut self) -> bool {
        self.child.as_mut().is_some_and(|child| child.try_wait().expect("it can be waited for").is_none())
    }

    /// Time that its process has spent on processors.
    pub fn spent(&self) -> Duration {
        let id = self.child.as_ref().expect("it runs").id();
        let stat = fs::read_to_string(format!("/proc/{id}/stat")).expect("it runs");
        let (_, fields) = stat.rsplit_once(')').expect("the name ends there");
        // After its name: user and system time, hundredths of a second.
        let ticks =
            fields.split_whitespace().skip(11).take(2).map(|field| field.parse::<u64>().expect("a number"));
        Duration::from_millis(10 * ticks.sum::<u64>())
    }

    /// Waits until it has ended.
    #[track_caller]
    pub fn end(mut self) -> Output {
        let begun = Instant::now();
        let mut child = self.child.take().expect("it runs");
        while child.try_wait().expect("it can be waited for").is_none() {
            if begun.elapsed() > PATIENCE {
                let _ = child.kill();
                let output = child.wait_with_output().expect("it can be waited for");
                panic!("it does not end: {}", program::stderr(&output));
            }
            sleep(Duration::from_millis(20));
        }
        child.wait_with_output().expect("it can be waited for")
    }

    /// Asks its process to end.
    pub fn terminate(&self) {
        let id = self.child.as_ref().expect("it runs").id().to_string();
        let told = Command::new("kill").args(["-TERM", &id]).status();
        assert!(told.expect("kill is there").success());
    }

    /// Ends it as a crash would.
    pub fn kill(mut self) {
        if let Some(mut child) = self.child.take() {
            let _ = child.kill();
            let _ = child.wait();
        }
    }

    fn hand(&self, words: &[&str]) {
        let output = self.desktop.hand(words);
        assert!(output.status.success(), "xdotool {words:?}: {}", program::stderr(&output));
    }
}

impl Drop for Viewer<'_> {
    fn drop(&mut self) {
        if let Some(mut child) = self.child.take() {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}
