//! CPU time of this process: unlike the wall clock it does not count the time that others have the core.

use rustix::time::{ClockId, clock_gettime};

/// Milliseconds of CPU time so far, all threads.
pub fn milliseconds() -> f64 {
    let now = clock_gettime(ClockId::ProcessCPUTime);
    now.tv_sec as f64 * 1e3 + now.tv_nsec as f64 * 1e-6
}

/// What a job gives back, and the CPU time that it took, ms.
pub fn timed<T>(job: impl FnOnce() -> T) -> (T, f64) {
    let begin = milliseconds();
    let value = job();
    (value, milliseconds() - begin)
}
