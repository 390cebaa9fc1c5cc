use super::page::date;
use super::*;
use relcp::gpu::Choice;
use std::fs;

/// A device of the tests' own, as a study times it; one test uses it at a time.
fn own() -> Option<Arc<Gpu>> {
    let name = std::env::var("RELCP_ADAPTER").ok();
    match Gpu::open(&Choice { name, software: true, ..Choice::default() }) {
        Ok(gpu) => Some(Arc::new(gpu)),
        Err(why) if std::env::var_os("RELCP_REQUIRE_GPU").is_some() => panic!("a GPU is required: {why}"),
        Err(why) => {
            eprintln!("SKIP: {why}");
            None
        }
    }
}

fn tiny(time: Duration) -> Options {
    Options { sizes: vec![24, 48], precisions: vec![Precision::F32], time, quick: true, cells: 2 }
}

fn all_of(study: &mut Study) -> Vec<String> {
    std::iter::from_fn(|| study.next_item(&|| true).unwrap()).collect()
}

#[test]
fn a_tiny_study_runs_whole_and_a_second_call_computes_nothing_again() {
    let Some(gpu) = own() else { return };
    let folder = tempfile::tempdir().unwrap();
    let time = Duration::from_secs(3600);
    // One whose time is over leaves everything out, with the reason, and what it wrote is gone on with.
    let mut late = Study::open(gpu.clone(), tiny(Duration::ZERO), folder.path()).unwrap();
    assert_eq!(all_of(&mut late), [""; 0]);
    let skipped = &late.results().skipped;
    assert!(skipped["parity/rows/f32"].starts_with("no time") && late.page().contains("was left out"), "{skipped:?}");
    // One that is interrupted too.
    let mut stopped = Study::open(gpu.clone(), tiny(time), folder.path()).unwrap();
    assert_eq!(stopped.next_item(&|| false).unwrap(), None);
    assert!(stopped.results().items.is_empty());
    assert_eq!(stopped.results().skipped["parity/separations/f32"], "interrupted");

    let mut study = Study::open(gpu.clone(), tiny(time), folder.path()).unwrap();
    let said = all_of(&mut study);
    let items = Item::all(&[24, 48], &[Precision::F32]);
    assert_eq!((said.len(), study.results().items.len()), (items.len(), items.len()), "{said:#?}");
    assert!(!study.missed() && study.results().skipped.is_empty(), "{}", study.page());
    check(&study);

    let written = fs::read(folder.path().join(FILE)).unwrap();
    let mut again = Study::open(gpu.clone(), tiny(time), folder.path()).unwrap();
    assert_eq!(all_of(&mut again), [""; 0]);
    assert_eq!(fs::read(folder.path().join(FILE)).unwrap(), written);
    assert_eq!(again.page(), study.page());

    // An item that failed is tried again.
    let mut failed = again.results.clone();
    failed.items.get_mut("bandwidth").unwrap().finding = Finding::Failed { why: "no memory".into() };
    failed.write(folder.path()).unwrap();
    let mut mended = Study::open(gpu, tiny(time), folder.path()).unwrap();
    assert!(mended.missed() && mended.page().contains("bandwidth failed: no memory"));
    assert_eq!(all_of(&mut mended).len(), 1);
    assert!(!mended.missed());
}

fn check(study: &Study) {
    let page = study.page();
    for heading in [
        "Against the CPU",
        "Whole steps",
        "By stage",
        "One workgroup or many",
        "Pairs or clusters",
        "A colony from one cell",
    ] {
        assert!(page.contains(heading), "{heading}: {page}");
    }
    assert!(page.contains("Nothing was left out.") && page.contains("copies, read and written"), "{page}");
    let Some(Finding::Parity { checks }) = study.results().finding("parity/separations/f32") else { panic!("{page}") };
    // Ten pairs of kinds, and walls.
    assert_eq!(checks.len(), 11);
    assert!(checks.iter().all(|check| check.compared >= 100 && check.largest > 0.0), "{checks:#?}");
    let Some(Finding::Speed(row)) = study.results().finding("speed/packing/48/f32") else { panic!("{page}") };
    assert!(row.bodies == 48 && row.step_ms > 0.0 && row.part_of_copy.is_some(), "{row:?}");
    let Some(Finding::Growth(growth)) = study.results().finding("growth/cpu") else { panic!("{page}") };
    assert!(growth.whole && growth.doublings.len() == 1 && growth.doublings[0].cells == 2, "{growth:?}");
    assert_eq!(study.plots().unwrap().len(), 2);
}

