//! A finished picture and its file.

use std::io;
use std::path::Path;

/// A picture of red, green and blue bytes (sRGB), row by row from the top left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) pixels: Vec<u8>,
}

impl Image {
    /// Width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> u32 {
        self.height
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

    /// Writes the picture as a PNG file. It appears under its name only when it is whole; a file of that name is
    /// replaced.
    ///
    /// # Errors
    /// Whatever the file system says when the file beside `path` cannot be made, written or renamed.
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
            // As an ordinary new file; the process's mask applies. A temporary file would be for its owner alone.
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
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.pixels)?;
        writer.finish()?;
        sink.flush()
    }
}
