//! What the program tells of itself: schema, completions, manual, help. None of it asks for a device.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

const SHELLS: [&str; 5] = ["bash", "zsh", "fish", "powershell", "elvish"];

/// Runs the program where there is no driver.
fn terrane(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_terrane"))
        .args(arguments)
        .envs([("VK_DRIVER_FILES", "/nonexistent.json"), ("VK_ICD_FILENAMES", "/nonexistent.json")])
        .output()
        .unwrap()
}

fn stdout(arguments: &[&str]) -> String {
    let output = terrane(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// The names of the verbs, as the help lists them.
fn verbs() -> Vec<String> {
    let help = stdout(&["--help"]);
    let list = help.split_once("Commands:\n").unwrap().1.split_once("\n\n").unwrap().0;
    // What goes on from the line above begins further right.
    let lines = list.lines().filter_map(|line| line.strip_prefix("  ")).filter(|line| !line.starts_with(' '));
    lines.map(|line| line.split(' ').next().unwrap().to_string()).filter(|verb| verb != "help").collect()
}

/// Feeds `script` to a program that reads it from standard input, if this machine has that program.
fn feed(program: &str, arguments: &[&str], script: &str) -> Option<Output> {
    let mut child = Command::new(program)
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .ok()?;
    child.stdin.take().unwrap().write_all(script.as_bytes()).unwrap();
    Some(child.wait_with_output().unwrap())
}

#[test]
fn the_schema_is_printed_or_written() {
    let committed = fs::read_to_string("configs/worlds.schema.json").unwrap();
    assert_eq!(stdout(&["schema"]), committed);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("worlds.schema.json");
    assert_eq!(stdout(&["schema", "-o", path.to_str().unwrap()]), "");
    assert_eq!(fs::read_to_string(&path).unwrap(), committed);
    assert_eq!(terrane(&["schema", "-o", "missing/a.json"]).status.code(), Some(7));
}

#[cfg(target_os = "linux")]
#[test]
fn what_does_not_reach_its_reader_whole_is_a_failure() {
    for arguments in [&["schema"][..], &["completions", "zsh"], &["man"]] {
        let full = fs::File::options().write(true).open("/dev/full").unwrap();
        let program = env!("CARGO_BIN_EXE_terrane");
        let output = Command::new(program).args(arguments).stdout(full).output().unwrap();
        assert_eq!(output.status.code(), Some(7), "{arguments:?}");
        assert!(String::from_utf8_lossy(&output.stderr).contains("standard output"), "{output:?}");
    }
}

#[test]
fn every_shell_gets_a_script_that_knows_the_verbs() {
    let verbs = verbs();
    assert!(verbs.len() >= 7, "{verbs:?}");
    for shell in SHELLS {
        let script = stdout(&["completions", shell]);
        for verb in &verbs {
            assert!(script.contains(verb.as_str()), "{shell} has no {verb}");
        }
        assert!(script.contains("memory-limit"), "{shell} has no options");
        // The scripts of the others complete no values.
        let values = ["bash", "zsh", "fish"].contains(&shell);
        assert!(!values || script.contains("wetness"), "{shell} has no layers");
    }
    assert_eq!(terrane(&["completions", "tcsh"]).status.code(), Some(2));
}

#[cfg(unix)]
#[test]
fn bash_completes_verbs_layers_and_worlds() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("volcano.toml"), "").unwrap();
    let script = stdout(&["completions", "bash"]);
    let Some(checked) = feed("bash", &["-n"], &script) else { return };
    assert!(checked.status.success() && checked.stderr.is_empty(), "{checked:?}");

    // What a press of the tabulator behind the last word offers.
    let offers = |line: &str| -> Vec<String> {
        let ask = format!(
            "{script}\ncd {:?}\nCOMP_WORDS=({line})\nCOMP_CWORD=$((${{#COMP_WORDS[@]}} - 1))\n\
             function=$(complete -p terrane | sed 's/.*-F \\([^ ]*\\).*/\\1/')\n\
             $function terrane \"${{COMP_WORDS[COMP_CWORD]}}\" \"${{COMP_WORDS[COMP_CWORD - 1]}}\"\n\
             printf '%s\\n' \"${{COMPREPLY[@]}}\"\n",
            folder.path()
        );
        let output = feed("bash", &["--norc", "-s"], &ask).unwrap();
        let offers = String::from_utf8(output.stdout).unwrap();
        offers.lines().filter(|line| !line.is_empty()).map(String::from).collect()
    };
    assert_eq!(offers("terrane rend"), ["render"]);
    assert_eq!(offers("terrane export --memory-l"), ["--memory-limit"]);
    assert_eq!(offers("terrane export --layer we"), ["wear", "wetness"]);
    // Where the script offers nothing, the shell offers files.
    assert!(script.contains("-o default terrane"), "{script}");
    assert_eq!(offers("terrane render volc"), [""; 0]);
    assert!(offers("terrane render -o volc").contains(&"volcano.toml".into()));
}

#[test]
fn every_verb_has_a_page() {
    let folder = tempfile::tempdir().unwrap();
    let pages = folder.path().join("man");
    stdout(&["man", "-o", pages.to_str().unwrap()]);
    let main = fs::read_to_string(pages.join("terrane.1")).unwrap();
    assert_eq!(main, stdout(&["man"]));
    for section in ["NAME", "SYNOPSIS", "EXIT STATUS", "ENVIRONMENT", "FILES", "EXAMPLES"] {
        assert!(
            main.contains(&format!(".SH {section}\n")) || main.contains(&format!(".SH \"{section}\"\n")),
            "{section}"
        );
    }
    for verb in verbs() {
        assert!(main.contains(&format!("terrane\\-{verb}(1)")), "{verb} is not in the list");
        let page = fs::read_to_string(pages.join(format!("terrane-{verb}.1"))).unwrap();
        assert!(page.contains(&format!("terrane {verb}")), "{page}");
    }
    assert_eq!(terrane(&["man", "-o", "missing/folder"]).status.code(), Some(7));

    for page in fs::read_dir(&pages).unwrap() {
        check_page(&page.unwrap().path());
    }
}

/// Every line begins with a known request or with text, and groff, where there is one, has nothing to complain of.
fn check_page(path: &Path) {
    let page = fs::read_to_string(path).unwrap();
    for line in page.lines().filter(|line| line.starts_with(['.', '\''])) {
        let request = line.split(' ').next().unwrap();
        let known =
            [".TH", ".SH", ".SS", ".TP", ".PP", ".IP", ".RS", ".RE", ".br", ".ie", ".el", ".nr", "'\\\""];
        assert!(known.iter().any(|known| request.starts_with(known)), "{}: {line}", path.display());
    }
    if let Some(shown) = feed("groff", &["-Kutf8", "-man", "-Tutf8", "-ww"], &page) {
        assert!(
            shown.status.success() && shown.stderr.is_empty(),
            "{}: {}",
            path.display(),
            String::from_utf8_lossy(&shown.stderr)
        );
        assert!(!shown.stdout.is_empty());
    }
}

/// The codes of the manual are those of the help.
#[test]
fn exit_codes_are_told() {
    let (help, main) = (stdout(&["--help"]), stdout(&["man"]));
    let words: Vec<&str> = help.split_once("Exit codes").unwrap().1.split_whitespace().collect();
    for code in ["0", "1", "2", "3", "4", "5", "6", "7", "130"] {
        assert!(main.contains(&format!("\n\\fB{code}\\fR\n")), "{code}");
        assert!(words.contains(&code), "{code}");
    }
}
