//! Memory in large pages: the first touch of every 4 KiB page of a fresh array costs as much as some 5,000 multiplications,
//! and a fresh factorisation touches thousands. Linux hands out 2 MiB at a time to whoever asks.

/// Smaller memory lies within one large page.
const LARGE_PAGE: usize = 2 << 20;

/// The same vector, its memory (also what it has not filled yet) in large pages where the system has them to give. Nothing else
/// changes: not its place, not its contents.
pub(crate) fn in_large_pages<T>(memory: Vec<T>) -> Vec<T> {
    if memory.capacity() * size_of::<T>() >= LARGE_PAGE {
        ask(&memory);
    }
    memory
}

#[cfg(target_os = "linux")]
fn ask<T>(memory: &Vec<T>) {
    const PAGE: usize = 4096;
    let from = memory.as_ptr() as usize;
    let start = from.next_multiple_of(PAGE);
    let end = (from + memory.capacity() * size_of::<T>()) / PAGE * PAGE;
    let start_of_pages = memory.as_ptr().wrapping_byte_add(start - from).cast_mut().cast();
    // SAFETY: whole pages within this vector's own memory, and the advice changes nothing but what backs them. A system
    // that does not take it leaves everything as it is.
    #[allow(unsafe_code)]
    let _ = unsafe { rustix::mm::madvise(start_of_pages, end - start, rustix::mm::Advice::LinuxHugepage) };
}

#[cfg(not(target_os = "linux"))]
fn ask<T>(_memory: &Vec<T>) {}
