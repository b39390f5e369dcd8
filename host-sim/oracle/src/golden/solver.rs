//! `solver.v` of `firmware/fpga`, to the bit: its programs, and what they compute.
//!
//! Numbers have 32 bits, of which [`FRACTION`] follow the point.

/// Rows of the matrix.
pub const L: usize = 8;
/// Bits after the point.
pub const FRACTION: u32 = 26;
/// 1.
pub const ONE: i64 = 1 << FRACTION;

// Places in the solver's memory: the matrix's lower triangle, then these.
pub const A: usize = 36;
pub const DATA: [usize; 2] = [A + L, A + 2 * L];
pub const SCALE: usize = 60;
const CORRECTION: usize = 61;
const SEED: usize = 62;
const NOTHING: usize = 63;
const FACTOR: usize = 64;
const RECIPROCAL: usize = 96;
const WEIGHT: usize = 104;
const POWER: usize = 112;
pub const SUM: [usize; 2] = [113, 114];
/// Twice the sum of all elements.
pub const TOTAL: [usize; 2] = [115, 116];

pub fn matrix(i: usize, j: usize) -> usize {
    i * (i + 1) / 2 + j
}

fn factor(i: usize, j: usize) -> usize {
    FACTOR + i * (i - 1) / 2 + j
}

/// One term of a sum of products.
#[derive(Clone, Copy, Default)]
pub struct Term {
    a: usize,
    /// `None`: 1.
    b: Option<usize>,
    negative: bool,
    /// Place of the sum, after its last term.
    to: Option<usize>,
    /// Times 4.
    up: bool,
    /// Plus 2, for sums in [−2, 0).
    two: bool,
    /// The exponent is that of `a`.
    keep: bool,
    /// The reciprocal of `a`, to 10 bits, instead of the sum.
    reciprocal: bool,
    /// The sum is also a part of the output, by the lowest bit of its place.
    output: bool,
}

/// Clocks from a number's reading to the first in which the result can be read.
const LATENCY: usize = 12;
const CONTEXTS: usize = 8;

/// Sums in their order. Each is computed for eight samples before the next begins.
#[derive(Default)]
struct Program {
    terms: Vec<Term>,
    /// First clock, place and number of terms of each sum.
    written: Vec<(usize, usize, usize)>,
    clock: usize,
}

impl Program {
    /// `to = Σ ±a·b`, not before its operands can be read.
    fn sum(&mut self, to: usize, terms: &[(bool, usize, Option<usize>)], last: Term) {
        let length = terms.len();
        let late = |clock: usize| {
            let reads = |(at, &(_, a, b)): (usize, &(bool, usize, Option<usize>))| {
                self.written.iter().any(|&(first, place, count)| {
                    let written = |context| first + (context + 1) * count - 1 + LATENCY;
                    (place == a || Some(place) == b)
                        && [0, CONTEXTS - 1]
                            .into_iter()
                            .any(|context| clock + context * length + at < written(context))
                })
            };
            terms.iter().enumerate().any(reads)
        };
        if late(self.clock) {
            self.sum(NOTHING, &[(false, SCALE, None)], Term::default());
            return self.sum(to, terms, last);
        }
        for (k, &(negative, a, b)) in terms.iter().enumerate() {
            let is_last = k + 1 == length;
            self.terms.push(Term {
                a,
                b,
                negative,
                to: is_last.then_some(to),
                ..if is_last { last } else { Term::default() }
            });
        }
        self.written.retain(|&(_, place, _)| place != to);
        self.written.push((self.clock, to, length));
        self.clock += CONTEXTS * length;
    }

    fn product(&mut self, to: usize, a: usize, b: usize) {
        self.sum(to, &[(false, a, Some(b))], Term::default());
    }

    /// The three steps of a reciprocal: 10 bits from a table, then one step of Newton's method.
    fn reciprocal(&mut self, step: usize, to: usize, a: usize) {
        let last = Term {
            reciprocal: step == 0,
            two: step == 1,
            keep: step == 2,
            ..Term::default()
        };
        match step {
            0 => self.sum(SEED, &[(false, a, None)], last),
            1 => self.sum(CORRECTION, &[(true, a, Some(SEED))], last),
            _ => self.sum(to, &[(false, SEED, Some(CORRECTION))], last),
        }
    }
}

