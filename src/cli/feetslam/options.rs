//! The tunables of `hitl feetslam run`.

use clap::ValueEnum;
use hitl_slam::error::{Error, Result};
use hitl_slam::pedestrian::{GainSchedule, GridChoice, Norm, Options, Start};

use crate::cli::options::start_pose;

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Grid {
    /// Turned to the group's walking direction; given up where the building turns by a small angle.
    Aligned,
    /// At --grid-angle-deg.
    Fixed,
    /// Drawn anew in every iteration: no direction is preferred.
    Regrid,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum NormName {
    Fresh,
    Uniform,
    Literal,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Schedule {
    Constant,
    Annealed,
}

/// How whole walks are run.
#[derive(clap::Args)]
pub struct Tunables {
    /// Iterations after iteration 0, at most 10.
    #[arg(long, value_name = "N", default_value_t = Options::default().iterations)]
    iterations: usize,
    /// How the gain goes over the iterations.
    #[arg(long, value_enum, default_value_t = Schedule::Constant)]
    gain_schedule: Schedule,
    /// Stop a round when the total map changes by less than this share; 0: never.
    #[arg(long, value_name = "SHARE", default_value_t = Options::default().converged_below)]
    converged_below: f64,
    /// Iteration 0 of a later round has the walker's own earlier map in its prior too.
    #[arg(long)]
    own_map: bool,
    /// In later rounds re-run only the last metres of each walk.
    #[arg(long, value_name = "M")]
    window_m: Option<f64>,
    #[command(flatten)]
    pub filter: Filter,
}

impl Tunables {
    /// The library's options.
    pub fn options(&self) -> Options {
        Options {
            iterations: self.iterations,
            gain_schedule: match self.gain_schedule {
                Schedule::Constant => GainSchedule::Constant,
                Schedule::Annealed => GainSchedule::Annealed,
            },
            converged_below: self.converged_below,
            own_map_in_prior: self.own_map,
            window_m: self.window_m,
            ..self.filter.options()
        }
    }
}

/// How the filter works, on whole walks and live.
#[derive(clap::Args)]
pub struct Filter {
    /// Particles per walker.
    #[arg(long, value_name = "N", default_value_t = Options::default().particles)]
    particles: usize,
    /// Independent filters that share the particles of a walker who is mapped alone; the most central path is kept (10: for
    /// long walks with revisits).
    #[arg(long, value_name = "N", default_value_t = Options::default().islands)]
    islands: usize,
    /// Decides all that is left to chance.
    #[arg(long, value_name = "N", default_value_t = Options::default().seed)]
    seed: u64,
    /// Circumradius of the hexagons.
    #[arg(long, value_name = "M", default_value_t = Options::default().hex_radius_m)]
    hex_radius_m: f64,
    /// Direction of the hexagon grid.
    #[arg(long, value_enum, default_value_t = Grid::Aligned)]
    grid: Grid,
    /// Angle of the fixed grid against the world.
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_negative_numbers = true)]
    grid_angle_deg: f64,
    /// Where every walker starts: x_m,y_m,heading_deg.
    #[arg(long, value_name = "X,Y,DEG", default_value = "0,0,0", allow_hyphen_values = true)]
    start: String,
    /// Standard deviation of the start's position, per axis.
    #[arg(long, value_name = "M", default_value_t = Start::default().position_sigma_m)]
    start_sigma_m: f64,
    /// Standard deviation of the start's heading.
    #[arg(long, value_name = "DEG", default_value_t = 1.0)]
    start_heading_sigma_deg: f64,
    /// Dirichlet parameter of every edge.
    #[arg(long, value_name = "A", default_value_t = Options::default().alpha)]
    alpha: f64,
    /// Normalisation of a crossing's probability; literal is as published and prefers the grid's axes.
    #[arg(long, value_enum, default_value_t = NormName::Fresh)]
    norm: NormName,
    /// Weight of the other walkers' maps.
    #[arg(long, value_name = "G", default_value_t = Options::default().gain)]
    gain: f64,
    /// White heading noise, degrees per 0.7 m.
    #[arg(long, value_name = "DEG", default_value_t = 0.5)]
    heading_noise_deg: f64,
    /// Heading drift, degrees per 0.7 m.
    #[arg(long, value_name = "DEG", default_value_t = 0.05)]
    drift_deg: f64,
    /// White position noise per axis, metres per 0.7 m.
    #[arg(long, value_name = "M", default_value_t = Options::default().noise.position_m)]
    position_noise_m: f64,
    /// Scale error of a walk's steps, as a share.
    #[arg(long, value_name = "SHARE", default_value_t = Options::default().noise.scale)]
    scale_noise: f64,
}

impl Filter {
    /// The library's options.
    pub fn options(&self) -> Options {
        let default = Options::default();
        let mut noise = default.noise;
        noise.heading_rad = self.heading_noise_deg.to_radians();
        noise.drift_start_rad = self.drift_deg.to_radians();
        noise.position_m = self.position_noise_m;
        noise.scale = self.scale_noise;
        Options {
            particles: self.particles,
            islands: self.islands,
            seed: self.seed,
            hex_radius_m: self.hex_radius_m,
            grid: match self.grid {
                Grid::Aligned => GridChoice::Aligned,
                Grid::Fixed => GridChoice::Fixed(self.grid_angle_deg.to_radians()),
                Grid::Regrid => GridChoice::Regrid,
            },
            alpha: self.alpha,
            norm: match self.norm {
                NormName::Fresh => Norm::Fresh,
                NormName::Uniform => Norm::Uniform,
                NormName::Literal => Norm::Literal,
            },
            noise,
            gain: self.gain,
            ..default
        }
    }

    /// Where the walkers start.
    ///
    /// # Errors
    /// If `--start` is not three finite numbers, or a standard deviation is negative.
    pub fn start(&self) -> Result<Start> {
        let pose = start_pose(&self.start)?;
        for (name, value) in [
            ("--start-sigma-m", self.start_sigma_m),
            ("--start-heading-sigma-deg", self.start_heading_sigma_deg),
        ] {
            if !(0.0..=360.0).contains(&value) {
                return Err(Error::input(
                    name,
                    format_args!("found {value}, expected a number from 0 to 360"),
                ));
            }
        }
        Ok(Start {
            pose,
            position_sigma_m: self.start_sigma_m,
            heading_sigma_rad: self.start_heading_sigma_deg.to_radians(),
        })
    }

    /// `aligned`, `fixed` or `regrid`.
    pub fn grid_name(&self) -> &'static str {
        match self.grid {
            Grid::Aligned => "aligned",
            Grid::Fixed => "fixed",
            Grid::Regrid => "regrid",
        }
    }
}
