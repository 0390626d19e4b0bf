//! PNG, drawn with fonts that are part of the program, since a robot without a display has no fonts.

use std::sync::{Arc, OnceLock};

use resvg::{tiny_skia, usvg};

use crate::graph::Graph;
use crate::layout::Layout;
use crate::render::svg::svg;
use crate::theme::{self, Theme};

/// Pixels of the image for each pixel of the picture.
pub const SCALE: f32 = 2.0;

/// Draws a placed graph as an image. [`Theme::Auto`] and [`Theme::Editor`], which need a viewer, become
/// [`Theme::Light`].
///
/// # Errors
///
/// Fails if the picture is too large to be held in memory.
pub fn png(graph: &Graph, layout: &Layout, theme: Theme) -> Result<Vec<u8>, String> {
    let theme = match theme {
        Theme::Auto | Theme::Neutral | Theme::Editor => Theme::Light,
        other => other,
    };
    let text = svg(graph, layout, theme).replace("</style>", theme::RASTER_STYLE);
    let options =
        usvg::Options { font_family: SANS.to_owned(), fontdb: fonts(), ..usvg::Options::default() };
    let tree = usvg::Tree::from_str(&text, &options).map_err(|error| error.to_string())?;
    let (width, height) =
        ((layout.width as f32 * SCALE).ceil(), (layout.height as f32 * SCALE).ceil());
    let mut pixels = tiny_skia::Pixmap::new(width as u32, height as u32).ok_or_else(|| {
        format!("an image of {width} × {height} pixels is too large; ask for SVG")
    })?;
    let scale = tiny_skia::Transform::from_scale(SCALE, SCALE);
    resvg::render(&tree, scale, &mut pixels.as_mut());
    pixels.encode_png().map_err(|error| error.to_string())
}

const SANS: &str = "Ubuntu";
const MONO: &str = "Hack";

/// Read once: parsing them takes longer than drawing.
fn fonts() -> Arc<usvg::fontdb::Database> {
    static FONTS: OnceLock<Arc<usvg::fontdb::Database>> = OnceLock::new();
    FONTS
        .get_or_init(|| {
            let mut fonts = usvg::fontdb::Database::new();
            fonts.load_font_data(epaint_default_fonts::UBUNTU_LIGHT.to_vec());
            fonts.load_font_data(epaint_default_fonts::HACK_REGULAR.to_vec());
            fonts.load_font_data(epaint_default_fonts::NOTO_EMOJI_REGULAR.to_vec());
            fonts.set_sans_serif_family(SANS);
            fonts.set_monospace_family(MONO);
            Arc::new(fonts)
        })
        .clone()
}
