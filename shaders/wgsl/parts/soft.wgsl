// f32 product and sum in integers, rounded to nearest, ties to even, subnormal numbers kept: for
// adapters whose own arithmetic is another. Operands are finite.

const SIGN = 0x80000000u;

struct Parts {
    // value = significand · 2^(exponent − 150), and bit 23 is the highest, or all are 0.
    significand: u32,
    exponent: i32,
}

fn parts_of(x: u32) -> Parts {
    let biased = (x >> 23u) & 0xffu;
    let fraction = x & 0x7fffffu;
    if biased != 0u {
        return Parts(fraction | 0x800000u, i32(biased));
    }
    let up = countLeadingZeros(fraction) - 8u;
    return Parts(select(fraction << (up & 31u), 0u, fraction == 0u), 1 - i32(up));
}

// The f32 nearest to ±m · 2^e, for 0 < m < 2^31. Bit 0 of m may stand for anything below it, if m
// has at least 26 bits.
fn rounded(sign: u32, m: u32, e: i32) -> u32 {
    let up = i32(countLeadingZeros(m)) - 1;
    let q = m << u32(up);
    let biased = e - up + 30 + 127;
    if biased >= 255 {
        return sign | 0x7f800000u;
    }
    // Below the normal range, fewer bits are left.
    let drop = u32(clamp(8 - biased, 7, 32));
    if drop == 32u {
        return sign;
    }
    let kept = q >> drop;
    let lost = q & ((1u << drop) - 1u);
    let half = 1u << (drop - 1u);
    let round_up = lost > half || (lost == half && (kept & 1u) == 1u);
    let base = u32(max(biased - 1, 0)) << 23u;
    return sign | (base + kept + select(0u, 1u, round_up));
}

fn soft_times(x: u32, y: u32) -> u32 {
    let sign = (x ^ y) & SIGN;
    let p = parts_of(x);
    let q = parts_of(y);
    if p.significand == 0u || q.significand == 0u {
        return sign;
    }
    // 47 or 48 bits, of which the lowest 18 are told by one.
    let product = product_of(p.significand, q.significand);
    let sticky = select(0u, 1u, (product.x & 0x3ffffu) != 0u);
    let top = (product.y << 14u) | (product.x >> 18u);
    return rounded(sign, top | sticky, p.exponent + q.exponent - 300 + 18);
}

fn soft_plus(x: u32, y: u32) -> u32 {
    let swap = (x & ~SIGN) < (y & ~SIGN);
    let large = select(x, y, swap);
    let small = select(y, x, swap);
    let p = parts_of(large);
    let q = parts_of(small);
    if p.significand == 0u {
        return x & y;
    }
    let own = p.significand << 6u;
    let other = q.significand << 6u;
    let distance = u32(min(p.exponent - q.exponent, 30));
    let moved = other >> distance;
    let aligned = moved | select(0u, 1u, (moved << distance) != other);
    if ((large ^ small) & SIGN) == 0u {
        return rounded(large & SIGN, own + aligned, p.exponent - 156);
    }
    if own == aligned {
        return 0u;
    }
    return rounded(large & SIGN, own - aligned, p.exponent - 156);
}
