//! What README and the other pages promise: their commands do what they say, their links and pictures are there.

use super::place::Place;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// README and all pages that people write; those of studies are made by the program.
fn pages() -> Vec<PathBuf> {
    let mut pages: Vec<PathBuf> =
        ["README.md", "CONTRIBUTING.md", "ARCHITECTURE.md"].map(|name| root().join(name)).into();
    for folder in ["docs", "docs/notes"] {
        let files = fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap().path());
        pages.extend(files.filter(|path| path.extension().is_some_and(|ending| ending == "md")));
    }
    assert!(pages.len() > 15);
    pages
}

/// The lines of a page's blocks of one language.
fn code(page: &str, language: &str) -> Vec<String> {
    let mut lines = Vec::new();
    let mut inside = false;
    for line in page.lines() {
        match line.trim_start().strip_prefix("```") {
            Some(named) => inside = !inside && named == language,
            None if inside => lines.push(line.to_owned()),
            None => {}
        }
    }
    lines
}

/// A command's words, without its comment.
fn words(line: &str) -> Vec<&str> {
    line.split('#').next().unwrap().split_whitespace().collect()
}

#[test]
fn readme_has_two_commands_and_the_first_does_what_it_says() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    let lines = code(&readme, "sh");
    let commands: Vec<Vec<&str>> = lines.iter().map(|line| words(line)).collect();
    let (first, others) = commands[0].split_at(4);
    assert_eq!(first, ["cargo", "run", "--release", "--"]);
    assert_eq!(commands[1..], [["cargo", "test"]]);
    let place = Place::new();
    let out = place.relcp(others).expect(0).out;
    let summary = place.json("runs/colony/summary.json");
    assert_eq!((summary["steps"].as_u64(), summary["bodies"].as_u64()), (Some(6250), Some(512)), "{summary}");
    assert!(summary["max_overlap"].as_f64().unwrap() <= 1e-5, "{summary}");
    for said in ["512 cells", "6,250 steps", "1e-5"] {
        assert!(readme.contains(said), "{said}");
    }
    assert!(out.contains("runs/colony") && place.at("runs/colony/final.png").is_file(), "{out}");
    the_guide_shows(&out);
}

#[test]
fn readme_has_a_first_scene_that_runs() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    let place = Place::new();
    fs::write(place.at("first.json"), code(&readme, "json").join("\n")).unwrap();
    let out = place.relcp(&["run", "first.json"]).expect(0);
    assert!(!out.err.contains("warning"), "{out:?}");
    assert!(place.json("runs/first/summary.json")["bodies"].as_u64() > Some(10));
    assert!(place.at("runs/first/final.png").is_file() && readme.contains("`runs/first`"));
}

/// The guide's first sample is what this command prints, but for its times. Counts may differ by a fifth: where a
/// processor rounds otherwise the colony takes another course, as it does with another seed.
fn the_guide_shows(out: &str) {
    let guide = fs::read_to_string(root().join("docs/guide.md")).unwrap();
    let (_, sample) = guide.split_once("```text\n").unwrap();
    let sample: Vec<&str> = sample.lines().take_while(|line| *line != "```").collect();
    assert!(sample.len() > 4, "{sample:?}");
    for shown in sample {
        let (words, numbers) = words_and_numbers(shown);
        let close = |a: f64, b: f64| (a - b).abs() <= 0.2 * b;
        let is_shown = |line: &str| match shown.split_once("...") {
            Some((start, _)) => line.starts_with(start),
            None => {
                let (printed, counted) = words_and_numbers(line);
                let mut counts = counted.iter().zip(&numbers);
                printed == words && counted.len() == numbers.len() && counts.all(|(a, b)| close(*a, *b))
            }
        };
        assert!(out.lines().any(is_shown), "docs/guide.md shows {shown:?}, and the program prints\n{out}");
    }
}

fn words_and_numbers(line: &str) -> (Vec<&str>, Vec<f64>) {
    let (mut words, mut numbers) = (Vec::new(), Vec::new());
    for word in line.split_whitespace().map(|word| word.trim_end_matches(',')) {
        match word.parse::<f64>() {
            Ok(number) => numbers.push(number),
            Err(_) => words.push(word),
        }
    }
    (words, numbers)
}

