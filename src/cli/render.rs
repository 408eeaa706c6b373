//! `hitl render`: pictures of maps.

use std::path::PathBuf;

use hitl_slam::error::{Error, Result};
use hitl_slam::geometry::Vec2;
use hitl_slam::joint;
use hitl_slam::metrics::{self, InconsistencyOptions};
use hitl_slam::render::{self, Heat, MapPictureOptions, WorldRect};

use super::{Outcome, load, out, picture};

/// Draw a picture of a map as PNG or SVG.
///
/// Points are orange, poses black arrows (thinned out where they are dense), the strokes of corrections red and blue.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Map, graph or log to draw.
    input: PathBuf,

    /// Picture to write; the extension picks the format: .png or .svg.
    #[arg(short, long, value_name = "X.png|X.svg")]
    output: PathBuf,

    /// The map as it was before: draws both at one scale, the strokes in both.
    #[arg(long, value_name = "INPUT")]
    before: Option<PathBuf>,

    /// Draw the information matrix: which poses a factor ties to which, human factors coloured by mode.
    #[arg(long, conflicts_with_all = ["before", "inconsistency", "grid", "crop"])]
    information: bool,

    /// Colour where the map contradicts itself (see `hitl inconsistency`).
    #[arg(long, conflicts_with = "before")]
    inconsistency: bool,

    /// Draw how certain the poses are, given the first: an ellipse of 1σ around each, as far as there is room.
    #[arg(long, conflicts_with_all = ["before", "information", "inconsistency"])]
    uncertainty: bool,

    /// Draw grid lines with coordinates in metres, for writing strokes by hand.
    #[arg(long)]
    grid: bool,

    /// Show only this part of the world: two opposite corners, metres.
    #[arg(long, value_name = "X0,Y0,X1,Y1", allow_hyphen_values = true)]
    crop: Option<String>,

    /// Longer side of the map in the picture, pixels.
    #[arg(long, value_name = "N", default_value_t = 1200, value_parser = clap::value_parser!(u32).range(120..=7000))]
    size_px: u32,

    /// A line above the map.
    #[arg(long, value_name = "TEXT")]
    title: Option<String>,
}

/// Runs the command.
///
/// # Errors
/// Bad options, or a file that cannot be read or written.
pub fn run(args: &Args) -> Result<Outcome> {
    picture::check(&args.output)?;
    let mut options = MapPictureOptions {
        size_px: args.size_px,
        title: args.title.clone(),
        with_grid: args.grid,
        crop: args.crop.as_deref().map(crop).transpose()?,
        ..MapPictureOptions::default()
    };
    let map = load::map(&args.input)?;
    if args.inconsistency {
        let found = metrics::inconsistency(&map, &InconsistencyOptions::default())?;
        options.heat = Some(Heat { side_m: found.resolution_m, cells: found.cells });
    }
    if args.uncertainty {
        let covariances = joint::map_covariances(&map, &joint::Options::default())?;
        options.position_covariances =
            Some(covariances.iter().map(|c| [c[(0, 0)], c[(0, 1)], c[(1, 1)]]).collect());
    }
    let drawn = match &args.before {
        _ if args.information => render::information(&map, args.size_px, args.title.as_deref()),
        Some(before) => render::before_after(&load::map(before)?, &map, &options),
        None => render::map(&map, &options),
    };
    picture::write(&args.output, &drawn)?;
    let line = format!("{}: {} × {} pixels\n", args.output.display(), drawn.width(), drawn.height());
    out::print(&line)?;
    Ok(Outcome::Done)
}

fn crop(text: &str) -> Result<WorldRect> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    let rect = match numbers.as_deref() {
        Some(&[x0, y0, x1, y1]) => WorldRect::new(Vec2::new(x0, y0), Vec2::new(x1, y1)),
        _ => None,
    };
    rect.ok_or_else(|| {
        Error::input(
            "--crop",
            format_args!("found \"{text}\", expected x0,y0,x1,y1 in metres, not of zero size"),
        )
    })
}
