//! Readers of files against damaged files: what is sound is damaged at random, over and over, and read, in a process with
//! little memory. No reader may panic, abort, take more memory than 512 MiB or longer than some seconds.
//!
//! Files that lead to an outcome that none had before are damaged further, so that damage adds up.
//! `TERRANE_FUZZ_SECONDS` is how long each kind of file is tried; `TERRANE_FUZZ_SEED` begins elsewhere. Files that broke
//! something are kept, and the message says where and how to read them again.

mod mutate;
mod targets;

use mutate::{Random, damage, seal};
use std::collections::HashSet;
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use targets::{Outcome, TARGETS, Target};

/// Files with their names, the one to read first.
pub type Files = Vec<(String, Vec<u8>)>;

/// Address space of a process, KiB: 512 MiB, and as much as the test itself takes before it reads anything.
const LIMIT: u64 = (512 + 32) << 10;

/// What no file may take longer than. Not a measurement: hours are what this is about.
const LONGEST: Duration = Duration::from_secs(20);

/// Files that are damaged further.
const MOST_KEPT: usize = 4000;

fn fuzz_one_kind(name: &str) {
    let seconds = number("TERRANE_FUZZ_SECONDS").unwrap_or(5);
    let folder = tempfile::tempdir_in(memory()).unwrap();
    let mut command = child(name, folder.path());
    command.env("TERRANE_FUZZ_SECONDS", seconds.to_string()).stdout(Stdio::piped());
    let mut running = command.spawn().unwrap();
    let patience = Duration::from_secs(seconds) + 3 * LONGEST;
    let start = Instant::now();
    let status = loop {
        if let Some(status) = running.try_wait().unwrap() {
            break Some(status);
        }
        if start.elapsed() > patience {
            running.kill().unwrap();
            running.wait().unwrap();
            break None;
        }
        std::thread::sleep(Duration::from_millis(50));
    };
    let told = std::io::read_to_string(running.stdout.take().unwrap()).unwrap();
    if let Some(line) = told.lines().find(|line| line.contains("files were tried")) {
        println!("{line}");
    }
    if status.is_some_and(|status| status.success()) {
        return;
    }
    let kept = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("fuzz-{name}"));
    let _ = fs::remove_dir_all(&kept);
    fs::create_dir_all(&kept).unwrap();
    let packed = fs::read(folder.path().join(LAST)).unwrap_or_default();
    for (name, bytes) in unpack(&packed) {
        fs::write(kept.join(name.replace('/', "_")), bytes).unwrap();
    }
    fs::write(kept.join(LAST), packed).unwrap();
    let why = match status {
        None => "it never ended".into(),
        Some(status) => match status.signal() {
            Some(signal) => format!("signal {signal}: no memory, or no stack"),
            None => format!("{status}"),
        },
    };
    panic!(
        "{name}: {why}\n{told}\nThe files are in {}; TERRANE_FUZZ={name} TERRANE_FUZZ_FILE={} reads them again.",
        kept.display(),
        kept.join(LAST).display()
    );
}

#[test]
fn fuzz_grammars() {
    fuzz_one_kind("grammars");
}

#[test]
fn fuzz_worlds() {
    fuzz_one_kind("worlds");
}

#[test]
fn fuzz_species() {
    fuzz_one_kind("species");
}

#[test]
fn fuzz_folders() {
    fuzz_one_kind("folders");
}

#[test]
fn fuzz_models() {
    fuzz_one_kind("models");
}

#[test]
fn fuzz_maps() {
    fuzz_one_kind("maps");
}

/// Damage to what was refused before would find little.
#[test]
fn the_files_to_begin_with_are_sound() {
    for target in TARGETS {
        let folder = tempfile::tempdir().unwrap();
        for files in (target.corpus)(folder.path()) {
            // Large words pass the little that is allowed here; the worlds have some that are wrong.
            if let Err(error) = (target.read)(folder.path(), &files)
                && !error.contains("are allowed")
                && target.name != "worlds"
            {
                panic!("{}, {}: {error}", target.name, files[0].0);
            }
        }
    }
}

/// A fuzzer that lets everything pass would be no good.
#[test]
fn a_reader_that_panics_hangs_or_takes_memory_is_found_out() {
    for (how, signal) in [("panic", None), ("memory", Some(6)), ("stack", Some(6))] {
        let folder = tempfile::tempdir_in(memory()).unwrap();
        let status = child(how, folder.path()).stdout(Stdio::null()).stderr(Stdio::null()).status().unwrap();
        assert_eq!((status.success(), status.signal()), (false, signal), "{how}");
    }
}

/// This test, as a process of its own with little memory, reading files of this kind.
fn child(name: &str, folder: &Path) -> Command {
    let mut command = Command::new("sh");
    command
        .args([
            "-c",
            &format!("ulimit -v {LIMIT} && exec \"$0\" fuzz::the_loop --exact --nocapture --test-threads 1"),
        ])
        .arg(std::env::current_exe().unwrap())
        .env("TERRANE_FUZZ", name)
        .env("TERRANE_FUZZ_FOLDER", folder)
        // One pool of threads would take address space for each.
        .env("RAYON_NUM_THREADS", "1")
        .env("RUST_BACKTRACE", "1");
    command
}

