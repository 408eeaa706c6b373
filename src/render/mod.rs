//! Pictures of maps and plots of errors, as PNG and SVG from one description.
//!
//! [`map`] and [`before_after`] draw a [`crate::map::SlamMap`] in the look of the paper's figures, [`Plot`] draws
//! curves and bars. Each gives a [`Picture`]: a list of primitives in pixels, y down, that [`Picture::to_png`] and
//! [`Picture::to_svg`] turn into bytes. Nothing here touches a file or a clock: same input, same bytes.

mod axis;
mod density;
mod errors;
mod heat;
mod information;
mod map_layers;
mod map_picture;
mod plot;
mod png;
mod scene;
mod svg;
mod text;
mod tiled;
mod uncertainty;
mod viewport;

pub use errors::PlacedErrors;
pub use heat::Heat;
pub use information::{information, mode_colour};
pub use map_layers::Overlay;
pub use map_picture::{MapPictureOptions, before_after, map};
pub use plot::{Mark, Plot, Series};
pub use scene::{Anchor, Colour, Item, Layer, Picture, PixelRect};
pub use text::text_width_px;
pub use tiled::tiled;
pub use viewport::{Viewport, WorldRect};
