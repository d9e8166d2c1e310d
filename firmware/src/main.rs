//! Plays the scene on a Cortex-M4 and prints each frame over semihosting.

#![no_std]
#![no_main]

use core::panic::PanicInfo;
use cortex_m_rt::STACK_PAINT_VALUE;
use scene::{Line, Memory, play};
use semihosting::process;
use semihosting::sys::arm_compat::sys_write0;

#[cortex_m_rt::entry]
fn main() -> ! {
    static mut MEMORY: Memory = Memory::ZERO;
    let played = play(MEMORY, |_, line| sys_write0(line.as_c_str()));
    let [used, room] = stack();
    let line = Line::EMPTY.with(used, " of ").with(room, " bytes of stack used, ");
    sys_write0(line.with(size_of::<Memory>() as u32, " of other memory\n").as_c_str());
    process::exit(i32::from(played.is_err() || used == room))
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

/// Ends the program: an index was out of range in arrays that nobody checked.
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    process::abort()
}
