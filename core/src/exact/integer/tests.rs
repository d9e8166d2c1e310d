//! Signs in f32 and f64 against integers of any length.

extern crate std;

use super::*;
use crate::exact::filter64;
use crate::exact::orientation::{orient2d, sides};
use crate::scalar::LIMIT;
use num_bigint::BigInt;
use pfront_testkit::rng::{Rng, RngExt, seeded};

/// 2^exponent, subnormal or 0 where that is so small.
fn power(exponent: i32) -> f64 {
    if exponent >= -1022 {
        f64::from_bits(((1023 + exponent) as u64) << 52)
    } else {
        f64::from_bits(1u64.checked_shl((exponent + 1074) as u32).unwrap_or(0))
    }
}

/// The value in units of the smallest f64, by nothing of the code under test.
fn integer(x: f64) -> BigInt {
    let bits = x.abs().to_bits();
    let (exponent, fraction) = (bits >> 52, bits & ((1 << 52) - 1));
    let magnitude = match exponent {
        0 => BigInt::from(fraction),
        _ => BigInt::from(fraction + (1 << 52)) << (exponent - 1),
    };
    if x < 0.0 { -magnitude } else { magnitude }
}

fn sign(x: &BigInt) -> i32 {
    i32::from(*x > BigInt::ZERO) - i32::from(*x < BigInt::ZERO)
}

fn true_side(p: &[[f64; 3]; 4]) -> i32 {
    let edge = |i: usize| [0, 1, 2].map(|k| integer(p[i][k]) - integer(p[0][k]));
    let [u, v, w] = [edge(1), edge(2), edge(3)];
    let minor = |i: usize, j: usize| &u[i] * &v[j] - &u[j] * &v[i];
    sign(&(&w[0] * minor(1, 2) + &w[1] * minor(2, 0) + &w[2] * minor(0, 1)))
}

fn true_turn([a, b, c]: [[f64; 2]; 3]) -> i32 {
    let edge = |p: [f64; 2], k: usize| integer(p[k]) - integer(a[k]);
    sign(&(edge(b, 0) * edge(c, 1) - edge(b, 1) * edge(c, 0)))
}

/// A finite value of any bits, at most 2^125.
fn any_bits(rng: &mut impl Rng) -> f64 {
    loop {
        let x = f64::from_bits(rng.random());
        if x.abs() <= LIMIT {
            return x;
        }
    }
}

/// How many families [`points`] has.
const FAMILIES: usize = 10;

/// Four points of a family that is hard in its own way.
fn points(family: usize, rng: &mut impl Rng) -> [[f64; 3]; 4] {
    let lattice = |rng: &mut _, reach: i64| -> [[f64; 3]; 4] {
        [[0.0; 3]; 4].map(|p| p.map(|_| RngExt::random_range(rng, -reach..=reach) as f64))
    };
    let mut p = match family {
        0 => lattice(rng, 3),
        1 => lattice(rng, 1 << 25),
        2 => lattice(rng, 1 << 52),
        3 => return [[0.0; 3]; 4].map(|p| p.map(|_| any_bits(rng))),
        4 => {
            return [[0.0; 3]; 4]
                .map(|p| p.map(|_| power(-1074) * rng.random_range(-9..=9) as f64));
        }
        _ => {
            // Near a plane: a sum of the edges, rounded.
            let mut p = [[0.0; 3]; 4].map(|p| p.map(|_| rng.random_range(-1.0..1.0)));
            let (s, t) = (rng.random_range(-2.0..2.0), rng.random_range(-2.0..2.0));
            p[3] = [0, 1, 2].map(|k| p[0][k] + (s * (p[1][k] - p[0][k]) + t * (p[2][k] - p[0][k])));
            p
        }
    };
    // Scales of each axis, so that differences of one are subnormal beside those of another.
    let scales = [0; 3].map(|_| match family {
        0..=2 => power(rng.random_range(-1074..=70)),
        6 => power(rng.random_range(-1074..=120)),
        _ => 1.0,
    });
    let offset = [0; 3].map(|_| if family == 7 { 1e7 * rng.random_range(-1.0..1.0) } else { 0.0 });
    for point in &mut p {
        for k in 0..3 {
            point[k] = point[k] * scales[k] + offset[k];
            let noise = rng.random_range(-1..=1_i64) as u64;
            if family >= 8 && point[k] != 0.0 {
                point[k] = f64::from_bits(point[k].to_bits().wrapping_add(noise));
            }
        }
    }
    if family == 9 {
        // One coordinate in common, as flush faces have it, one point far out.
        let far = rng.random_range(0..4);
        p[far] = p[far].map(|x| x * power(100));
        p[(far + 1) % 4][0] = p[(far + 2) % 4][0];
    }
    p
}

