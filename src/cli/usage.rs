//! Wrong usage in one line: the argument, what was found, what was expected.

use std::error::Error as _;
use std::process::ExitCode;

use clap::error::{ContextKind, ContextValue, ErrorKind};

use super::out;

/// Answers a command line that is not to be run: help and version as they are, a fault in one line.
pub fn answer(error: &clap::Error) -> ExitCode {
    let is_help = error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand;
    if is_help || !error.use_stderr() {
        let _ = error.print();
    } else {
        out::complain(fault(error));
    }
    ExitCode::from(if error.use_stderr() { 2 } else { 0 })
}

fn fault(error: &clap::Error) -> String {
    let text = |kind| error.get(kind).map(words).filter(|s| !s.is_empty());
    let argument = text(ContextKind::InvalidArg);
    let found = error.get(ContextKind::InvalidValue).map(words);
    let expected = text(ContextKind::ValidValue);
    let cause = error.source().map(ToString::to_string);
    match (error.kind(), argument, found) {
        (ErrorKind::InvalidValue, Some(argument), Some(found)) if found.is_empty() => {
            let expected = expected.map_or("a value".into(), |e| format!("one of {e}"));
            format!("{argument}: found nothing, expected {expected}")
        }
        (ErrorKind::InvalidValue, Some(argument), Some(found)) => {
            format!("{argument}: found '{found}', expected one of {}", expected.unwrap_or_default())
        }
        (ErrorKind::ValueValidation, Some(argument), Some(found)) => {
            format!("{argument}: found '{found}', expected {}", wanted(&cause.unwrap_or_default()))
        }
        (ErrorKind::MissingRequiredArgument, Some(argument), _) => {
            format!("{argument}: found nothing, expected it to be given: see --help")
        }
        (ErrorKind::UnknownArgument, Some(argument), _) => {
            let near = text(ContextKind::SuggestedArg).map(|s| format!("{s} or ")).unwrap_or_default();
            format!("{argument}: found an unknown argument, expected {near}one that --help lists")
        }
        (ErrorKind::ArgumentConflict, Some(argument), _) => {
            match text(ContextKind::PriorArg).filter(|other| *other != argument) {
                Some(other) => format!("{argument}: found together with {other}, expected one of them"),
                None => format!("{argument}: found more than once, expected it once"),
            }
        }
        (ErrorKind::InvalidSubcommand, _, _) => {
            let found = text(ContextKind::InvalidSubcommand).unwrap_or_default();
            let near = text(ContextKind::SuggestedSubcommand).map(|s| format!("{s} or ")).unwrap_or_default();
            format!("command: found '{found}', expected {near}one that `hitl help` lists")
        }
        _ => plain(&error.render().to_string()),
    }
}

/// What a parser wanted, from what it complained of.
fn wanted(cause: &str) -> String {
    match cause {
        "invalid float literal" => "a number".into(),
        c if c.starts_with("invalid digit found") => "a whole number of 0 or more".into(),
        c => c.split_once(" is not in ").map_or_else(|| format!("another: {c}"), |(_, range)| range.into()),
    }
}

fn words(value: &ContextValue) -> String {
    match value {
        ContextValue::Strings(all) => all.join(", "),
        other => other.to_string(),
    }
}

/// clap's own words: without its usage lines, and in one line.
fn plain(text: &str) -> String {
    let text = text.split("\n\nUsage:").next().unwrap_or(text);
    let text = text.split("\n\nFor more information").next().unwrap_or(text);
    let text: Vec<&str> = text.trim_start_matches("error: ").split_whitespace().collect();
    format!("{}: see --help", text.join(" "))
}
