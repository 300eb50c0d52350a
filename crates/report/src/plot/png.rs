//! A figure as pixels: its SVG, rendered.

use std::sync::Arc;

use resvg::{tiny_skia, usvg};

use super::{Figure, pen, svg};
use gearwise_model::input::limits::PIXELS;

/// Pixels of a PNG for each pixel of the SVG.
const PNG_SCALE: f32 = 1.5;

/// A figure as PNG.
///
/// # Errors
/// In words, where it cannot be drawn.
pub fn png(figure: &Figure) -> Result<Vec<u8>, String> {
    let cannot = |error: &dyn std::fmt::Display| format!("cannot draw the picture: {error}");
    let text = svg(figure);
    let mut fonts = usvg::fontdb::Database::new();
    fonts.load_font_data(pen::FONT.to_vec());
    fonts.set_sans_serif_family("DejaVu Sans");
    let options = usvg::Options { fontdb: Arc::new(fonts), font_family: "DejaVu Sans".into(), ..Default::default() };
    let tree = usvg::Tree::from_str(&text, &options).map_err(|e| cannot(&e))?;
    let size = tree.size().to_int_size().scale_by(PNG_SCALE).ok_or("the picture has no size")?;
    let (width, height) = (size.width(), size.height());
    if u64::from(width) * u64::from(height) > PIXELS {
        return Err(format!(
            "cannot draw the picture: {width} x {height} pixels are more than {PIXELS}; draw an .svg, or fewer joints"
        ));
    }
    let mut pixels = tiny_skia::Pixmap::new(width, height).ok_or("the picture is too large")?;
    resvg::render(&tree, tiny_skia::Transform::from_scale(PNG_SCALE, PNG_SCALE), &mut pixels.as_mut());
    pixels.encode_png().map_err(|e| cannot(&e))
}