/// `PFRONT_ROUNDS` sets how many of each family are drawn.
fn rounds() -> usize {
    let asked = std::env::var("PFRONT_ROUNDS").ok().and_then(|text| text.parse().ok());
    asked.unwrap_or(if cfg!(miri) { 3 } else { 20_000 })
}

#[test]
fn signs_are_those_of_long_integers() {
    let mut rng = seeded(64);
    let mut seen = [0_usize; 5];
    for family in 0..FAMILIES {
        for _ in 0..rounds() {
            let p = points(family, &mut rng);
            let [a, b, c, d] = &p;
            let truth = true_side(&p);
            let [filtered] = filter64::orient3d([a, b, c], [d]);
            assert!(filtered == 0 || filtered == truth, "{family}: {p:?}");
            assert_eq!(sides([a, b, c], [d]), [truth], "{family}: {p:?}");
            // Every later stage decides as well what an earlier one would have.
            let axes = [0, 1, 2].map(|k| Axis::new(p.map(|p| p[k])));
            assert_eq!(wide_sign::<LIMBS_IN_F64>(&axes), truth, "{family}: {p:?}");
            let narrow = axes.each_ref().map(Axis::narrow);
            seen[0] += usize::from(filtered != 0);
            if let [Some(x), Some(y), Some(z)] = narrow {
                assert_eq!(narrow_sign([x, y, z]), truth, "{family}: {p:?}");
                seen[1] += 1;
            }
            if fit::<f64, _>(&axes) {
                assert_eq!(wide_sign::<LIMBS>(&axes), truth, "{family}: {p:?}");
                seen[2] += 1;
            } else {
                seen[3] += 1;
            }
            seen[4] += usize::from(truth == 0);
            let flat = [p[0], p[1], p[2]].map(|[x, y, _]| [x, y]);
            assert_eq!(orient2d(&flat[0], &flat[1], &flat[2]), true_turn(flat), "{family}: {p:?}");
        }
    }
    assert!(cfg!(miri) || seen.iter().all(|&count| count > rounds() / 50), "{seen:?}");
}

/// The constant times the first extent would underflow and take the bound with it.
#[test]
fn bounds_do_not_underflow_beside_large_extents() {
    let mut rng = seeded(65);
    for _ in 0..rounds() {
        let scales = [power(-1030), power(120), 1.0];
        let mut p = points(5, &mut rng);
        p.iter_mut().for_each(|p| (0..3).for_each(|k| p[k] *= scales[k]));
        let [a, b, c, d] = &p;
        let [filtered] = filter64::orient3d([a, b, c], [d]);
        assert!(filtered == 0 || filtered == true_side(&p), "{p:?}");
    }
}

/// The longest determinants: corners at the limit, and others one smallest step off.
#[test]
fn the_largest_determinants_keep_their_sign() {
    let least = power(-1074);
    let p = [[-LIMIT; 3], [LIMIT, least, -LIMIT], [-LIMIT, LIMIT, least], [least, least, LIMIT]];
    let [a, b, c, d] = &p;
    assert_eq!(sides([a, b, c], [d]), [true_side(&p)]);
    assert_eq!(sides([a, c, b], [d]), [-true_side(&p)]);
    let [o, x, y] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    for (z, side) in [(least, 1), (0.0, 0), (-least, -1)] {
        assert_eq!(sides([&o, &x, &y], [&[0.25, 0.25, z]]), [side]);
    }
    let flat = [[-LIMIT; 2], [LIMIT, least], [least, LIMIT]];
    assert_eq!(orient2d(&flat[0], &flat[1], &flat[2]), true_turn(flat));
}

