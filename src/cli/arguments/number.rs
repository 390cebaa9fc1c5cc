//! Numbers in arguments.

use relcp::render::View;

pub(super) fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once(['x', 'X']).and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    match sides {
        Some(sides) if sides.iter().all(|side| (1..=View::LARGEST_SIDE).contains(side)) => Ok(sides),
        _ => Err(format!("it is not WIDTHxHEIGHT in pixels, each from 1 to {}, as in 1920x1080", View::LARGEST_SIDE)),
    }
}

pub(super) fn range(text: &str) -> Result<[f64; 2], String> {
    let (low, high) = text.split_once(':').ok_or("it is not LOW:HIGH, as in 0:2.5")?;
    match [length(low)?, length(high)?] {
        [low, high] if low < high => Ok([low, high]),
        _ => Err("the first number is not below the second".into()),
    }
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    match length(text)? {
        value if value > 0.0 => Ok(value),
        _ => Err("it is not above zero".into()),
    }
}

pub(super) fn length(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err("it is not a finite number".into()),
    }
}
