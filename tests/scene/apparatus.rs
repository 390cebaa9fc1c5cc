//! Scenes of experiments (fields, walls under a load, drag, regions, fences, lattices, removal) that are broken at one
//! place each: `broken.txt` has the place, what is put there, the key that the error names, and words of its message.

use relcp::scene::{Scene, SceneError};
use serde_json::Value;

const GOOD: &str = include_str!("apparatus.json");
const BROKEN: &str = include_str!("broken.txt");

fn read(scene: &Value) -> Result<usize, SceneError> {
    Ok(Scene::parse(&scene.to_string(), "apparatus.json")?.build()?.len())
}

/// Puts a value at a dotted place; null takes out what is there.
fn put(scene: &mut Value, place: &str, value: Value) {
    let (of, last) = place
        .rsplit_once('.')
        .map_or((String::new(), place), |(of, last)| (format!("/{}", of.replace('.', "/")), last));
    match scene.pointer_mut(&of).unwrap() {
        Value::Array(list) if last.parse() == Ok(list.len()) => list.push(value),
        Value::Array(list) => list[last.parse::<usize>().unwrap()] = value,
        Value::Object(map) if value.is_null() => drop(map.remove(last).unwrap()),
        Value::Object(map) => drop(map.insert(last.into(), value)),
        other => panic!("{place}: {other}"),
    }
}

#[test]
fn a_broken_experiment_is_refused_where_it_is_broken() {
    let good: Value = serde_json::from_str(GOOD).unwrap();
    assert_eq!(read(&good).unwrap(), 23);
    let mut wrong = Vec::new();
    for line in BROKEN.lines() {
        let [place, value, key, words] = line.split(" | ").collect::<Vec<_>>().try_into().unwrap();
        let mut scene = good.clone();
        put(&mut scene, place, serde_json::from_str(value).unwrap());
        match read(&scene) {
            Ok(bodies) => wrong.push(format!("{line}: {bodies} bodies")),
            Err(error) if error.key() == key && error.to_string().contains(words) => {}
            Err(error) => wrong.push(format!("{line}: {error}")),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(BROKEN.lines().count() >= 100);
}