/// 7 MAX³ in units of the least f32 fills nearly all limbs.
#[test]
fn the_largest_determinants_in_f32_keep_their_sign() {
    let (max, least) = (f32::MAX, f32::from_bits(1));
    let (a, b) = ([-max; 3], [max, least, -max]);
    let (c, d) = ([-max, max, least], [least, least, max]);
    assert_eq!([orient3d([&a, &b, &c], &d), orient3d([&a, &c, &b], &d)], [1, -1]);
}

#[test]
fn ratios_and_normals_of_any_size() {
    for size in [2f32.powi(-148), 2f32.powi(-100), 2f32.powi(-20), 1.0, 2f32.powi(120)] {
        ratio_and_normals(size);
    }
    for exponent in [-1073, -1000, -20, 0, 120] {
        ratio_and_normals(power(exponent));
    }
}

fn ratio_and_normals<C: Scalar>(size: C) {
    let zero = C::from(0.0);
    let times = |x: f64| C::point(DVec3::splat(size.into() * x))[0];
    let (o, x, y) = ([zero; 3], [size, zero, zero], [zero, size, zero]);
    for (p, q) in [(1.0, -3.0), (-0.5, 1.5), (2.0, -6.0)] {
        let [p, q] = [p, q].map(|z| [size, size, times(z)]);
        assert_eq!(orient3d_ratio([&o, &x, &y], &p, &q), 0.25);
    }
    let normal = |t: [&[C; 3]; 3]| {
        let normal = direction_of_normal(t);
        normal / normal.abs().max_element()
    };
    let (z, far) = ([size, zero, size], [times(-1.0), zero, zero]);
    assert_eq!(normal([&o, &x, &y]), DVec3::Z);
    assert_eq!(normal([&x, &z, &[size; 3]]), DVec3::NEG_X);
    assert_eq!(normal([&x, &far, &[zero, zero, size]]), DVec3::Y);
    assert_eq!(direction_of_normal([&o, &x, &[times(2.0), zero, zero]]), DVec3::ZERO);
}

#[cfg(feature = "relation")]
#[test]
fn ratios_compare_as_those_of_integers() {
    let determinant = |p: &[[f64; 3]; 5], end: usize| {
        let edge = |i: usize| [0, 1, 2].map(|k| integer(p[i][k]) - integer(p[0][k]));
        let [u, v, w] = [edge(1), edge(2), edge(end)];
        let minor = |i: usize, j: usize| &u[i] * &v[j] - &u[j] * &v[i];
        &w[0] * minor(1, 2) + &w[1] * minor(2, 0) + &w[2] * minor(0, 1)
    };
    let (mut rng, mut counts) = (seeded(48), [0; 3]);
    for round in 0..if cfg!(miri) { 20 } else { 4_000 } {
        let five = |rng: &mut _| {
            let [a, b, c, d] = points(round % FAMILIES, rng);
            let mut five = [a, b, c, d, points(round % FAMILIES, rng)[0]];
            if round % 4 == 0 {
                five.iter_mut().for_each(|p| p[1] *= 0.5);
            }
            five
        };
        let first = five(&mut rng);
        let mut second = if rng.random_range(0..3) > 0 { five(&mut rng) } else { first };
        if rng.random_range(0..2) == 0 {
            second.swap(0, 1);
        }
        let [(d0, e0), (d1, e1)] =
            [&first, &second].map(|p| (determinant(p, 3), determinant(p, 4)));
        let [mut over0, mut under0, mut over1, mut under1] =
            [d0.clone(), d0 - e0, d1.clone(), d1 - e1];
        if under0 == BigInt::ZERO || under1 == BigInt::ZERO {
            continue;
        }
        if under0 < BigInt::ZERO {
            (over0, under0) = (-over0, -under0);
        }
        if under1 < BigInt::ZERO {
            (over1, under1) = (-over1, -under1);
        }
        let truth = (over0 * under1).cmp(&(over1 * under0));
        let found = compare_orient3d_ratios(first.each_ref(), second.each_ref());
        assert_eq!(found, truth, "{first:?} {second:?}");
        counts[(truth as i32 + 1) as usize] += 1;
    }
    assert!(cfg!(miri) || counts.iter().all(|&n| n > 300), "{counts:?}");
}
