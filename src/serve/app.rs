//! What all requests share: the open session, the work that is going on, and the news for every page that listens.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tokio::sync::watch;

use super::view;
use crate::error::{Error, Result};
use crate::front_end;
use crate::session::{self, Session, Source};

/// Progress is told no more often than this: to tell is work, too.
const BETWEEN_NEWS: Duration = Duration::from_millis(100);

/// The server's state.
#[derive(Debug)]
pub struct App {
    /// What every request must know.
    pub token: String,
    /// Where dropped maps go.
    pub folder: PathBuf,
    desk: RwLock<Option<Desk>>,
    /// The open map as the page is told, apart from what is going on.
    view: Mutex<Value>,
    works: Mutex<BTreeMap<u64, Work>>,
    next: AtomicU64,
    /// Revision of the map that the pages were shown last.
    shown: AtomicU64,
    /// True while someone looks for contradictions.
    judging: AtomicBool,
    /// When the pages were told of progress last.
    told_at: Mutex<Option<Instant>>,
    news: watch::Sender<Arc<str>>,
}

/// The open session.
#[derive(Debug)]
pub struct Desk {
    /// The session.
    pub session: Session,
    /// Counts the maps that were on screen, over all sessions of this server.
    pub revision: u64,
    /// Counts the maps that were opened.
    pub map: u64,
    /// What the readers had to remark.
    pub remarks: Vec<String>,
}

/// Something that takes a while.
#[derive(Debug)]
struct Work {
    what: String,
    done: usize,
    of: usize,
    cancelled: Arc<AtomicBool>,
}

impl App {
    /// Nothing is open yet.
    pub fn new(token: String, folder: PathBuf) -> App {
        let view = json!({"map": null});
        let (news, _) = watch::channel(view::told(&view, Vec::new()));
        App {
            token,
            folder,
            desk: RwLock::new(None),
            view: Mutex::new(view),
            works: Mutex::default(),
            next: AtomicU64::new(1),
            shown: AtomicU64::new(0),
            judging: AtomicBool::new(false),
            told_at: Mutex::default(),
            news,
        }
    }

