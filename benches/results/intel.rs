//! The demo, measured: Intel from its raw log, four strokes drawn by eye on the scan-matched chain, then re-association.

use std::sync::atomic::AtomicBool;

use hitl_slam::closures;
use hitl_slam::front_end::{self, Chain};
use hitl_slam::io;
use hitl_slam::map::SlamMap;
use hitl_slam::metrics;
use hitl_slam::pipeline::{Corrector, Options};
use hitl_slam::render::{self, MapPictureOptions};

use crate::figures::save;
use crate::page::{Claim, Result, Section, project};

pub fn section() -> Result<Section> {
    let log = io::carmen::read(&project("data/intel.clf.bz2"))?.value;
    let corrections = io::corrections::read(&project("data/intel.corrections.jsonl"))?.value;
    let relations = io::relations::read(&project("data/intel.relations"))?.value;
    let progress = |_| {};
    let chain = Chain::ScanMatch { progress: &progress };
    let (before, _) = front_end::build(&log, chain, &front_end::Options::for_scan_matching())?;
    let mut corrector = Corrector::new(before.clone(), Options::default())?;
    for correction in &corrections {
        corrector.apply(correction)?;
    }
    let strokes = corrector.map().clone();
    corrector.reassociate(&closures::Options::default(), &|_| {}, &AtomicBool::new(false))?;
    let after = corrector.into_map();

    let mut section = Section { title: "A real log: Intel (the demo)", name: "intel", ..Section::default() };
    section.body = format!(
        "`data/intel.clf.bz2`: {} scans, {} poses by scan matching, {} corrections drawn by eye (`data/README.md`), then {} automatic factors. \
         Error against {} hand-checked relations: mean translation, mean rotation, median translation.\n\n\
         | map | all relations | over 120 s apart |\n|---|---|---|\n",
        log.scans.len(),
        before.poses.len(),
        corrections.len(),
        after.automatic_factors.len(),
        relations.len(),
    );
    let mut means = Vec::new();
    for (name, map) in
        [("scan-matched chain", &before), ("four strokes alone", &strokes), ("and re-association", &after)]
    {
        let e = metrics::relation_errors(&map.trajectory(), &relations, metrics::DEFAULT_TOLERANCE_S);
        let number = |v: Option<f64>| v.unwrap_or(f64::NAN);
        let long = &e.by_span[3];
        section.body += &format!(
            "| {name} | {:.4} m, {:.3}°, {:.4} m | {:.4} m, {:.3}° |\n",
            number(e.translation_mean_m),
            number(e.rotation_mean_deg),
            number(e.translation_median_m),
            number(long.translation_mean_m),
            number(long.rotation_mean_deg)
        );
        means.push([number(e.translation_mean_m), number(e.rotation_mean_deg)]);
    }
    section.body += "\nPublished, all relations: Graph Mapping 0.031 m / 1.3°, Cartographer 0.023 m / 0.45° (quoted, not measured here).\n";
    let picture = |map: &SlamMap, title: &str| {
        let bare = SlamMap { automatic_factors: Vec::new(), human_factors: Vec::new(), ..map.clone() };
        let options = MapPictureOptions { size_px: 760, title: Some(title.into()), ..Default::default() };
        render::map(&bare, &options)
    };
    let pair = [
        picture(&before, "scan matching alone"),
        picture(&after, "after four strokes and what they let match by itself"),
    ];
    section.body += &save("intel.png", "the Intel lab, before and after", &render::tiled(&pair, 2))?;
    let claim = |what: &str, measured, bound, unit, decimals| Claim {
        what: what.into(),
        measured,
        bound,
        unit,
        decimals,
        why: "set before it was built",
    };
    section.claims = vec![
        claim("Intel, four strokes by eye alone: all relations", means[1][0], 0.065, "m", 3),
        claim("Intel, the same and re-association: all relations", means[2][0], 0.013, "m", 4),
        claim("Intel, the same and re-association: rotation", means[2][1], 0.22, "°", 3),
    ];
    Ok(section)
}
