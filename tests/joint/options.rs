//! Choosing a back end.

use hitl_slam::error::Error;
use hitl_slam::joint::{BACK_ENDS, Backend, Formulation, Options, ceres};

#[test]
fn the_default_back_end_is_rust_whatever_the_machine() {
    assert_eq!(Options::default().backend, Backend::Rust);
    assert!(Backend::Rust.available());
}

#[test]
fn asking_for_ceres_where_it_is_absent_is_bad_input_that_explains_itself() {
    let asked = Options { backend: Backend::Ceres, ..Options::default() }.validate();
    if ceres::LINKED {
        assert!(asked.is_ok() && BACK_ENDS.contains("ceres 2."), "{BACK_ENDS}");
        return;
    }
    let error = asked.unwrap_err();
    assert!(matches!(error, Error::Input { .. }));
    let text = error.to_string();
    assert!(text.contains("libceres-dev") && text.contains("no ceres"), "{text}");
}

#[test]
fn names_are_read_back() {
    for backend in [Backend::Rust, Backend::Ceres] {
        assert_eq!(backend.name().parse::<Backend>().unwrap(), backend);
    }
    for formulation in [Formulation::Smooth, Formulation::Paper] {
        assert_eq!(formulation.name().parse::<Formulation>().unwrap(), formulation);
    }
    assert!("g2o".parse::<Backend>().is_err() && "rough".parse::<Formulation>().is_err());
}