    /// The open session, to look at.
    pub fn read(&self) -> RwLockReadGuard<'_, Option<Desk>> {
        self.desk.read().unwrap_or_else(PoisonError::into_inner)
    }

    /// The open session, to change; tell the pages afterwards with [`App::show`].
    pub fn write(&self) -> RwLockWriteGuard<'_, Option<Desk>> {
        self.desk.write().unwrap_or_else(PoisonError::into_inner)
    }

    /// A number that was never given before.
    pub fn number(&self) -> u64 {
        self.next.fetch_add(1, Ordering::Relaxed)
    }

    /// Opens a map with its session, in place of what was open. If it fails, that stays.
    ///
    /// # Errors
    /// As [`front_end::open`] and [`Session::open`].
    pub fn open(&self, input: &Path, log: Option<&Path>) -> Result<()> {
        // A folder that hitl feetslam wrote: its paths.
        let folder = input.is_dir().then(|| input.join("paths.csv"));
        let input = folder.as_deref().unwrap_or(input);
        let name = input.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let work = self.begin(format!("opening {name}"));
        let source = Source::of(input)?;
        let read = front_end::open(input, crate::io::Indefinite::Refuse)?;
        if work.is_cancelled() {
            return Err(Error::input(name, "found that it was given up, expected to be opened"));
        }
        let log = log.map_or_else(|| session::log_path(&source), Path::to_path_buf);
        // The session that is open may be the one to be opened: it is closed first, and opened again if need be.
        let mut desk = self.write();
        let place = |p: &Path| std::fs::canonicalize(p).unwrap_or_else(|_| p.to_path_buf());
        if desk.as_ref().is_some_and(|d| place(d.session.log_path()) == place(&log)) {
            return Ok(());
        }
        let (session, more) =
            Session::open(read.value, source, &log, &mut |done, of| self.progress(work.id, done, of))?;
        let remarks = [read.warnings, more].concat();
        *desk = Some(Desk { session, revision: self.number(), map: self.number(), remarks });
        if let Some(desk) = &*desk {
            self.show(desk);
        }
        drop(desk);
        self.judge();
        Ok(())
    }

    /// Tells every page what the map is now.
    pub fn show(&self, desk: &Desk) {
        let mut new = view::of(desk);
        let mut view = lock(&self.view);
        view::inherit(&mut new, &view);
        *view = new;
        self.shown.store(desk.revision, Ordering::Relaxed);
        drop(view);
        self.tell();
    }

    /// Looks for corrections that contradict the rest, on a copy, and tells the pages: after every change, beside whatever
    /// else goes on, until the map on screen is judged.
    pub fn judge(&self) {
        // Whoever is at it already sees to the new map, too.
        while !self.judging.swap(true, Ordering::SeqCst) {
            let copied = self.read().as_ref().map(|desk| {
                let corrector = desk.session.solved().corrector();
                let has_any = !corrector.map().human_factors.is_empty();
                (desk.revision, has_any.then(|| corrector.map().clone()), corrector.options().joint)
            });
            let Some((revision, map, options)) = copied else {
                self.judging.store(false, Ordering::SeqCst);
                return;
            };
            let judged = map.map_or_else(|| Ok(Vec::new()), |map| view::contradictions_of(&map, &options));
            let mut view = lock(&self.view);
            if self.shows(revision) {
                view::judge(&mut view, &judged);
            }
            drop(view);
            self.tell();
            self.judging.store(false, Ordering::SeqCst);
            if self.shows(revision) {
                return;
            }
        }
    }

    /// True while the map of that revision is on screen.
    pub fn shows(&self, revision: u64) -> bool {
        self.shown.load(Ordering::Relaxed) == revision
    }

    fn tell(&self) {
        let works = lock(&self.works);
        let works = works.iter().map(|(id, w)| json!({"id": id, "what": w.what, "done": w.done, "of": w.of}));
        let works = works.collect();
        self.news.send_replace(view::told(&lock(&self.view), works));
    }

    /// What the pages were told last.
    pub fn told(&self) -> Arc<str> {
        self.news.borrow().clone()
    }

    /// What the pages will be told.
    pub fn listen(&self) -> watch::Receiver<Arc<str>> {
        self.news.subscribe()
    }

    /// Begins something that takes a while; it ends when the value is dropped.
    pub fn begin(&self, what: String) -> Working<'_> {
        let (id, cancelled) = (self.number(), Arc::new(AtomicBool::new(false)));
        lock(&self.works).insert(id, Work { what, done: 0, of: 0, cancelled: Arc::clone(&cancelled) });
        self.tell();
        Working { app: self, id, cancelled }
    }

    /// Says how far a work is; false: it is to be given up.
    fn progress(&self, id: u64, done: usize, of: usize) -> bool {
        let mut works = lock(&self.works);
        let Some(work) = works.get_mut(&id) else { return true };
        (work.done, work.of) = (done, of);
        let goes_on = !work.cancelled.load(Ordering::Relaxed);
        drop(works);
        let mut told_at = lock(&self.told_at);
        if told_at.is_none_or(|at| at.elapsed() >= BETWEEN_NEWS) {
            *told_at = Some(Instant::now());
            drop(told_at);
            self.tell();
        }
        goes_on
    }

    /// Asks for a work to be given up; false: there is none of that number.
    pub fn cancel(&self, id: u64) -> bool {
        let works = lock(&self.works);
        let work = works.get(&id);
        work.inspect(|w| w.cancelled.store(true, Ordering::Relaxed));
        work.is_some()
    }

    /// Gives everything up and lets the session go.
    pub fn close(&self) {
        lock(&self.works).values().for_each(|w| w.cancelled.store(true, Ordering::Relaxed));
    }
}

/// A work that is going on.
pub struct Working<'a> {
    app: &'a App,
    id: u64,
    cancelled: Arc<AtomicBool>,
}

impl Working<'_> {
    /// Says how far it is; false: it is to be given up.
    pub fn progress(&self, done: usize, of: usize) -> bool {
        self.app.progress(self.id, done, of)
    }

    /// True if it is to be given up.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

impl Drop for Working<'_> {
    fn drop(&mut self) {
        lock(&self.app.works).remove(&self.id);
        self.app.tell();
    }
}

/// A panic elsewhere must not stop the page.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
