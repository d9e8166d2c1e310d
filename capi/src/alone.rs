//! The panic handler that takes the place of the standard library's.

/// Spins: an index was out of range in arrays that have changed since they were checked, or there is a fault in this library.
#[cfg(not(any(feature = "std", test)))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