/// The programs of rank-1 ESMV, MV and DAS.
///
/// The first goes on with the second's terms.
pub fn programs() -> [Vec<Term>; 3] {
    [rank1(), mv(), das()]
}

/// Four times the scaled sum of all elements.
fn das() -> Vec<Term> {
    let mut p = Program::default();
    p.sum(NOTHING, &[(false, SCALE, None)], Term::default());
    for (sum, total) in SUM.into_iter().zip(TOTAL) {
        let output = Term {
            output: true,
            ..Term::default()
        };
        p.sum(sum, &[(false, total, None); 2], output);
    }
    p.terms
}

/// Steps of power iteration.
pub const STEPS: usize = 8;
/// The coordinate from which they start.
///
/// It is the sum of the middle elements, which waves turn least.
pub const START: usize = L - 2;

/// The data's projection onto the dominant eigenvector v, `v·(v·s)/(v·v)`, before MV's program.
///
/// The first vector is the column of [`START`] over nine times its diagonal entry. The length of a product `Rv` is then
/// divided by `v·Rv/s₀`, with `s₀` the first vector's `v·v`: lengths then rise only as the directions turn. With Δ from
/// 0.05 on, `v·v` is below 2.
fn rank1() -> Vec<Term> {
    const V: usize = FACTOR;
    const NEXT: usize = FACTOR + L;
    const LENGTH: usize = TOTAL[0];
    const SHARE: usize = TOTAL[1];
    let mut p = Program::default();
    let plain = Term::default();
    let kept = Term {
        keep: true,
        ..plain
    };
    let entry = |i: usize, k: usize| matrix(i.max(k), i.min(k));
    let dot = |a: usize, b: usize| -> Vec<(bool, usize, Option<usize>)> {
        (0..L).map(|k| (false, a + k, Some(b + k))).collect()
    };
    p.sum(NOTHING, &[(false, SCALE, None)], plain);
    p.reciprocal(0, SEED, matrix(START, START));
    p.sum(SHARE, &[(false, SEED, Some(SCALE))], kept);
    (0..L).for_each(|i| p.product(V + i, entry(i, START), SHARE));
    p.sum(LENGTH, &dot(V, V), plain);
    for _ in 1..STEPS {
        for i in 0..L {
            let row: Vec<_> = (0..L).map(|k| (false, V + k, Some(entry(i, k)))).collect();
            p.sum(NEXT + i, &row, plain);
        }
        p.sum(POWER, &dot(V, NEXT), plain);
        p.reciprocal(0, SEED, POWER);
        p.sum(SHARE, &[(false, SEED, Some(LENGTH))], kept);
        (0..L).for_each(|i| p.product(V + i, NEXT + i, SHARE));
    }
    p.sum(POWER, &dot(V, V), plain);
    for (step, (sum, data)) in SUM.into_iter().zip(DATA).enumerate() {
        p.reciprocal(step, RECIPROCAL, POWER);
        p.sum(sum, &dot(data, V), plain);
    }
    p.reciprocal(2, RECIPROCAL, POWER);
    SUM.into_iter()
        .for_each(|sum| p.sum(sum, &[(false, RECIPROCAL, Some(sum))], kept));
    for (sum, data) in SUM.into_iter().zip(DATA) {
        (0..L).for_each(|i| p.product(data + i, V + i, sum));
    }
    // Its first sum is of nothing, and the data are read far later than they can be.
    p.terms.extend(mv());
    p.terms
}