#[test]
fn readme_is_two_screens_and_its_picture_moves() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    assert!(readme.split_whitespace().count() < 800);
    let (_, after) = readme.split_once("](assets/").unwrap();
    let picture = root().join("assets").join(after.split_once(')').unwrap().0);
    assert!(fs::metadata(&picture).unwrap().len() < 4_000_000);
    let decoder = png::Decoder::new(std::io::BufReader::new(fs::File::open(picture).unwrap()));
    let animation = *decoder.read_info().unwrap().info().animation_control().unwrap();
    assert!(animation.num_frames > 20 && animation.num_plays == 0);
}

#[test]
fn links_and_pictures_of_the_pages_are_there() {
    let (mut links, mut missing) = (0, Vec::new());
    for path in pages() {
        let page = fs::read_to_string(&path).unwrap();
        for after in page.split("](").skip(1) {
            let target = after.split(')').next().unwrap();
            if target.contains("://") || target.starts_with('#') || target.contains(char::is_whitespace) {
                continue;
            }
            links += 1;
            let (file, anchor) = target.split_once('#').map_or((target, None), |(file, anchor)| (file, Some(anchor)));
            let file = path.parent().unwrap().join(file);
            let holds = match anchor {
                Some(anchor) => fs::read_to_string(&file).is_ok_and(|page| anchors(&page).contains(anchor)),
                None => file.exists(),
            };
            if !holds {
                missing.push(format!("{}: {target}", path.display()));
            }
        }
    }
    assert!(links > 100 && missing.is_empty(), "{links} links; missing: {missing:#?}");
}

