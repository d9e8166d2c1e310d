//! Real roots of polynomials with integer coefficients, and signs of others there: by Sturm sequences, without any rounding.

use num_bigint::BigInt;
use num_integer::Integer as _;
use num_traits::{One, Signed, Zero};
use std::cmp::Ordering;
use std::ops::{Add, Mul, Sub};

/// A time a / 2^k.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Dyadic {
    pub(super) numerator: BigInt,
    pub(super) exponent: u32,
}

impl Dyadic {
    fn middle(&self, other: &Self) -> Self {
        let exponent = self.exponent.max(other.exponent);
        let lifted = |x: &Self| &x.numerator << (exponent - x.exponent);
        Self { numerator: lifted(self) + lifted(other), exponent: exponent + 1 }
    }
}

/// A polynomial by its coefficients, the constant first and the last not zero; none is the zero polynomial.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Polynomial(Vec<BigInt>);

impl Polynomial {
    pub(super) fn new(mut coefficients: Vec<BigInt>) -> Self {
        while coefficients.last().is_some_and(Zero::is_zero) {
            coefficients.pop();
        }
        Self(coefficients)
    }

    pub(super) fn is_zero(&self) -> bool {
        self.0.is_empty()
    }

    fn degree(&self) -> usize {
        self.0.len().saturating_sub(1)
    }

    fn sign_at(&self, time: &Dyadic) -> i32 {
        // Σ cᵢ aⁱ 2^(k (n − i)), by Horner's rule from above.
        let mut value = BigInt::zero();
        for (i, c) in self.0.iter().rev().enumerate() {
            value = value * &time.numerator + (c << (time.exponent * i as u32));
        }
        sign(&value)
    }

    fn derivative(&self) -> Self {
        Self::new(self.0.iter().enumerate().skip(1).map(|(i, c)| c * BigInt::from(i)).collect())
    }

    /// The coefficients without the positive factor that they have in common.
    fn primitive(self) -> Self {
        let content = self.0.iter().fold(BigInt::zero(), |g, c| g.gcd(c));
        if content <= BigInt::one() {
            return self;
        }
        Self(self.0.into_iter().map(|c| c / &content).collect())
    }

    /// The quotient and the remainder of a positive multiple of this by `other`.
    fn divided(&self, other: &Self) -> (Self, Self) {
        let Some(lead) = other.0.last() else { return (Self(Vec::new()), self.clone()) };
        let mut rest = self.0.clone();
        let mut quotient = vec![BigInt::zero(); self.0.len()];
        while rest.len() >= other.0.len() {
            let shift = rest.len() - other.0.len();
            let (top, factor) = (&rest[rest.len() - 1] * lead.signum(), lead.abs());
            rest.iter_mut().chain(&mut quotient).for_each(|c| *c *= &factor);
            for (c, o) in rest[shift..].iter_mut().zip(&other.0) {
                *c -= &top * o;
            }
            quotient[shift] += &top;
            rest = Self::new(rest).0;
            if rest.is_empty() {
                break;
            }
        }
        (Self::new(quotient), Self::new(rest))
    }

    fn gcd(&self, other: &Self) -> Self {
        let (mut p, mut q) = (self.clone(), other.clone());
        while !q.is_zero() {
            let rest = p.divided(&q).1.primitive();
            (p, q) = (q, rest);
        }
        p
    }

    /// The same with each root once, and its Sturm sequence.
    pub(super) fn sturm(&self) -> Sturm {
        let common = self.gcd(&self.derivative());
        let once = self.divided(&common).0.primitive();
        let mut sequence = vec![once.derivative()];
        sequence.insert(0, once);
        while sequence[sequence.len() - 1].degree() > 0 {
            let rest = sequence[sequence.len() - 2].divided(&sequence[sequence.len() - 1]).1;
            if rest.is_zero() {
                break;
            }
            sequence.push(Self(rest.0.into_iter().map(|c| -c).collect()).primitive());
        }
        Sturm { sequence, of: self.clone() }
    }
}

/// A polynomial that is not zero and its Sturm sequence.
#[derive(Clone, Debug)]
pub(super) struct Sturm {
    sequence: Vec<Polynomial>,
    of: Polynomial,
}

impl Sturm {
    /// The number of different roots after `from` and up to `to`.
    fn count(&self, from: &Dyadic, to: &Dyadic) -> usize {
        let variations = |time: &Dyadic| {
            let signs: Vec<_> =
                self.sequence.iter().map(|p| p.sign_at(time)).filter(|&s| s != 0).collect();
            signs.windows(2).filter(|s| s[0] != s[1]).count()
        };
        variations(from) - variations(to)
    }

    /// The roots after `from` and up to `to`.
    pub(super) fn roots(&self, from: &Dyadic, to: &Dyadic) -> Vec<Time> {
        match self.count(from, to) {
            0 => Vec::new(),
            1 => vec![Time::Root { of: self.clone(), from: from.clone(), to: to.clone() }],
            _ => {
                let middle = from.middle(to);
                let mut roots = self.roots(from, &middle);
                roots.extend(self.roots(&middle, to));
                roots
            }
        }
    }
}

/// A time: dyadic, or the only root of a polynomial after a dyadic time and up to another.
#[derive(Clone, Debug)]
pub(super) enum Time {
    At(Dyadic),
    Root { of: Sturm, from: Dyadic, to: Dyadic },
}

impl Time {
    /// The sign of a polynomial at this time. A root is narrowed down by it.
    pub(super) fn sign(&mut self, p: &Polynomial) -> i32 {
        match self {
            _ if p.is_zero() => 0,
            Self::At(time) => p.sign_at(time),
            Self::Root { of, from, to } => {
                let common = of.of.gcd(p);
                if common.degree() > 0 && common.sturm().count(from, to) > 0 {
                    return 0;
                }
                let own = p.sturm();
                while own.count(from, to) > 0 {
                    let middle = from.middle(to);
                    match of.count(from, &middle) {
                        0 => *from = middle,
                        _ => *to = middle,
                    }
                }
                p.sign_at(to)
            }
        }
    }
}

pub(super) fn sign(x: &BigInt) -> i32 {
    match x.cmp(&BigInt::zero()) {
        Ordering::Less => -1,
        Ordering::Equal => 0,
        Ordering::Greater => 1,
    }
}

impl Add for &Polynomial {
    type Output = Polynomial;
    fn add(self, other: Self) -> Polynomial {
        let (long, short) =
            if self.0.len() < other.0.len() { (other, self) } else { (self, other) };
        let mut sum = long.0.clone();
        sum.iter_mut().zip(&short.0).for_each(|(x, y)| *x += y);
        Polynomial::new(sum)
    }
}

impl Sub for &Polynomial {
    type Output = Polynomial;
    fn sub(self, other: Self) -> Polynomial {
        let negative = Polynomial(other.0.iter().map(|c| -c).collect());
        self.add(&negative)
    }
}

impl Mul for &Polynomial {
    type Output = Polynomial;
    fn mul(self, other: Self) -> Polynomial {
        let mut product = vec![BigInt::zero(); self.0.len() + other.0.len()];
        for (i, x) in self.0.iter().enumerate() {
            for (j, y) in other.0.iter().enumerate() {
                product[i + j] += x * y;
            }
        }
        Polynomial::new(product)
    }
}
