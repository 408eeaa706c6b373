//! `hitl feetslam live`: positions from steps as they arrive.

use std::collections::VecDeque;
use std::io::{BufRead, Read as _};
use std::path::{Path, PathBuf};
use std::time::Instant;

use hitl_slam::error::{Error, Result};
use hitl_slam::io;
use hitl_slam::io::journal::{self, Journal};
use hitl_slam::io::step_lines::{self, Line};
use hitl_slam::pedestrian::live::{Live, Settings};

use super::options::Filter;
use super::output;
use crate::cli::{Outcome, out};

/// Place steps of several walkers as they arrive: JSON lines on stdin, positions as JSON lines on stdout.
///
/// In:  {"walker": "anna", "time_s": 0.6, "forward_m": 0.7, "left_m": 0, "turn_rad": 0.01}, walkers in any order;
///      {"walker": "ben", "start_x_m": 0, "start_y_m": 2, "start_heading_rad": 0} before ben's first step;
///      {"request": "map"}, or {"request": "round"}: everybody again, with the others' maps of now.
/// Every line is kept in OUT before it is answered: a run that was killed goes on where it was if it is started again
/// with the same OUT and options. At the end of stdin OUT gets the walks, paths.csv, map.json and map.npz. The lines are
/// described in docs/FORMATS-walks.md. FootSLAM is covered by a patent (US 8,626,443 B2, DLR; listed active until
/// 20 September 2030): check before commercial use.
#[derive(clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Args {
    /// Folder for the state and the results; made with the first line
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    filter: Filter,
    /// A walker's map is exchanged with the others' after every so many of its steps
    #[arg(long, value_name = "N", default_value_t = Settings::default().refresh_steps)]
    refresh_steps: usize,
    /// Write OUT/map.json after every so many steps of all walkers; 0: at the end only
    #[arg(long, value_name = "N", default_value_t = 0)]
    map_every_steps: usize,
    /// stdin begins anew: skip the lines that an earlier run accepted, and check that they are the same
    #[arg(long)]
    from_start: bool,
    /// Name bad lines and go on, instead of stopping at the first
    #[arg(long)]
    skip_bad_lines: bool,
    /// Threads; 0: one per core. The results are the same
    #[arg(long, value_name = "N", default_value_t = 0)]
    threads: usize,
}

/// A run: what it knows, what it keeps, what it said before.
struct Run<'a> {
    live: Live<'a>,
    journal: Journal,
    said: VecDeque<String>,
    args: &'a Args,
    alpha: f64,
    /// Lines accepted so far.
    accepted: usize,
    steps: usize,
    /// From a line's arrival to its answer, and to the readiness for the next; milliseconds.
    delays_ms: Vec<[f32; 2]>,
}

/// Why a line was not taken.
enum Fault {
    /// It is bad; what was found and expected.
    Line(String),
    /// Something else failed.
    Run(Error),
}

impl From<Error> for Fault {
    fn from(error: Error) -> Self {
        Fault::Run(error)
    }
}

/// Runs the command.
///
/// # Errors
/// Bad options; a bad line (what came before it is kept); files that cannot be written.
pub fn run(args: &Args) -> Result<Outcome> {
    let settings = Settings {
        options: args.filter.options(),
        start: args.filter.start()?,
        refresh_steps: args.refresh_steps,
    };
    let live = Live::new(&settings)?;
    let threads = rayon::ThreadPoolBuilder::new()
        .num_threads(args.threads)
        .build()
        .map_err(|e| Error::Internal(e.to_string()))?;
    let (journal, kept) = Journal::open(&args.output, &format!("{settings:?}"))?;
    let alpha = settings.options.alpha;
    let mut run =
        Run { live, journal, said: kept.answers, args, alpha, accepted: 0, steps: 0, delays_ms: Vec::new() };
    threads.install(|| {
        for line in &kept.lines {
            run.take(line, true).map_err(|fault| match fault {
                Fault::Line(message) => {
                    Error::line(args.output.join(journal::LINES).display(), run.accepted + 2, message)
                }
                Fault::Run(error) => error,
            })?;
        }
        let beyond = std::mem::take(&mut run.said);
        run.journal.forget(&beyond)?;
        if run.accepted > 0 {
            out::complain(format_args!("note: goes on after {} lines", run.accepted));
        }
        run.follow(if args.from_start { kept.lines } else { VecDeque::new() })?;
        run.finish()
    })?;
    Ok(Outcome::Done)
}

