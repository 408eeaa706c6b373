//! Run-time dispatch: the same code compiled for wider vectors, used where the processor has them. Users need no
//! `target-cpu`; the bytes are the same everywhere (see [`super::kernels`]).

/// Defines a function that runs its body compiled for the widest vectors of this machine.
macro_rules! wide {
    ($(#[$doc:meta])* $view:vis fn $name:ident($($arg:ident: $type:ty),* $(,)?) $body:block) => {
        $(#[$doc])*
        $view fn $name($($arg: $type),*) {
            #[inline(always)]
            fn portable($($arg: $type),*) $body

            #[cfg(target_arch = "x86_64")]
            #[target_feature(enable = "avx2")]
            fn with_avx2($($arg: $type),*) {
                portable($($arg),*);
            }

            #[cfg(target_arch = "x86_64")]
            if std::arch::is_x86_feature_detected!("avx2") {
                // SAFETY: the processor has AVX2.
                #[allow(unsafe_code)]
                return unsafe { with_avx2($($arg),*) };
            }
            portable($($arg),*);
        }
    };
}

pub(crate) use wide;
