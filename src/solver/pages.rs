//! Memory in large pages: the first touch of every 4 KiB page of a fresh array costs as much as some thousand multiplications,
//! and a fresh factorisation touches thousands. Linux hands out 2 MiB at a time to whoever asks, where they begin.

const LARGE_PAGE: usize = 2 << 20;
const PAGE: usize = 4096;

/// At least so many zeros.
pub(crate) fn zeros(length: usize) -> Vec<f64> {
    in_large_pages(vec![0.0; filling::<f64>(length)])
}

/// Room for at least so many elements; what is in the vector is kept only if there is room already.
pub(crate) fn make_room<T>(memory: &mut Vec<T>, length: usize) {
    if memory.capacity() < length {
        *memory = in_large_pages(Vec::with_capacity(filling::<T>(length)));
    }
}

/// How many elements fill large pages, if so many fill at least half of one, but for the allocator's own few bytes: a mapping
/// of whole large pages is put where one begins.
fn filling<T>(length: usize) -> usize {
    let bytes = length * size_of::<T>();
    if bytes < LARGE_PAGE / 2 {
        return length;
    }
    ((bytes + PAGE).next_multiple_of(LARGE_PAGE) - PAGE) / size_of::<T>()
}

/// The same vector, its memory in large pages where the system has them to give. Nothing else changes: not its place, not
/// its contents.
fn in_large_pages<T>(memory: Vec<T>) -> Vec<T> {
    if memory.capacity() * size_of::<T>() > LARGE_PAGE / 2 {
        ask(&memory);
    }
    memory
}

#[cfg(target_os = "linux")]
fn ask<T>(memory: &Vec<T>) {
    let from = memory.as_ptr();
    let begin = (from as usize).next_multiple_of(PAGE);
    let end = (from as usize + memory.capacity() * size_of::<T>()) / PAGE * PAGE;
    let at = from.wrapping_byte_add(begin - from as usize).cast_mut().cast();
    // SAFETY: whole pages within this vector's own memory, and the advice changes nothing but what backs them. A system
    // that does not take it leaves everything as it is.
    #[allow(unsafe_code)]
    let _ = unsafe { rustix::mm::madvise(at, end - begin, rustix::mm::Advice::LinuxHugepage) };
}

#[cfg(not(target_os = "linux"))]
fn ask<T>(_memory: &Vec<T>) {}
