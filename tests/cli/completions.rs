//! What shells are offered, by the script of `relcp completions`.

use super::place::Place;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Completes command lines in bash: each line of the answer has the words that one of them is offered.
const ASK: &str = r#"
source <(relcp completions bash)
of=$(complete -p relcp | sed 's/.*-F \([^ ]*\).*/\1/')
while IFS= read -r line; do
    read -ra COMP_WORDS <<< "$line"
    [[ $line == *' ' ]] && COMP_WORDS+=('')
    COMP_CWORD=$(( ${#COMP_WORDS[@]} - 1 ))
    COMPREPLY=()
    "$of" relcp "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD - 1]}"
    echo "${COMPREPLY[*]}"
done
"#;

fn has_bash() -> bool {
    Command::new("bash").args(["-c", "true"]).status().is_ok_and(|status| status.success())
}

fn offered(folder: &Path, lines: &str) -> Vec<Vec<String>> {
    let program = assert_cmd::cargo::cargo_bin("relcp");
    let folders = [program.parent().unwrap().to_owned()].into_iter();
    let path = std::env::join_paths(folders.chain(std::env::split_paths(&std::env::var_os("PATH").unwrap()))).unwrap();
    let mut bash = assert_cmd::Command::new("bash");
    let ran = bash.current_dir(folder).args(["-c", ASK]).env("PATH", path).write_stdin(lines).output().unwrap();
    let err = String::from_utf8(ran.stderr).unwrap();
    assert!(ran.status.success() && err.is_empty(), "{err}");
    let words = |line: &str| line.split_whitespace().map(str::to_owned).collect();
    String::from_utf8(ran.stdout).unwrap().lines().map(words).collect()
}

#[test]
fn bash_is_offered_names_of_scenes_beside_files_and_folders() {
    if !has_bash() {
        println!("SKIP completions in bash: there is no bash");
        return;
    }
    let place = Place::new();
    fs::write(place.at("colony.json"), "{}").unwrap();
    fs::create_dir_all(place.at("colours/inner")).unwrap();
    for (line, yes, no) in [
        ("relcp run colo", &["colony", "colony-full", "colony.json", "colours/"][..], &["chainmail", "rods.json"][..]),
        ("relcp run ", &["three-capsules", "rods.json", "--resume"], &[]),
        ("relcp run --set time.end=1 three", &["three-capsules"], &["rods.json"]),
        ("relcp check rod", &["rods.json"], &["colony"]),
        ("relcp contacts col", &["colony", "colony.json", "colours/"], &[]),
        ("relcp export colou", &["colours/"], &["colony"]),
        ("relcp measure colo", &["colony", "colony.json", "colours/"], &[]),
        ("relcp render colours/", &["colours/inner/"], &["colony"]),
        ("relcp view three", &["three-capsules"], &[]),
        ("relcp scenes colo", &["colony"], &["colony.json", "colours/"]),
        ("relcp batch colo", &["colony.json"], &["colony"]),
        ("relcp run --out colo", &["colours/"], &["colony", "colony.json"]),
        ("relcp run --backend ", &["auto", "cpu", "gpu"], &["colony"]),
        ("relcp sche", &["schema"], &["scenes"]),
    ] {
        let [found] = &offered(place.0.path(), &format!("{line}\n"))[..] else { panic!("{line}") };
        let has = |word: &&&str| found.iter().any(|offered| offered == **word);
        assert!(yes.iter().all(|word| has(&word)) && !no.iter().any(|word| has(&word)), "{line}: {found:?}");
    }
}

#[test]
fn every_shell_has_a_script_that_asks_the_program() {
    let place = Place::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = place.relcp(&["completions", shell]).expect(0).out;
        assert!(script.contains("relcp") && script.contains("RELCP_COMPLETE"), "{shell}: {script}");
    }
    assert!(place.relcp(&["completions", "dos"]).expect(2).out.is_empty());
}