#[test]
fn a_damaged_file_and_another_devices_are_refused_and_stay() {
    let Some(gpu) = own() else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(FILE);
    let options = || tiny(Duration::from_secs(1));
    Study::open(gpu.clone(), options(), folder.path()).unwrap();
    let whole = fs::read_to_string(&path).unwrap();
    let another = whole.replace(gpu.name(), "another device");
    let newer = whole.replace("\"format\": 1", "\"format\": 2");
    let cases: [(&str, &str); 5] = [
        (&whole[..whole.len() / 2], "damaged"),
        ("", "damaged"),
        ("{\"format\": 1, \"rows\": []}", "damaged"),
        (&newer, "it has the format 2"),
        (&another, "has results of another device"),
    ];
    for (text, said) in cases {
        fs::write(&path, text).unwrap();
        let fault = Study::open(gpu.clone(), options(), folder.path()).err().unwrap();
        assert!(fault.to_string().contains(said) && fault.to_string().contains(FILE), "{fault}");
        assert_eq!(fs::read_to_string(&path).unwrap(), text);
    }
}

#[test]
fn a_size_is_left_out_where_the_one_before_was_or_took_too_long() {
    let (sizes, speed) = ([64, 256], |size| Item::Speed(super::super::throughput::Kind::Colony, size, Precision::F32));
    let Some(gpu) = own() else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut results = Results::open(folder.path(), &gpu).unwrap();
    assert_eq!(speed(64).expected(&sizes, &results), Ok(Duration::ZERO));
    let iteration = Item::Iteration(Precision::F32);
    assert_eq!(iteration.expected(&sizes, &results), Err("steps of no size were measured".into()));
    assert_eq!(speed(256).expected(&sizes, &results), Err("64 bodies were left out".into()));
    let finding = Finding::Bandwidth { bytes_a_second: 1.0 };
    let mut insert = |finding| {
        results.items.insert(speed(64).name(), Entry { wall_seconds: 10.0, ended_unix_seconds: 0, finding });
        speed(256).expected(&sizes, &results)
    };
    assert_eq!(insert(finding), Ok(Duration::from_secs(48)));
    assert_eq!(insert(Finding::Failed { why: "it was lost".into() }), Err("64 bodies failed".into()));
    for kind in super::super::throughput::Kind::ALL {
        let (name, finding) =
            (Item::Speed(kind, 64, Precision::F32).name(), Finding::Bandwidth { bytes_a_second: 1.0 });
        results.items.insert(name, Entry { wall_seconds: 10.0, ended_unix_seconds: 0, finding });
    }
    assert_eq!(iteration.expected(&sizes, &results), Ok(Duration::from_secs(30)));
}

#[test]
fn days_are_those_of_the_calendar() {
    let days = [0, 951_782_400, 951_868_800, 1_709_164_800, 1_735_689_599, 1_735_689_600, 4_102_444_800];
    let expected = ["1970-01-01", "2000-02-29", "2000-03-01", "2024-02-29", "2024-12-31", "2025-01-01", "2100-01-01"];
    assert_eq!(days.map(date), expected);
}

#[test]
fn folders_are_named_by_devices() {
    assert_eq!(folder_name("NVIDIA GeForce RTX 4090"), "device-nvidia-geforce-rtx-4090");
    assert_eq!(folder_name("llvmpipe (LLVM 15.0.6, 256 bits)"), "device-llvmpipe-llvm-15-0-6-256-bits");
    assert_eq!(folder_name("../(),"), "device-unnamed");
}
