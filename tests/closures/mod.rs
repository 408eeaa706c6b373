//! Re-association: what it finds, what it leaves alone, and that nothing it found stays by itself.

mod parts;
mod real_logs;
mod simulated;
mod undoing;

use std::sync::atomic::AtomicBool;

use hitl_slam::closures::{self, Report};
use hitl_slam::joint::Backend;
use hitl_slam::map::{Correction, SlamMap};
use hitl_slam::pipeline::{Corrector, Options};

/// A corrector on this back end.
pub fn corrector(map: &SlamMap, backend: Backend) -> Corrector {
    let mut options = Options::default();
    options.joint.backend = backend;
    Corrector::new(map.clone(), options).expect("a map that can be corrected")
}

/// Re-associates and says what was done.
pub fn reassociate(corrector: &mut Corrector) -> Report {
    let never = AtomicBool::new(false);
    let found = corrector.reassociate(&closures::Options::default(), &|_| {}, &never);
    found.expect("a sound map").expect("nobody cancelled").report
}

/// The map after its strokes, and after re-association too.
pub fn with_and_without(
    map: &SlamMap,
    strokes: &[Correction],
    backend: Backend,
) -> (SlamMap, SlamMap, Report) {
    let mut corrector = corrector(map, backend);
    for stroke in strokes {
        corrector.apply(stroke).expect("strokes on the map");
    }
    let without = corrector.map().clone();
    let report = reassociate(&mut corrector);
    (without, corrector.into_map(), report)
}
