//! Runs a solver test on both back ends.

use std::io::Write as _;

use hitl_slam::joint::Backend;

/// True if this build has Ceres. If not, says so; fails where Ceres is required (`HITL_REQUIRE_CERES=1`).
pub fn ceres_or_skip() -> bool {
    if Backend::Ceres.available() {
        return true;
    }
    assert!(
        std::env::var("HITL_REQUIRE_CERES").as_deref() != Ok("1"),
        "HITL_REQUIRE_CERES=1, but this is a build without Ceres"
    );
    skipped("built without Ceres");
    false
}

/// Says why a test did nothing; not through `eprintln!`, which the harness swallows.
pub fn skipped(reason: &str) {
    let line = format!("skipped: {reason}\n");
    let _ = std::io::stderr().write_all(line.as_bytes());
}

/// `both_backends! { fn name(backend: Backend) { … } … }`: a module `name` with the tests `rust` and `ceres`.
macro_rules! both_backends {
    ($($(#[$meta:meta])* fn $name:ident($backend:ident: Backend) $body:block)*) => {$(
        $(#[$meta])*
        mod $name {
            #[allow(unused_imports)]
            use super::*;

            fn check($backend: hitl_slam::joint::Backend) $body

            #[test]
            fn rust() {
                check(hitl_slam::joint::Backend::Rust);
            }

            #[test]
            fn ceres() {
                if crate::support::both_backends::ceres_or_skip() {
                    check(hitl_slam::joint::Backend::Ceres);
                }
            }
        }
    )*};
}
