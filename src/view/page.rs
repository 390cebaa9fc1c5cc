//! The file: the page's own parts with the data between them.

use super::Packer;
use super::columns::text;
use super::header::Header;
use crate::record::RecordError;
use crate::render::RenderError;
use std::fmt::Write;
use std::path::Path;

const PAGE: &str = include_str!("../../assets/view/index.html");
const STYLE: &str = include_str!("../../assets/view/style.css");
/// The script, in the order in which its parts need each other.
const SCRIPT: [&str; 9] = [
    include_str!("../../assets/view/data.js"),
    include_str!("../../assets/view/camera.js"),
    include_str!("../../assets/view/draw.js"),
    include_str!("../../assets/view/walls.js"),
    include_str!("../../assets/view/panel.js"),
    include_str!("../../assets/view/overlay.js"),
    include_str!("../../assets/view/keep.js"),
    include_str!("../../assets/view/pointers.js"),
    include_str!("../../assets/view/main.js"),
];
const SHADERS: [(&str, &str); 8] = [
    ("body.vert", include_str!("../../assets/view/body.vert")),
    ("body.frag", include_str!("../../assets/view/body.frag")),
    ("shade.vert", include_str!("../../assets/view/shade.vert")),
    ("shade.frag", include_str!("../../assets/view/shade.frag")),
    ("line.vert", include_str!("../../assets/view/line.vert")),
    ("line.frag", include_str!("../../assets/view/line.frag")),
    ("surface.vert", include_str!("../../assets/view/surface.vert")),
    ("surface.frag", include_str!("../../assets/view/surface.frag")),
];

/// What the script of a page does at last: of a file, and of a run that goes on.
const START: &str = "start(readRun);";
const LIVE: &str = include_str!("../../assets/view/live.js");
const HANDS: &str = include_str!("../../assets/view/hands.js");
const START_LIVE: &str = "startLive();";
/// What each may load: nothing, and what its own server gives.
const LOADS_NOTHING: &str = "default-src 'none'; script";
const LOADS_OWN: &str = "default-src 'none'; connect-src 'self'; script";

/// The page of a run that goes on, which asks its server for the data.
pub(super) fn live() -> Result<Vec<u8>, RenderError> {
    let page = filled("", &[&SCRIPT[..], &[HANDS, LIVE, START_LIVE]].concat())?;
    Ok(page.replacen(LOADS_NOTHING, LOADS_OWN, 1).into_bytes())
}

/// The page with its data.
pub(super) fn joined(header: &Header, packer: &Packer) -> Result<Vec<u8>, RenderError> {
    let document = json(header)?;
    let mut data = String::with_capacity(packer.packed.iter().map(|text| text.len() + 64).sum());
    let mut add = |name: &str, text: &str| {
        // A string takes all that is written to it.
        let _ = writeln!(data, "<script type=\"text/plain\" id=\"{name}\">{text}</script>");
    };
    add("run", &text(&document));
    add("bodies", &text(packer.shared().bytes()));
    for (k, packed) in packer.packed.iter().enumerate() {
        add(&format!("state-{k}"), packed);
    }
    Ok(filled(&data, &[&SCRIPT[..], &[START]].concat())?.into_bytes())
}

/// The page's own parts with these data and scripts.
fn filled(data: &str, script: &[&str]) -> Result<String, RenderError> {
    let shaders: std::collections::BTreeMap<_, _> = SHADERS.into_iter().collect();
    // No text in a script may look like its end.
    let shaders = String::from_utf8_lossy(&json(&shaders)?).replace('<', "\\u003c");
    let script = script.join("\n");
    let parts = [
        ("/*STYLE*/", STYLE),
        ("<!--DATA-->", data),
        ("/*SHADERS*/", &format!("const SHADERS = {shaders};")),
        ("/*SCRIPT*/", script.as_str()),
    ];
    let mut page = String::with_capacity(PAGE.len() + parts.iter().map(|(_, text)| text.len()).sum::<usize>());
    let mut rest = PAGE;
    for (mark, text) in parts {
        let (before, after) = rest.split_once(mark).unwrap_or((rest, ""));
        page.push_str(before);
        page.push_str(text);
        rest = after;
    }
    page.push_str(rest);
    Ok(page)
}

/// A value as JSON.
pub(super) fn json<T: serde::Serialize>(value: &T) -> Result<Vec<u8>, RenderError> {
    let fault = |fault: serde_json::Error| RecordError::io(Path::new("the page"), "pack it")(fault.into());
    Ok(serde_json::to_vec(value).map_err(fault)?)
}
