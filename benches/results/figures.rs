//! Plots and pictures below docs/img.

use std::fs;

use hitl_slam::pipeline::Options;
use hitl_slam::render::{self, MapPictureOptions, Mark, Picture, Plot, Series};
use hitl_slam::simulate::Scenario;

use crate::accuracy::Study;
use crate::page::{Result, project};
use crate::runs;
use crate::stats::Sample;

/// Markdown that shows the picture, which is written to docs/img.
pub fn save(name: &str, alt: &str, picture: &Picture) -> Result<String> {
    fs::create_dir_all(project("docs/img"))?;
    fs::write(project("docs/img").join(name), picture.to_png())?;
    Ok(format!("![{alt}](img/{name})\n\n"))
}

/// One plot per scenario: ATE after each correction, both noises, ours and the baseline.
pub fn ate_plots(studies: &[Study]) -> Result<String> {
    let mut text = String::from("\n");
    for scenario in [Scenario::Loop, Scenario::Campus] {
        let of_scenario: Vec<&Study> = studies.iter().filter(|s| s.scenario == scenario).collect();
        let Some(first) = of_scenario.first() else { continue };
        let steps = first.corrections();
        let mut series = Vec::new();
        for (k, study) in of_scenario.iter().enumerate() {
            let centimetres = 100.0 * study.noise_m;
            // Side by side, so that intervals do not hide each other.
            let shift = 0.06 * k as f64 - 0.09;
            series.push(curve(&format!("ours, {centimetres:.0} cm"), steps, shift, |k| study.ours(k)));
            let label = format!("baseline, {centimetres:.0} cm");
            series.push(curve(&label, steps, shift + 0.12, |k| study.baseline(k)));
        }
        let names = (0..=steps).map(|k| if k == 0 { "before".into() } else { format!("after {k}") });
        let plot = Plot {
            title: format!("{scenario}: mean ATE with 95 % interval, {} seeds", crate::accuracy::SEEDS),
            y_label: "ATE (m)".into(),
            log_y: true,
            categories: names.collect(),
            series,
            size_px: (1000, 560),
            ..Plot::default()
        };
        text += &save(&format!("ate-{scenario}.png"), &plot.title, &plot.draw())?;
    }
    Ok(text)
}

fn curve(label: &str, steps: usize, shift: f64, sample: impl Fn(usize) -> Sample) -> Series {
    let samples: Vec<Sample> = (0..=steps).map(sample).collect();
    let interval = |s: &Sample| [s.mean() - s.half_interval(), s.mean() + s.half_interval()];
    Series {
        label: label.into(),
        points: samples.iter().enumerate().map(|(k, s)| [k as f64 + shift, s.mean()]).collect(),
        intervals: samples.iter().map(interval).collect(),
        mark: Mark::Line,
    }
}

/// Before and after of one seed of either scenario.
pub fn pictures() -> Result<String> {
    let mut text = String::new();
    for (scenario, size_px) in [(Scenario::Loop, 620), (Scenario::Campus, 760)] {
        let s = runs::simulated(scenario, 1, 0.02)?;
        let (after, _) = runs::corrected(&s.map, &s.corrections, Options::default())?;
        let title = Some(format!("{scenario}, seed 1"));
        let options = MapPictureOptions { size_px, title, ..MapPictureOptions::default() };
        let picture = render::before_after(&s.map, &after, &options);
        let alt = format!("{scenario}, seed 1, 2 cm: before and after");
        text += &save(&format!("{scenario}.png"), &alt, &picture)?;
    }
    Ok(text)
}

/// ATE over the noise of drawing, one curve a map.
pub fn noise_plot(noises_m: &[f64], curves: &[(Scenario, Vec<Sample>)]) -> Result<String> {
    let series = curves.iter().map(|(scenario, samples)| Series {
        label: scenario.to_string(),
        points: noises_m.iter().zip(samples).map(|(n, s)| [100.0 * n, s.mean()]).collect(),
        intervals: samples
            .iter()
            .map(|s| [s.mean() - s.half_interval(), s.mean() + s.half_interval()])
            .collect(),
        mark: Mark::Line,
    });
    let plot = Plot {
        title: "ATE after all corrections over the noise of drawing".into(),
        x_label: "noise of a drawn end point, per axis (cm)".into(),
        y_label: "ATE (m)".into(),
        log_y: true,
        series: series.collect(),
        size_px: (1000, 560),
        ..Plot::default()
    };
    Ok(format!("\n{}", save("drawing-noise.png", &plot.title, &plot.draw())?))
}