/// `LDLᵀ`, `y = L⁻¹a`, `L⁻¹s`, and `Σ y·s/d / Σ y²/d`.
///
/// Column by column, with the right sides while its reciprocal is computed.
fn mv() -> Vec<Term> {
    let mut p = Program::default();
    let plain = Term::default();
    p.sum(NOTHING, &[(false, SCALE, None)], plain);
    for j in 0..L {
        for k in 0..j {
            p.product(factor(j, k), matrix(j, k), RECIPROCAL + k);
        }
        let reduced = |p: &mut Program, place: usize, of: &dyn Fn(usize) -> usize| {
            let mut terms = vec![(false, place, None)];
            terms.extend((0..j).map(|k| (true, of(k), Some(factor(j, k)))));
            if j > 0 {
                p.sum(place, &terms, plain);
            }
        };
        reduced(&mut p, matrix(j, j), &|k| matrix(j, k));
        reduced(&mut p, A + j, &|k| A + k);
        for (step, data) in DATA.into_iter().enumerate() {
            p.reciprocal(step, RECIPROCAL + j, matrix(j, j));
            reduced(&mut p, data + j, &|k| data + k);
        }
        p.reciprocal(2, RECIPROCAL + j, matrix(j, j));
        for i in j + 1..L {
            reduced(&mut p, matrix(i, j), &|k| matrix(i, k));
        }
        p.product(WEIGHT + j, A + j, RECIPROCAL + j);
    }
    let along = |vector: usize| -> Vec<(bool, usize, Option<usize>)> {
        (0..L)
            .map(|k| (false, vector + k, Some(WEIGHT + k)))
            .collect()
    };
    p.sum(POWER, &along(A), Term { up: true, ..plain });
    for (step, (sum, data)) in SUM.into_iter().zip(DATA).enumerate() {
        p.sum(sum, &along(data), plain);
        p.reciprocal(step, RECIPROCAL, POWER);
        p.product(sum, sum, SCALE);
    }
    p.reciprocal(2, RECIPROCAL, POWER);
    for sum in SUM {
        let output = Term {
            output: true,
            ..plain
        };
        p.sum(sum, &[(false, sum, Some(RECIPROCAL))], output);
    }
    p.terms
}

impl Term {
    /// As `solver.v` reads it, with the number of terms of the `next` sum.
    fn word(&self, next: usize) -> u64 {
        let flags = [
            self.b.is_none(),
            self.negative,
            self.to.is_some(),
            self.up,
            self.two,
            self.keep,
            self.reciprocal,
            self.output,
        ];
        let flags = flags
            .iter()
            .rev()
            .fold(0, |word, &bit| 2 * word + u64::from(bit));
        let places = self.a | self.b.unwrap_or(0) << 7 | self.to.unwrap_or(0) << 14;
        places as u64 | flags << 21 | (next as u64) << 29
    }
}

/// The programs as `solver.v` reads them: MV's is the end of that of rank 1.
pub fn program_words() -> Vec<u64> {
    let mut words = Vec::new();
    for program in [rank1(), das()] {
        let sums: Vec<_> = program.split_inclusive(|term| term.to.is_some()).collect();
        for (k, sum) in sums.iter().enumerate() {
            let next = sums.get(k + 1).map_or(0, |next| next.len());
            words.extend(sum.iter().map(|term| term.word(next)));
        }
    }
    words
}

/// Reciprocals of `1 + (k + ½)/1024`, in 2⁻¹⁷.
pub fn reciprocals() -> Vec<u32> {
    (0..1024)
        .map(|k| 2049 + 2 * k)
        .map(|d| ((1 << 28) + d / 2) / d)
        .collect()
}

/// A number, and a power of two by which products with it as `b` are multiplied.
#[derive(Clone, Copy, Default)]
pub struct Number {
    pub value: i64,
    pub exponent: u32,
}

/// Runs the program. Returns the output's real and imaginary part.
pub fn solve(program: &[Term], reciprocals: &[u32], memory: &mut [Number; 128]) -> [i64; 2] {
    let mut output = [0; 2];
    let mut sum = 0i128;
    for term in program {
        let one = Number {
            value: ONE,
            exponent: 0,
        };
        let (a, b) = (memory[term.a], term.b.map_or(one, |b| memory[b]));
        let product = i128::from(a.value) * i128::from(b.value);
        sum += if term.negative { -product } else { product };
        let Some(to) = term.to else {
            continue;
        };
        let places = FRACTION - 1 - (b.exponent | if term.up { 2 } else { 0 });
        let rounded = ((sum >> places) + 1) >> 1;
        let value = rounded.clamp(i32::MIN.into(), i32::MAX.into()) as i64;
        let mut result = Number { value, exponent: 0 };
        if term.two {
            result.value &= 2 * ONE - 1;
        }
        if term.keep {
            result.exponent = a.exponent;
        }
        if term.reciprocal {
            let mantissa = a.value & (2 * ONE - 1);
            result.exponent = (FRACTION - mantissa.checked_ilog2().unwrap_or(0)).min(15);
            let index = (mantissa << result.exponent) >> (FRACTION - 10) & 1023;
            result.value = i64::from(reciprocals[index as usize]) << (FRACTION - 17);
        }
        if term.output {
            output[(to - SUM[0]) % 2] = result.value;
        }
        memory[to] = result;
        sum = 0;
    }
    output
}
