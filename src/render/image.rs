//! A finished picture and its file.

use super::colour::{decode, encode};
use std::io;
use std::path::Path;

/// A picture of red, green and blue bytes (sRGB), row by row from the top left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) pixels: Vec<u8>,
    /// The opacity of each pixel, if not all are opaque.
    pub(super) alpha: Option<Vec<u8>>,
}

impl Image {
    /// A picture with opacities, from the same picture on white and on black paper: a pixel is opaque if both agree,
    /// and empty if they differ by as much as the papers.
    pub(super) fn between(white: Image, black: &Image) -> Image {
        let mut alpha = Vec::with_capacity(white.pixels.len() / 3);
        let mut pixels = Vec::with_capacity(white.pixels.len());
        for (on_white, on_black) in white.pixels.chunks_exact(3).zip(black.pixels.chunks_exact(3)) {
            let light = |bytes: &[u8], k: usize| decode(bytes[k]);
            let shows: f32 = (0..3).map(|k| light(on_white, k) - light(on_black, k)).sum::<f32>() / 3.0;
            let opaque = (1.0 - shows).clamp(0.0, 1.0);
            alpha.push((255.0 * opaque).round() as u8);
            let own = |k: usize| if opaque > 0.0 { encode(light(on_black, k) / opaque) } else { 0 };
            pixels.extend((0..3).map(own));
        }
        Image { pixels, alpha: Some(alpha), ..white }
    }

    /// Width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The opacity of each pixel, from 0 to 255; `None` if all are opaque.
    pub fn alpha(&self) -> Option<&[u8]> {
        self.alpha.as_deref()
    }

    /// The bytes, three to a pixel.
    pub fn pixels(&self) -> &[u8] {
        &self.pixels
    }

    /// The colour of the pixel in column `x` and row `y`; `None` outside the picture.
    pub fn pixel(&self, x: u32, y: u32) -> Option<[u8; 3]> {
        let first =
            (x < self.width && y < self.height).then_some(3 * (y as usize * self.width as usize + x as usize))?;
        self.pixels.get(first..first + 3)?.try_into().ok()
    }

    /// Writes the picture as a PNG file, atomically; an existing file of that name is replaced.
    ///
    /// # Errors
    /// The error of the file system if the temporary file beside `path` cannot be created, written or renamed.
    pub fn write_png(&self, path: &Path) -> io::Result<()> {
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let mut builder = tempfile::Builder::new();
        builder.prefix(".picture-").suffix(".png");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // The permissions of an ordinary new file, subject to the process's mask. A temporary file would be
            // readable by its owner alone.
            builder.permissions(std::fs::Permissions::from_mode(0o666));
        }
        let mut file = builder.tempfile_in(folder)?;
        self.encode(io::BufWriter::new(file.as_file_mut()))?;
        file.as_file().sync_all()?;
        file.persist(path).map_err(|error| error.error)?;
        Ok(())
    }

    pub(crate) fn encode(&self, mut sink: impl io::Write) -> io::Result<()> {
        let mut encoder = png::Encoder::new(&mut sink, self.width, self.height);
        encoder.set_color(if self.alpha.is_some() { png::ColorType::Rgba } else { png::ColorType::Rgb });
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header()?;
        match &self.alpha {
            None => writer.write_image_data(&self.pixels)?,
            Some(alpha) => {
                let pixels = self.pixels.chunks_exact(3).zip(alpha);
                let bytes: Vec<u8> = pixels.flat_map(|(rgb, alpha)| [rgb[0], rgb[1], rgb[2], *alpha]).collect();
                writer.write_image_data(&bytes)?;
            }
        }
        writer.finish()?;
        sink.flush()
    }
}
