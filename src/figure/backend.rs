//! What `plotters` draws on: a page of vector marks.

use crate::page::{Anchor, Ink, Page, Path, PathBuilder, Words, width_of};
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind, FontTransform,
};
use std::convert::Infallible;

/// Where the baseline is below the middle of a letter and below its top, and above its lowest part, in parts of an em.
const BELOW_MIDDLE: f32 = 0.36;
const BELOW_TOP: f32 = 0.75;
const ABOVE_BOTTOM: f32 = 0.21;

/// Draws on a page; a pixel of `plotters` is a unit of it.
pub struct Sheet<'a>(&'a mut Page);

type Done = Result<(), DrawingErrorKind<Infallible>>;

impl<'a> Sheet<'a> {
    pub(super) fn on(page: &'a mut Page) -> Self {
        Sheet(page)
    }

    fn fill_or_line<S: BackendStyle>(&mut self, path: Option<Path>, style: &S, fill: bool) -> Done {
        let ink = ink(style.color());
        match fill {
            true => self.0.shape(path, Some(ink), None),
            false => self.0.shape(path, None, Some((ink, style.stroke_width() as f32))),
        }
        Ok(())
    }
}

fn ink(colour: BackendColor) -> Ink {
    let (r, g, b) = colour.rgb;
    Ink { rgb: [r, g, b], alpha: colour.alpha as f32 }
}

fn path(points: impl IntoIterator<Item = BackendCoord>, closed: bool) -> Option<Path> {
    let mut builder = PathBuilder::new();
    for (k, (x, y)) in points.into_iter().enumerate() {
        let (x, y) = (x as f32, y as f32);
        if k == 0 { builder.move_to(x, y) } else { builder.line_to(x, y) }
    }
    if closed {
        builder.close();
    }
    builder.finish()
}

impl DrawingBackend for Sheet<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        (self.0.size[0] as u32, self.0.size[1] as u32)
    }

    fn ensure_prepared(&mut self) -> Done {
        Ok(())
    }

    fn present(&mut self) -> Done {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, colour: BackendColor) -> Done {
        self.fill_or_line(path([(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)], true), &colour, true)
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Done {
        self.fill_or_line(path([from, to], false), style, false)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        (x, y): BackendCoord,
        (right, low): BackendCoord,
        style: &S,
        fill: bool,
    ) -> Done {
        self.fill_or_line(path([(x, y), (right, y), (right, low), (x, low)], true), style, fill)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, points: I, style: &S) -> Done {
        self.fill_or_line(path(points, false), style, false)
    }

    fn draw_circle<S: BackendStyle>(&mut self, (x, y): BackendCoord, radius: u32, style: &S, fill: bool) -> Done {
        self.fill_or_line(PathBuilder::from_circle(x as f32, y as f32, radius as f32), style, fill)
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, points: I, style: &S) -> Done {
        self.fill_or_line(path(points, true), style, true)
    }

    fn draw_text<T: BackendTextStyle>(&mut self, text: &str, style: &T, (x, y): BackendCoord) -> Done {
        let size = style.size() as f32;
        let upward = matches!(style.transform(), FontTransform::Rotate270);
        let below = size
            * match style.anchor().v_pos {
                VPos::Top => BELOW_TOP,
                VPos::Center => BELOW_MIDDLE,
                VPos::Bottom => -ABOVE_BOTTOM,
            };
        let anchor = match style.anchor().h_pos {
            HPos::Left => Anchor::Left,
            HPos::Center => Anchor::Middle,
            HPos::Right => Anchor::Right,
        };
        let (x, y) = (x as f32, y as f32);
        let at = if upward { [x + below, y] } else { [x, y + below] };
        self.0.words(Words { text: text.into(), at, size, anchor, upward, ink: ink(style.color()) });
        Ok(())
    }

    fn estimate_text_size<T: BackendTextStyle>(
        &self,
        text: &str,
        style: &T,
    ) -> Result<(u32, u32), DrawingErrorKind<Infallible>> {
        let size = style.size() as f32;
        Ok((width_of(text, size).ceil() as u32, size.ceil() as u32))
    }
}
