//! A movie in one file: an animated PNG (PNG specification, third edition, 2025), which browsers and Markdown pages
//! play. The file stores of each picture only the rectangle that differs from the one before it.

use super::RenderError;
use crate::record::{RecordError, durable};
use std::fs::File;
use std::io::{BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};

/// How long the last picture is shown before the animation repeats, in seconds.
const LAST_SHOWN: u16 = 1;

/// A decoded picture.
struct Picture {
    size: [usize; 2],
    colour: png::ColorType,
    bytes: Vec<u8>,
}

/// A part of a picture: its left and upper edge, its width and height.
type Part = [[usize; 2]; 2];

impl Picture {
    fn read(path: &Path) -> Result<Picture, RenderError> {
        let file = File::open(path).map_err(RecordError::io(path, "read it"))?;
        let damaged = |fault: png::DecodingError| RecordError::io(path, "read it")(fault.into());
        let mut reader = png::Decoder::new(BufReader::new(file)).read_info().map_err(damaged)?;
        let mut bytes = vec![0; reader.output_buffer_size().unwrap_or(0)];
        let info = reader.next_frame(&mut bytes).map_err(damaged)?;
        bytes.truncate(info.buffer_size());
        Ok(Picture { size: [info.width as usize, info.height as usize], colour: info.color_type, bytes })
    }

    /// Bytes of a pixel.
    fn depth(&self) -> usize {
        self.colour.samples()
    }

    /// The bytes of a part of a row.
    fn row(&self, row: usize, columns: [usize; 2]) -> &[u8] {
        let first = row * self.size[0];
        &self.bytes[(first + columns[0]) * self.depth()..(first + columns[1]) * self.depth()]
    }

    /// The smallest part that contains all pixels that differ. A part has at least one pixel, even if none differs.
    fn changed(&self, before: &Picture) -> Part {
        let [width, height] = self.size;
        let differs = |row: &usize| self.row(*row, [0, width]) != before.row(*row, [0, width]);
        let Some(top) = (0..height).find(differs) else { return [[0, 0], [1, 1]] };
        let bottom = (top..height).rev().find(differs).unwrap_or(top);
        let column_differs = |column: &usize| {
            let own = [*column, *column + 1];
            (top..=bottom).any(|row| self.row(row, own) != before.row(row, own))
        };
        let left = (0..width).find(column_differs).unwrap_or(0);
        let right = (left..width).rev().find(column_differs).unwrap_or(left);
        [[left, top], [right + 1 - left, bottom + 1 - top]]
    }

    fn part(&self, [[left, top], [width, height]]: Part) -> Vec<u8> {
        (top..top + height).flat_map(|row| self.row(row, [left, left + width])).copied().collect()
    }
}

/// Writes these pictures, which have the same size, as an animation.
///
/// # Errors
/// A picture that cannot be read, and a file that cannot be written.
pub(super) fn write(pictures: &[PathBuf], frames_a_second: u32, path: &Path) -> Result<(), RenderError> {
    durable::place_with(path, |file| {
        let Some((first, others)) = pictures.split_first() else { return Ok(()) };
        let failed = |fault: png::EncodingError| RenderError::from(RecordError::io(path, "write it")(fault.into()));
        let mut shown = Picture::read(first)?;
        let mut sink = BufWriter::new(file);
        let [width, height] = shown.size.map(|side| side as u32);
        let mut encoder = png::Encoder::new(&mut sink, width, height);
        encoder.set_color(shown.colour);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::High);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_animated(pictures.len() as u32, 0).map_err(failed)?;
        encoder.set_blend_op(png::BlendOp::Source).map_err(failed)?;
        let mut writer = encoder.write_header().map_err(failed)?;
        let delay =
            |last: bool| if last { (LAST_SHOWN, 1) } else { (1, frames_a_second.min(u32::from(u16::MAX)) as u16) };
        let (over, under) = delay(others.is_empty());
        writer.set_frame_delay(over, under).map_err(failed)?;
        writer.write_image_data(&shown.bytes).map_err(failed)?;
        for (number, other) in others.iter().enumerate() {
            let next = Picture::read(other)?;
            let [corner, size] = next.changed(&shown);
            // A rectangle must fit at its corner, so the corner is reset before the size changes.
            writer.reset_frame_position().map_err(failed)?;
            writer.set_frame_dimension(size[0] as u32, size[1] as u32).map_err(failed)?;
            writer.set_frame_position(corner[0] as u32, corner[1] as u32).map_err(failed)?;
            let (over, under) = delay(number + 1 == others.len());
            writer.set_frame_delay(over, under).map_err(failed)?;
            writer.write_image_data(&next.part([corner, size])).map_err(failed)?;
            shown = next;
        }
        writer.finish().map_err(failed)?;
        sink.flush().map_err(RecordError::io(path, "write it"))?;
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(marks: &[[usize; 2]]) -> Picture {
        let mut bytes = vec![255; 5 * 4 * 3];
        for [x, y] in marks {
            bytes[3 * (5 * y + x)] = 0;
        }
        Picture { size: [5, 4], colour: png::ColorType::Rgb, bytes }
    }

    #[test]
    fn only_what_differs_is_stored() {
        let white = picture(&[]);
        assert_eq!(picture(&[]).changed(&white), [[0, 0], [1, 1]]);
        assert_eq!(picture(&[[3, 2]]).changed(&white), [[3, 2], [1, 1]]);
        let two = picture(&[[4, 0], [1, 3]]);
        assert_eq!(two.changed(&white), [[1, 0], [4, 4]]);
        assert_eq!(two.part([[1, 3], [1, 1]]), [0, 255, 255]);
    }
}
