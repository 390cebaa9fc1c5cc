//! A page as SVG. Letters are named and not drawn, so that they can be edited; a browser without Roboto takes another
//! font without serifs.

use super::{Anchor, Ink, Mark, Page, Shape, Words};
use std::fmt::Write;
use tiny_skia::PathSegment;

impl Page {
    pub(crate) fn svg(&self) -> String {
        let [wide, high] = self.size;
        let millimetres = |units: f32| f64::from(units * self.points) * 25.4 / 72.0;
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{:.2}mm\" height=\"{:.2}mm\" viewBox=\"0 0 {wide} {high}\" \
             font-family=\"{}, Helvetica, Arial, sans-serif\">\n<title>{}</title>\n",
            millimetres(wide),
            millimetres(high),
            super::font::NAME,
            escaped(&self.title)
        );
        for mark in &self.marks {
            match mark {
                Mark::Shape(shape) => draw(&mut out, shape),
                Mark::Words(words) => write_words(&mut out, words),
            }
        }
        out + "</svg>\n"
    }
}

fn draw(out: &mut String, shape: &Shape) {
    out.push_str("<path d=\"");
    for segment in shape.path.segments() {
        // Writing to a string does not fail.
        let _ = match segment {
            PathSegment::MoveTo(p) => write!(out, "M{} {}", short(p.x), short(p.y)),
            PathSegment::LineTo(p) => write!(out, "L{} {}", short(p.x), short(p.y)),
            PathSegment::QuadTo(a, p) => {
                write!(out, "Q{} {} {} {}", short(a.x), short(a.y), short(p.x), short(p.y))
            }
            PathSegment::CubicTo(a, b, p) => {
                let [ax, ay, bx, by] = [a.x, a.y, b.x, b.y].map(short);
                write!(out, "C{ax} {ay} {bx} {by} {} {}", short(p.x), short(p.y))
            }
            PathSegment::Close => write!(out, "Z"),
        };
    }
    out.push('"');
    match shape.fill {
        Some(ink) => paint(out, "fill", ink),
        None => out.push_str(" fill=\"none\""),
    }
    if let Some((ink, width)) = shape.line {
        paint(out, "stroke", ink);
        let _ = write!(out, " stroke-width=\"{}\" stroke-linejoin=\"round\"", short(width));
    }
    out.push_str("/>\n");
}

fn write_words(out: &mut String, words: &Words) {
    let [x, y] = words.at.map(short);
    let _ = write!(out, "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\"", short(words.size));
    paint(out, "fill", words.ink);
    match words.anchor {
        Anchor::Left => {}
        Anchor::Middle => out.push_str(" text-anchor=\"middle\""),
        Anchor::Right => out.push_str(" text-anchor=\"end\""),
    }
    if words.upward {
        let _ = write!(out, " transform=\"rotate(-90 {x} {y})\"");
    }
    let _ = writeln!(out, ">{}</text>", escaped(&words.text));
}

fn paint(out: &mut String, what: &str, ink: Ink) {
    let [r, g, b] = ink.rgb;
    let _ = write!(out, " {what}=\"#{r:02x}{g:02x}{b:02x}\"");
    if ink.alpha < 1.0 {
        let _ = write!(out, " {what}-opacity=\"{}\"", short(ink.alpha));
    }
}

/// A hundredth of a unit is finer than any printer.
fn short(value: f32) -> String {
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
