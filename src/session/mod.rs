//! A person's work on a map, event by event: undo without end, and nothing lost.
//!
//! Every event is on disk before it counts ([`Log`]). What the events leave is a plain [`State`]: corrections in
//! order, where visits were matched with each other between them, settings, the wall that is to lie straight. The map is a function of the source map and that state alone
//! ([`Session`] solves only what changed, and gives the same bytes), so that undo is a step back in a list, a
//! correction can be switched off, reweighted or deleted at any time, and [`replay`] is the very same thing.

mod caution;
mod event;
mod history;
mod live;
mod log;
mod solved;
mod source;
mod steps;
mod straighten;
mod summary;

pub use event::{Entry, Event, Header, Matched, Result as EventResult};
pub use history::{Close, Closing, History, Plan, Settings, State, Todo};
pub use live::{Answer, Branch, Drawn, Look, Session, replay};
pub use log::{Content, Log, read};
pub use solved::Solved;
pub use source::{Source, is_session, log_path};
pub use steps::{Told, apply};
pub use straighten::world_from_map;
pub use summary::Summary;
