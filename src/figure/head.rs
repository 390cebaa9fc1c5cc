//! The names of curves, in rows over the axes.

use super::drawing::{Area, Failed, LINE, MARGIN, POINT, TEXT};
use crate::page::width_of;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// The sample of a curve before its name, and the room between two names.
const SAMPLE: u32 = 12 * POINT;
const GAP: u32 = 3 * POINT;
/// From a row of names to the next.
const ROW: u32 = TEXT + TEXT / 4;

/// A name, with the colour of its curve; without one it is a remark.
#[derive(Clone, Debug, PartialEq)]
pub struct Name {
    /// The name.
    pub text: String,
    /// The colour of its curve.
    pub colour: Option<RGBColor>,
}

impl Name {
    fn width(&self) -> u32 {
        let sample = if self.colour.is_some() { SAMPLE + GAP } else { 0 };
        sample + width_of(&self.text, TEXT as f32).ceil() as u32
    }
}

/// A heading and names in rows: as many names in a row as fit, in columns; each remark has a row of its own.
#[derive(Clone, Debug)]
pub struct Head {
    heading: String,
    rows: Vec<Vec<Name>>,
    column: u32,
}

impl Head {
    /// For an area so wide.
    pub fn new(wide: u32, heading: &str, names: Vec<Name>) -> Self {
        let (curves, remarks): (Vec<Name>, Vec<Name>) = names.into_iter().partition(|name| name.colour.is_some());
        let column = curves.iter().map(|name| name.width() + 2 * GAP).max().unwrap_or(1);
        let across = (wide.saturating_sub(MARGIN) / column).max(1) as usize;
        let mut rows: Vec<Vec<Name>> = curves.chunks(across).map(<[Name]>::to_vec).collect();
        rows.extend(remarks.into_iter().map(|remark| vec![remark]));
        Head { heading: heading.into(), rows, column }
    }

    /// Its height.
    pub fn height(&self) -> u32 {
        MARGIN / 2 + ROW * (self.rows.len() as u32 + u32::from(!self.heading.is_empty()))
    }

    /// Writes it at the top of an area, with `height` units for it; returns what is left below.
    pub fn draw<'a>(&self, area: &Area<'a>, height: u32) -> Result<Area<'a>, Failed> {
        let (top, rest) = area.split_vertically(height);
        let style = || ("sans-serif", TEXT).into_font().color(&BLACK).pos(Pos::new(HPos::Left, VPos::Center));
        let mut y = (MARGIN / 2 + ROW / 2) as i32;
        if !self.heading.is_empty() {
            top.draw(&Text::new(self.heading.clone(), (MARGIN as i32, y), style()))?;
            y += ROW as i32;
        }
        for names in &self.rows {
            for (k, name) in names.iter().enumerate() {
                let mut x = (MARGIN + self.column * k as u32) as i32;
                if let Some(colour) = name.colour {
                    let sample = [(x, y), (x + SAMPLE as i32, y)];
                    top.draw(&PathElement::new(sample, colour.stroke_width(LINE)))?;
                    x += (SAMPLE + GAP) as i32;
                }
                top.draw(&Text::new(name.text.clone(), (x, y), style()))?;
            }
            y += ROW as i32;
        }
        Ok(rest)
    }
}
