//! Plays the scene on a Cortex-M4 and prints each frame over semihosting.

#![no_std]
#![no_main]

use core::arch::asm;
use core::panic::PanicInfo;
use cortex_m_rt::STACK_PAINT_VALUE;
use scene::{Line, Memory, play};
use semihosting::process;
use semihosting::sys::arm_compat::sys_write0;

#[cortex_m_rt::entry]
fn main() -> ! {
    static mut MEMORY: Memory = Memory::ZERO;
    #[cfg(feature = "overflow")]
    core::hint::black_box(deeper(core::hint::black_box(0)));
    let played = play(MEMORY, |_, line| sys_write0(line.as_c_str()));
    let [used, room] = stack();
    let line = Line::EMPTY.with(used, " of ").with(room, " bytes of stack used, ");
    sys_write0(line.with(size_of::<Memory>() as u32, " of other memory\n").as_c_str());
    process::exit(i32::from(played.is_err() || used == room))
}

/// Uses more stack than there is, to see that it is told.
#[cfg(feature = "overflow")]
#[inline(never)]
fn deeper(depth: u32) -> u32 {
    let page = core::hint::black_box([depth; 64]);
    if depth == u32::MAX {
        return depth;
    }
    deeper(depth + 1) + page[core::hint::black_box(depth as usize % 64)]
}

/// How many bytes of stack were in use at any time, as far as its paint is gone, and how many there are.
#[expect(unsafe_code, reason = "reads what lies below the stack")]
fn stack() -> [u32; 2] {
    unsafe extern "C" {
        static _stack_end: u32;
        static _stack_start: u32;
    }
    let (end, start) = (&raw const _stack_end, &raw const _stack_start);
    let mut free = end;
    // SAFETY: the linker script puts both into RAM at whole words, and none in between is out of bounds.
    while free < start && unsafe { free.read_volatile() } == STACK_PAINT_VALUE {
        free = free.wrapping_add(1);
    }
    [free, end].map(|from| (start.addr() - from.addr()) as u32)
}

/// Ends the program with a word: most likely the stack has left its memory, which lies below all other (memory.x).
///
/// The stack pointer begins anew, since there is no memory where it is.
#[cortex_m_rt::exception(trampoline = false)]
#[expect(unsafe_code, reason = "a fault may leave no stack to call from")]
unsafe fn HardFault() -> ! {
    // SAFETY: nothing of the stack is used again, and the linker script puts its start at a multiple of 8 in RAM.
    unsafe {
        asm!(
            "ldr r0, =_stack_start",
            "mov sp, r0",
            "bl {faulted}",
            faulted = sym faulted,
            options(noreturn)
        )
    }
}

extern "C" fn faulted() -> ! {
    sys_write0(c"fault: the stack is too small, or memory is not there\n");
    process::abort()
}

/// Ends the program: an index was out of range in arrays that nobody checked.
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    process::abort()
}
