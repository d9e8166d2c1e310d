// 128-bit two's complement integers of four limbs, lowest first; everything is modulo 2^128.

// The 64-bit product of two limbs.
fn product_of(x: u32, y: u32) -> vec2u {
    let low = vec2u(x & 0xffffu, y & 0xffffu);
    let high = vec2u(x >> 16u, y >> 16u);
    let lowest = low.x * low.y;
    let cross = high.x * low.y + (lowest >> 16u);
    let middle = low.x * high.y + (cross & 0xffffu);
    return vec2u(x * y, high.x * high.y + (cross >> 16u) + (middle >> 16u));
}

// The same of two's complement limbs.
fn product_of_signed(x: u32, y: u32) -> vec2u {
    let p = product_of(x, y);
    return vec2u(p.x, p.y - select(0u, y, x >= 0x80000000u) - select(0u, x, y >= 0x80000000u));
}

// A 64-bit number as one of 128 bits.
fn extended(x: vec2u) -> vec4u {
    return vec4u(x, vec2u(select(0u, 0xffffffffu, x.y >= 0x80000000u)));
}

fn add(x: vec4u, y: vec4u) -> vec4u {
    let sum = x + y;
    let carry = select(vec4u(0u), vec4u(1u), sum < x);
    // A limb that is all ones passes a carry on.
    let first = sum.y + carry.x;
    let second = carry.y | select(0u, 1u, first < carry.x);
    let third = sum.z + second;
    let fourth = carry.z | select(0u, 1u, third < second);
    return vec4u(sum.x, first, third, sum.w + fourth);
}

fn negative(x: vec4u) -> vec4u {
    return add(~x, vec4u(1u, 0u, 0u, 0u));
}

fn subtract(x: vec4u, y: vec4u) -> vec4u {
    return add(x, negative(y));
}

fn times_limb(x: vec4u, y: u32) -> vec4u {
    let p = product_of(x.x, y);
    let q = product_of(x.y, y);
    let r = product_of(x.z, y);
    return add(vec4u(p.x, q.x, r.x, x.w * y), vec4u(0u, p.y, q.y, r.y));
}

// Two's complement both.
fn times_signed_limb(x: vec4u, y: u32) -> vec4u {
    let product = times_limb(x, y);
    // A negative limb stands for y − 2^32.
    let excess = vec4u(0u, x.xyz);
    return select(product, subtract(product, excess), y >= 0x80000000u);
}

// For |y| < 2^64.
fn multiply(x: vec4u, y: vec4u) -> vec4u {
    let below = (y.w >> 31u) == 1u;
    let size = select(y, negative(y), below);
    let product = add(times_limb(x, size.x), vec4u(0u, times_limb(x, size.y).xyz));
    return select(product, negative(product), below);
}

fn sign_of(x: vec4u) -> i32 {
    if (x.w >> 31u) == 1u {
        return -1;
    }
    return select(0, 1, any(x != vec4u(0u)));
}
