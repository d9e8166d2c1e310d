//! What takes the place of the standard library.

/// Nothing that `pfront_core` does without the feature `std` panics, but for the SAH build, which selects medians as
/// `core` does. Were there a fault in it, there is nobody to tell.
#[cfg(not(any(feature = "std", test)))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