const LAST: &str = "last";

/// What runs in the process; nothing where nobody asks for it.
#[test]
fn the_loop() {
    let Ok(name) = std::env::var("TERRANE_FUZZ") else { return };
    match name.as_str() {
        "panic" => panic!("as asked for"),
        "memory" => drop(std::hint::black_box(vec![1_u8; 600 << 20])),
        "stack" => println!("{}", endless(1)),
        _ => {
            let target = TARGETS.iter().find(|target| target.name == name).unwrap();
            match std::env::var_os("TERRANE_FUZZ_FILE") {
                Some(file) => {
                    let folder = tempfile::tempdir().unwrap();
                    println!("{:?}", (target.read)(folder.path(), &unpack(&fs::read(file).unwrap())));
                }
                None => attack(target, Path::new(&std::env::var_os("TERRANE_FUZZ_FOLDER").unwrap())),
            }
        }
    }
}

#[allow(unconditional_recursion)]
fn endless(depth: u64) -> u64 {
    endless(std::hint::black_box(depth) + 1) + depth
}

fn attack(target: &Target, folder: &Path) {
    let area = folder.join("files");
    fs::create_dir(&area).unwrap();
    let time = Duration::from_secs(number("TERRANE_FUZZ_SECONDS").unwrap());
    let mut random = Random(number("TERRANE_FUZZ_SEED").unwrap_or(1));
    let mut corpus = (target.corpus)(&area);
    assert!(!corpus.is_empty());
    let mut outcomes: HashSet<String> =
        corpus.iter().map(|files| kind(&(target.read)(&area, files))).collect();
    let sound = corpus.len();

    let start = Instant::now();
    let (mut count, mut slowest) = (0_u64, Duration::ZERO);
    while start.elapsed() < time {
        let files = random.one(&corpus).clone();
        let mut files = damage(&mut random, &files, &corpus[..sound], target.words);
        if random.below(4) > 0 {
            files.iter_mut().for_each(|(name, bytes)| seal(name, bytes));
        }
        fs::write(folder.join(LAST), pack(&files)).unwrap();
        let begun = Instant::now();
        let outcome = kind(&(target.read)(&area, &files));
        let taken = begun.elapsed();
        assert!(taken < LONGEST, "{taken:?} for one file");
        slowest = slowest.max(taken);
        if corpus.len() < MOST_KEPT && outcomes.insert(outcome) {
            corpus.push(files);
        }
        count += 1;
    }
    println!(
        "{}: {count} files were tried, {} outcomes, {} ms for the slowest",
        target.name,
        outcomes.len(),
        slowest.as_millis()
    );
}

/// A message without what differs from file to file: what is quoted, numbers, the lines that show the text.
fn kind(outcome: &Outcome) -> String {
    let (Ok(message) | Err(message)) = outcome;
    let lines = message.lines().filter(|line| !line.contains('|') && !line.contains("-->"));
    let mut kind = String::new();
    for line in lines {
        let unquoted = line.split('`').step_by(2).collect::<Vec<_>>().join("`");
        kind.extend(unquoted.chars().filter(|letter| !letter.is_ascii_digit()).take(200));
    }
    kind.truncate(kind.char_indices().nth(300).map_or(kind.len(), |(at, _)| at));
    kind
}

fn number(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.parse().ok()
}

/// A folder in memory, if the machine has one.
fn memory() -> PathBuf {
    let shared = PathBuf::from("/dev/shm");
    if shared.is_dir() { shared } else { std::env::temp_dir() }
}

/// Files as one.
fn pack(files: &Files) -> Vec<u8> {
    let parts = files.iter().map(|(name, bytes)| {
        let lengths = [name.len(), bytes.len()].map(|length| (length as u32).to_le_bytes());
        [lengths.as_flattened(), name.as_bytes(), bytes].concat()
    });
    parts.collect::<Vec<_>>().concat()
}

fn unpack(mut packed: &[u8]) -> Files {
    let mut files = Files::new();
    while let Some((lengths, rest)) = packed.split_first_chunk::<8>() {
        let [name, bytes] =
            [0, 4].map(|at| u32::from_le_bytes(lengths[at..at + 4].try_into().unwrap()) as usize);
        files.push((String::from_utf8_lossy(&rest[..name]).into(), rest[name..name + bytes].to_vec()));
        packed = &rest[name + bytes..];
    }
    files
}

pub fn one(name: &str, bytes: Vec<u8>) -> Files {
    vec![(name.to_owned(), bytes)]
}

/// ISO 3309, as PNG has it.
pub fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(
            crc ^ u32::from(byte),
            |crc, _| if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 },
        )
    })
}