/// The anchors of a page's headings, as web pages of repositories make them.
fn anchors(page: &str) -> BTreeSet<String> {
    let headings = page.lines().filter(|line| line.starts_with('#'));
    let anchor = |line: &str| -> String {
        let text = line.trim_start_matches('#').trim().to_lowercase();
        let kept = text.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    headings.map(anchor).collect()
}

/// Between back-ticks: paths of this repository that end in a file.
/// The whole scenes of the pages are accepted, placed, and take a step.
#[test]
fn scenes_of_the_pages_can_be_run() {
    let mut scenes = Vec::new();
    for path in pages() {
        let page = fs::read_to_string(&path).unwrap();
        for block in page.split("```json\n").skip(1) {
            let json = block.split("```").next().unwrap();
            let Ok(scene) = serde_json::from_str::<serde_json::Value>(json) else { continue };
            if let Some(dt) = scene["time"]["dt"].as_f64() {
                scenes.push((path.clone(), json.to_owned(), dt));
            }
        }
    }
    assert!(scenes.len() > 5, "{}", scenes.len());
    for (path, json, dt) in scenes {
        println!("{}", path.display());
        let place = Place::new();
        fs::write(place.at("scene.json"), json).unwrap();
        let end = format!("time.end={dt}");
        place.relcp(&["run", "scene.json", "--set", &end, "--set", "output.picture=false", "--quiet"]).expect(0);
    }
}

#[test]
fn files_of_the_project_that_pages_name_are_there() {
    let (mut files, mut missing) = (0, Vec::new());
    for path in pages() {
        for named in fs::read_to_string(&path).unwrap().split('`').skip(1).step_by(2) {
            let folder = named.split('/').next().unwrap();
            let is_path = ["src", "shaders", "tests", "benches", "assets", "examples"].contains(&folder);
            let is_file = Path::new(named).extension().is_some() && !named.contains(['*', ' ', '{', ':']);
            if is_path && is_file && folder != named {
                files += 1;
                if !root().join(named).exists() {
                    missing.push(format!("{}: {named}", path.display()));
                }
            }
        }
    }
    assert!(files > 10 && missing.is_empty(), "{files} files; missing: {missing:#?}");
}

/// Flags of other programs that pages name.
const OF_OTHERS: [&str; 5] = ["--features", "--test", "--ntasks", "--kill-on-bad-exit", "--anew"];

/// Flags of the laboratory's program are fields of its arguments; its own tests read its help.
fn is_of_the_laboratory(flag: &str) -> bool {
    let arguments = fs::read_to_string(root().join("benches/lab/src/program/arguments.rs")).unwrap();
    arguments.contains(&format!("pub {}: ", flag.trim_start_matches('-').replace('-', "_")))
}

fn has(help: &str, flag: &str) -> bool {
    help.contains(&format!("{flag} ")) || help.contains(&format!("{flag}\n"))
}

/// Commands of pages, as those of the program's help, name its commands and flags of theirs; so do back-ticks. A flag
/// between back-ticks alone is one of any command.
#[test]
fn commands_of_the_pages_have_the_flags_that_they_name() {
    let place = Place::new();
    let (mut commands, mut alone, mut wrong) = (0, Vec::new(), Vec::new());
    let mut helps = std::collections::HashMap::new();
    for path in pages() {
        let page = fs::read_to_string(&path).unwrap();
        let named: Vec<String> = page.split('`').skip(1).step_by(2).map(str::to_owned).collect();
        for flag in named.iter().filter(|named| named.starts_with("--")) {
            alone.push((path.clone(), flag.split([' ', '=', '\n']).next().unwrap().to_owned()));
        }
        for line in code(&page, "sh").into_iter().chain(named) {
            let words = words(&line);
            let ["relcp", command, more @ ..] = words.as_slice() else { continue };
            if command.starts_with('-') || command.chars().all(char::is_uppercase) {
                continue;
            }
            commands += 1;
            let help = helps.entry((*command).to_owned()).or_insert_with(|| {
                let ran = place.relcp(&[command, "--help"]);
                (ran.status == Some(0)).then_some(ran.out)
            });
            let mut flags =
                more.iter().filter(|word| word.starts_with("--")).map(|word| word.split('=').next().unwrap());
            if !help.as_ref().is_some_and(|help| flags.all(|flag| has(help, flag))) {
                wrong.push(format!("{}: {line}", path.display()));
            }
        }
    }
    for (path, flag) in &alone {
        let known = OF_OTHERS.contains(&flag.as_str()) || is_of_the_laboratory(flag);
        if !known && !helps.values().flatten().any(|help| has(help, flag)) {
            wrong.push(format!("{}: {flag}", path.display()));
        }
    }
    assert!(commands > 60 && alone.len() > 60, "{commands} commands, {} flags", alone.len());
    assert!(wrong.is_empty(), "wrong: {wrong:#?}");
}

/// Limits that pages quote: the page and its words, the file and the constant that sets the limit, and how many times.
const LIMITS: [(&str, &str, &str, &str, u64); 14] = [
    ("docs/gpu.md", "{} bodies or more", "src/simulation/worth.rs", "LEAST_BODIES", 1),
    ("docs/gpu.md", "problems of up to {} rows", "src/lcp/gpu/machine.rs", "LARGEST_SMALL_ON_SOFTWARE", 1),
    ("docs/gpu.md", "({} on hardware", "src/lcp/gpu/machine.rs", "LARGEST_SMALL", 1),
    ("docs/gpu.md", "have up to {} bodies", "src/cli/driver.rs", "MOST_BODIES_ALONE", 1),
    ("docs/guide.md", "From {} constraints on", "src/lcp/team/mod.rs", "LEAST_ROWS", 2),
    ("docs/limitations.md", "from {} constraints on", "src/lcp/team/mod.rs", "LEAST_ROWS", 2),
    ("docs/batch.md", "up to {} members run at a time", "src/cli/batch_devices.rs", "MEMBERS_AT_ONCE", 1),
    ("docs/clusters.md", "blocks of at most {} near ones", "src/bisection.rs", "MOST_IN_A_BLOCK", 1),
    ("docs/clusters.md", "one process for every {}:", "src/bisection.rs", "MOST_IN_A_BLOCK", 2),
    ("docs/motion.md", "at most {} different windows", "src/scene/validate/forces.rs", "MOST_WINDOWS", 1),
    ("docs/measures.md", "Of more than {} bodies", "src/measure/tracks.rs", "MOST", 1),
    ("docs/view.md", "thinned to {} points", "src/view/steps.rs", "MOST", 1),
    ("docs/live.md", "connections to {}.", "src/cli/live/server.rs", "MOST_CONNECTIONS", 1),
    ("docs/solvers.md", "clusters of up to {},", "src/lcp/clusters/mod.rs", "MOST_MEMBERS", 1),
];

/// A number as pages write it: 1,536.
fn with_commas(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[test]
fn limits_that_pages_quote_are_those_of_the_source() {
    let mut wrong = Vec::new();
    for (page, said, file, constant, times) in LIMITS {
        let page_text = fs::read_to_string(root().join(page)).unwrap();
        let one_line = page_text.split_whitespace().collect::<Vec<_>>().join(" ");
        let source = fs::read_to_string(root().join(file)).unwrap();
        let (_, after) = source.split_once(&format!("const {constant}: ")).unwrap_or_else(|| panic!("no {constant}"));
        let (_, value) = after.split(';').next().unwrap().split_once(" = ").unwrap();
        let value: f64 = value.replace('_', "").parse().unwrap();
        let words = said.replace("{}", &with_commas(times * value as u64));
        if !one_line.contains(&words) {
            wrong.push(format!("{page} does not say {words:?}, as {constant} of {file} is {value}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn tables_of_the_pages_have_their_header_rows() {
    let (mut tables, mut wrong) = (0, Vec::new());
    for path in pages() {
        let page = fs::read_to_string(&path).unwrap();
        let lines: Vec<&str> = page.lines().collect();
        for (k, line) in lines.iter().enumerate() {
            if line.starts_with('|') && (k == 0 || !lines[k - 1].starts_with('|')) {
                tables += 1;
                let below = lines.get(k + 1).copied().unwrap_or_default();
                if !below.starts_with("| -") || below.contains(|c: char| !"|-: ".contains(c)) {
                    wrong.push(format!("{}:{}: {line}", path.display(), k + 1));
                }
            }
        }
    }
    assert!(tables > 100 && wrong.is_empty(), "{tables} tables; without a header row: {wrong:#?}");
}

#[test]
fn the_changelog_has_each_entry_once() {
    let page = fs::read_to_string(root().join("CHANGELOG.md")).unwrap();
    let (mut seen, mut twice) = (BTreeSet::new(), Vec::new());
    for line in page.lines().filter(|line| line.starts_with("- ")) {
        if !seen.insert(line) {
            twice.push(line);
        }
    }
    assert!(seen.len() > 30 && twice.is_empty(), "{twice:#?}");
}

/// The blocks of a page that `benches/peers/run` fills, by name.
fn measured_blocks(page: &str) -> Vec<(String, String)> {
    let blocks = page.split("<!-- peers: ").skip(1).filter(|block| !block.starts_with("end -->"));
    let block = |block: &str| {
        let (name, text) = block.split_once(" -->").unwrap();
        (name.to_owned(), text.split("<!--").next().unwrap().trim().to_owned())
    };
    blocks.map(block).collect()
}

/// README and the pages show the tables that were made from the measured lines, and these are in the tables.
#[test]
fn tables_of_other_programs_are_those_that_were_measured() {
    let results = root().join("benches/results/peers");
    let tables = fs::read_to_string(results.join("tables.md")).unwrap();
    let section = |name: &str| {
        let (_, after) = tables.split_once(&format!("\n## {name}\n")).unwrap_or_else(|| panic!("no table {name}"));
        after.split("\n## ").next().unwrap().trim()
    };
    let mut filled = 0;
    for page in ["README.md", "docs/peers.md", "docs/results.md", "docs/atlas.md", "docs/tolerance.md"] {
        let blocks = measured_blocks(&fs::read_to_string(root().join(page)).unwrap());
        assert!(!blocks.is_empty(), "{page}");
        for (name, text) in blocks {
            assert_eq!(text, section(&name), "{page}: {name}; benches/peers/run --report fills it");
            filled += 1;
        }
    }
    assert!(filled >= 8, "{filled}");
    // Step, CPU time and overlap of each run, as the table has them and as the lines have them.
    let number = |text: &str| text.trim().parse::<f64>().ok();
    let row = |line: &str| {
        let cells: Vec<Option<f64>> = line.split('|').map(number).collect();
        Some([(*cells.get(3)?)?, (*cells.get(4)?)?, (*cells.get(6)?)?])
    };
    let shown: Vec<[f64; 3]> = section("rods-1000").lines().filter_map(row).collect();
    let lines = fs::read_to_string(results.join("packing.jsonl")).unwrap();
    let runs = lines.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
    let measured: Vec<[f64; 3]> = runs
        .filter(|run| run["scene"] == "rods-1000" && run["ended"].is_null())
        .filter_map(|run| Some([run["dt"].as_f64()?, run["cpu_s"].as_f64()?, run["max_overlap"].as_f64()?]))
        .collect();
    let close = |a: f64, b: f64| (a - b).abs() <= 0.06 * a.abs().max(b.abs());
    let same = |a: &[f64; 3], b: &[f64; 3]| (0..3).all(|k| close(a[k], b[k]));
    assert!(shown.len() >= 10, "{shown:?}");
    for run in &shown {
        assert!(measured.iter().any(|measured| same(run, measured)), "{run:?} was not measured");
    }
    // Of several rounds of a run only the quickest is shown.
    assert!(measured.iter().filter(|run| shown.iter().any(|shown| same(run, shown))).count() >= shown.len());
}