impl Run<'_> {
    /// Takes every line of stdin; `known` are those at its beginning that are accepted already.
    fn follow(&mut self, mut known: VecDeque<String>) -> Result<()> {
        let mut stdin = std::io::stdin().lock();
        let mut bytes = Vec::new();
        for number in 1.. {
            bytes.clear();
            let longest = step_lines::LONGEST_LINE as u64;
            let read = stdin.by_ref().take(longest).read_until(b'\n', &mut bytes);
            if read.map_err(|e| Error::io(Path::new("standard input"), e))? == 0 {
                return Ok(());
            }
            let line = bytes.trim_ascii();
            if line.is_empty() {
                continue;
            }
            let fault = if bytes.len() as u64 == longest && !bytes.ends_with(b"\n") {
                stdin.skip_until(b'\n').map_err(|e| Error::io(Path::new("standard input"), e))?;
                format!("found a line of more than {longest} bytes, expected a step")
            } else if let Some(wanted) = known.front() {
                if wanted.as_bytes() == line {
                    known.pop_front();
                    continue;
                }
                format!("found a line other than the accepted {wanted}, expected the same again")
            } else {
                let line = String::from_utf8_lossy(line);
                match self.take(&line, false) {
                    Ok(()) => continue,
                    Err(Fault::Line(message)) => message,
                    Err(Fault::Run(error)) => return Err(error),
                }
            };
            let error = Error::line("standard input", number, fault);
            if !self.args.skip_bad_lines {
                return Err(error);
            }
            out::complain(format_args!("{error}: skipped"));
        }
        Ok(())
    }

    /// Takes a line and answers it; `kept`: it is in the journal already.
    fn take(&mut self, text: &str, kept: bool) -> std::result::Result<(), Fault> {
        let arrived = Instant::now();
        let line = step_lines::parse(text.as_bytes()).map_err(Fault::Line)?;
        let number = self.accepted + 1;
        let mut events = Vec::new();
        let answer = match &line {
            Line::Step(walker, step) => {
                let position = self.live.step(walker, *step).map_err(Fault::Line)?;
                Some(step_lines::position(number, walker, &position))
            }
            Line::Start(walker, pose) => {
                self.live.begin(walker, *pose).map_err(Fault::Line)?;
                None
            }
            Line::Map => Some(step_lines::map(number, &self.live.map(), self.alpha)),
            Line::Round => {
                events.extend(self.live.round());
                Some(step_lines::round(number, &self.live))
            }
        };
        self.accepted = number;
        if !kept {
            self.journal.accept(text)?;
        }
        if let Some(answer) = answer {
            self.say(answer)?;
        }
        let answered_ms = arrived.elapsed().as_secs_f32() * 1e3;
        events.extend(self.live.settle());
        for event in events {
            self.say(step_lines::event(number, &event))?;
        }
        if matches!(line, Line::Step(..)) {
            self.steps += 1;
            if !kept {
                self.delays_ms.push([answered_ms, arrived.elapsed().as_secs_f32() * 1e3]);
            }
            if self.steps.is_multiple_of(self.args.map_every_steps) {
                io::transition_map::write_json(&self.args.output.join("map.json"), &self.live.map())?;
            }
        }
        Ok(())
    }

    /// Gives an answer, unless it was given before the run was killed.
    fn say(&mut self, answer: String) -> Result<()> {
        match self.said.pop_front() {
            Some(before) if before == answer => Ok(()),
            Some(before) => {
                let place = self.args.output.join(journal::ANSWERS);
                let message = format!("found the answer {before}, expected {answer}: made by another build?");
                Err(Error::input(place.display(), message))
            }
            None => {
                out::print(&format!("{answer}\n"))?;
                self.journal.answer(&answer)
            }
        }
    }

    /// Writes what came out.
    fn finish(&mut self) -> Result<()> {
        let (walks, outcome) = self.live.outcome();
        if walks.is_empty() {
            return Err(Error::input("standard input", "found no step, expected at least one"));
        }
        let folder = &self.args.output;
        for walk in &walks {
            io::walk::write(&folder.join("walks").join(format!("{}.csv", walk.name)), walk)?;
        }
        output::write(folder, &walks, &outcome)?;
        let mut text = format!("{} steps of {} walkers", self.steps, walks.len());
        for (k, what) in ["answered", "ready again"].iter().enumerate() {
            let mut delays: Vec<f32> = self.delays_ms.iter().map(|d| d[k]).collect();
            delays.sort_unstable_by(f32::total_cmp);
            if let Some(&slowest) = delays.last() {
                let at = |share: f64| delays[((delays.len() - 1) as f64 * share) as usize];
                text +=
                    &format!("; {what} after {:.2} ms, p99 {:.2}, {slowest:.2} at most", at(0.5), at(0.99));
            }
        }
        out::complain(text);
        Ok(())
    }
}
