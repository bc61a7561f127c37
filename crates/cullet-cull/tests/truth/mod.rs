//! Box and frustum in integers: the verdict that no rounding touches.
//!
//! Every f64 is a whole number times a power of two, so planes and boxes become whole numbers
//! over one denominator each, and signs of sums of products are exact. Square roots and
//! tangents of a camera are taken to some 400 bits, which no test case comes near.

use std::array::from_fn;

use cullet_cull::{Aabb, DepthRange};
use cullet_transform::{Kind, Window};
use glam::{DMat3, DMat4, DVec3};
use num_bigint::BigInt;
use num_traits::{Signed, ToPrimitive, Zero};

/// A whole number times a power of two.
#[derive(Clone, Debug)]
pub struct Dyadic {
    pub n: BigInt,
    pub exponent: i64,
}

impl From<f64> for Dyadic {
    fn from(x: f64) -> Self {
        assert!(x.is_finite());
        let bits = x.to_bits();
        let (biased, fraction) = ((bits >> 52 & 0x7ff) as i64, (bits & ((1 << 52) - 1)) as i64);
        let (n, exponent) =
            if biased == 0 { (fraction, -1074) } else { (fraction | 1 << 52, biased - 1075) };
        let zeros = if n == 0 { 0 } else { i64::from(n.trailing_zeros()) };
        let n = if x < 0.0 { -(n >> zeros) } else { n >> zeros };
        Dyadic { n: n.into(), exponent: if n == 0 { 0 } else { exponent + zeros } }
    }
}

impl Dyadic {
    pub fn plus(&self, other: &Dyadic) -> Dyadic {
        if self.n.is_zero() {
            return other.clone();
        }
        if other.n.is_zero() {
            return self.clone();
        }
        let exponent = self.exponent.min(other.exponent);
        Dyadic { n: self.over(exponent) + other.over(exponent), exponent }
    }

    pub fn times(&self, other: &Dyadic) -> Dyadic {
        Dyadic { n: &self.n * &other.n, exponent: self.exponent + other.exponent }
    }

    pub fn negated(&self) -> Dyadic {
        Dyadic { n: -&self.n, exponent: self.exponent }
    }

    /// In units of 2^exponent, which is not greater than its own.
    fn over(&self, exponent: i64) -> BigInt {
        if self.n.is_zero() { BigInt::zero() } else { &self.n << (self.exponent - exponent) }
    }

    /// Some 400 bits of the quotient.
    fn over_root_of(&self, square: &Dyadic) -> Dyadic {
        let odd = square.exponent & 1;
        let bits = 400 - (square.n.bits() as i64) / 2; // of the root, before it is cut
        let spread = bits.max(0);
        let root = ((&square.n << (2 * spread + odd)) as BigInt).sqrt();
        let exponent = (square.exponent - odd) / 2 - spread;
        let shift = 400 + root.bits() as i64 - self.n.bits().min(400) as i64;
        Dyadic { n: (&self.n << shift) / root, exponent: self.exponent - exponent - shift }
    }
}

/// `a x + b y + c z + d >= 0` inside, relative to an origin.
#[derive(Clone, Debug)]
pub struct Planes {
    origin: [Dyadic; 3],
    /// Per plane over its own power of two.
    rows: Vec<[BigInt; 4]>,
    /// The same, rounded and of length one or so, to guess with.
    guess: Vec<[f64; 4]>,
}

type Row = [Dyadic; 4];

fn vector(v: DVec3) -> [Dyadic; 3] {
    v.to_array().map(Dyadic::from)
}

fn dot(a: &[Dyadic; 3], b: &[Dyadic; 3]) -> Dyadic {
    (0..3).fold(Dyadic::from(0.0), |sum, i| sum.plus(&a[i].times(&b[i])))
}

fn cross(a: &[Dyadic; 3], b: &[Dyadic; 3]) -> [Dyadic; 3] {
    from_fn(|i| {
        let (u, v) = ((i + 1) % 3, (i + 2) % 3);
        a[u].times(&b[v]).plus(&a[v].times(&b[u]).negated())
    })
}

fn unit(v: &[Dyadic; 3]) -> [Dyadic; 3] {
    let square = dot(v, v);
    v.clone().map(|c| c.over_root_of(&square))
}

/// tan(degrees / 2) to some 400 bits, by the series of sine and cosine; pi by Machin's formula.
pub fn tan_of_half_degrees(degrees: f64) -> Dyadic {
    const BITS: i64 = 450;
    let one = BigInt::from(1) << BITS;
    let arctan_of_inverse = |n: i64| {
        let (mut sum, mut power, mut k) = (BigInt::zero(), &one / n, 1_i64);
        while !power.is_zero() {
            sum += if k % 4 == 1 { &power / k } else { -(&power / k) };
            power /= n * n;
            k += 2;
        }
        sum
    };
    let pi: BigInt = 4 * (4 * arctan_of_inverse(5) - arctan_of_inverse(239));
    let half = Dyadic::from(degrees);
    let angle =
        Dyadic { n: (half.n * pi) / 360, exponent: half.exponent - BITS }.over(-BITS * 2) >> BITS;
    let (mut sums, mut term, mut k) = ([BigInt::zero(), BigInt::zero()], one, 0_i64);
    while !term.is_zero() {
        sums[(k % 2) as usize] += if k % 4 < 2 { term.clone() } else { -&term };
        k += 1;
        term = ((term * &angle) >> BITS) / k;
    }
    let [cos, sin] = sums;
    Dyadic { n: (sin << BITS) / cos, exponent: -BITS }
}

impl Planes {
    fn new(origin: DVec3, rows: impl IntoIterator<Item = Row>) -> Planes {
        let rows: Vec<[BigInt; 4]> = rows
            .into_iter()
            .map(|row| {
                let exponents = row.iter().filter(|c| !c.n.is_zero()).map(|c| c.exponent);
                let exponent = exponents.min().unwrap_or(0);
                from_fn(|i| row[i].over(exponent))
            })
            .collect();
        let guess = rows.iter().map(|row| {
            let bits = row[..3].iter().map(BigInt::bits).max().unwrap_or(0).max(1) as i64;
            let scaled = |n: &BigInt| {
                let cut = n.bits() as i64 - 64;
                let head = if cut > 0 { n >> cut } else { n.clone() };
                head.to_f64().unwrap() * 2_f64.powi((cut.max(0) - bits).clamp(-1000, 1000) as i32)
            };
            from_fn(|i| scaled(&row[i]))
        });
        let guess = guess.collect();
        Planes { origin: vector(origin), rows, guess }
    }

    /// The window through exactly these axes.
    pub fn of_window(eye: DVec3, axes: &DMat3, window: &Window) -> Planes {
        let edges = [window.left, window.right, window.bottom, window.top].map(Dyadic::from);
        let axes = [axes.x_axis, axes.y_axis, axes.z_axis].map(vector);
        Planes::of_axes(eye, &axes, edges, window)
    }

    /// A camera as its file has it: the axes of `look_at`, in exact arithmetic.
    pub fn of_camera(
        eye: DVec3,
        target: DVec3,
        up: DVec3,
        edges: [Dyadic; 4],
        window: &Window,
    ) -> Planes {
        let (e, t) = (vector(eye), vector(target));
        let back = unit(&from_fn(|i| e[i].plus(&t[i].negated())));
        let right = unit(&cross(&vector(up), &back));
        let up = cross(&back, &right);
        Planes::of_axes(eye, &[right, up, back], edges, window)
    }

    fn of_axes(
        eye: DVec3,
        [right, up, back]: &[[Dyadic; 3]; 3],
        [left_edge, right_edge, bottom_edge, top_edge]: [Dyadic; 4],
        window: &Window,
    ) -> Planes {
        let row = |[x, y, z]: [Dyadic; 3], offset: Dyadic| [x, y, z, offset];
        let side = |axis: &[Dyadic; 3], edge: &Dyadic, sign: f64| {
            let sign = Dyadic::from(sign);
            let slant = |i: usize| axis[i].plus(&edge.times(&back[i])).times(&sign);
            match window.kind {
                Kind::Perspective => row(from_fn(slant), 0.0.into()),
                Kind::Orthographic => {
                    let offset = edge.times(&sign).negated();
                    row(from_fn(|i| axis[i].times(&sign)), offset)
                }
            }
        };
        let mut rows = vec![
            side(right, &left_edge, 1.0),
            side(right, &right_edge, -1.0),
            side(up, &bottom_edge, 1.0),
            side(up, &top_edge, -1.0),
            row(back.clone().map(|c| c.negated()), (-window.near).into()),
        ];
        if window.far.is_finite() {
            rows.push(row(back.clone(), window.far.into()));
        }
        Planes::new(eye, rows)
    }

    pub fn of_matrix(clip_from_world: &DMat4, depth: DepthRange) -> Planes {
        let row = |i: usize| clip_from_world.row(i).to_array().map(Dyadic::from);
        let [x, y, z, w] = [0, 1, 2, 3].map(row);
        let plus = |a: &Row, b: &Row| -> Row { from_fn(|i| a[i].plus(&b[i])) };
        let minus = |a: &Row, b: &Row| -> Row { from_fn(|i| a[i].plus(&b[i].negated())) };
        let (near, far) = match depth {
            DepthRange::ZeroToOne => (z.clone(), minus(&w, &z)),
            DepthRange::MinusOneToOne => (plus(&w, &z), minus(&w, &z)),
            DepthRange::Reversed => (minus(&w, &z), z.clone()),
        };
        let rows = [plus(&w, &x), minus(&w, &x), plus(&w, &y), minus(&w, &y), near, far];
        Planes::new(DVec3::ZERO, rows)
    }

    /// The box over a common power of two, and that power.
    fn whole(&self, bounds: &Aabb) -> ([[BigInt; 2]; 3], u64) {
        let ends: [[Dyadic; 2]; 3] = from_fn(|i| {
            [bounds.min[i], bounds.max[i]].map(|x| match x {
                // Farther than any corner of these frusta.
                _ if x.is_infinite() => {
                    Dyadic { n: if x > 0.0 { 1 } else { -1 }.into(), exponent: 5000 }
                }
                _ => Dyadic::from(x).plus(&self.origin[i].negated()),
            })
        });
        let exponents = ends.iter().flatten().filter(|x| !x.n.is_zero()).map(|x| x.exponent);
        let exponent = exponents.min().unwrap_or(0).min(0);
        (ends.map(|pair| pair.map(|x| x.over(exponent))), (-exponent) as u64)
    }

    /// Whether box and planes share a point.
    pub fn visible(&self, bounds: &Aabb) -> bool {
        let (ends, scale) = self.whole(bounds);
        let rows: Vec<[BigInt; 4]> = self.rows.iter().map(|row| over(row, scale)).collect();
        if rows.iter().any(|row| excludes(row, &ends)) {
            return false;
        }
        if self.witness(bounds).is_some_and(|point| {
            let (point, scale) = self.whole(&Aabb { min: point, max: point });
            self.rows.iter().all(|row| !excludes(&over(row, scale), &point))
        }) {
            return true;
        }
        if let Some(row) = self.guess_certificate(bounds, &rows)
            && excludes(&row, &ends)
        {
            return false;
        }
        if sums(&rows).any(|row| excludes(&row, &ends)) {
            return false;
        }
        some_corner_is_inside(&rows, &ends)
    }

    /// Whether all of the box is inside every plane.
    pub fn contains(&self, bounds: &Aabb) -> bool {
        let (ends, scale) = self.whole(bounds);
        self.rows.iter().all(|row| {
            let outward: [BigInt; 4] = over(row, scale).map(|c| -c);
            let farthest = farthest(&outward, &ends);
            !farthest.is_positive()
        })
    }

    /// A point of the box that may well be inside: projected from plane to plane, in f64.
    fn witness(&self, bounds: &Aabb) -> Option<DVec3> {
        if !(bounds.min.is_finite() && bounds.max.is_finite()) {
            return None;
        }
        let origin = DVec3::from_array(from_fn(|i| {
            self.origin[i].n.to_f64().unwrap() * 2_f64.powi(self.origin[i].exponent as i32)
        }));
        let mut point = bounds.center().clamp(bounds.min, bounds.max);
        for round in 0..24 {
            for &[x, y, z, offset] in &self.guess {
                let normal = DVec3::new(x, y, z);
                let square = normal.length_squared();
                let distance = normal.dot(point - origin) + offset;
                if distance < 0.0 && square > 0.0 {
                    // A little past the plane, at first.
                    let over = if round < 16 { 1.5 } else { 1.0 + 1e-9 };
                    point -= normal * (over * distance / square);
                    point = point.clamp(bounds.min, bounds.max);
                }
            }
        }
        point.is_finite().then_some(point)
    }

    /// The sum of planes that looks most like excluding the box, in f64; made again exactly.
    fn guess_certificate(&self, bounds: &Aabb, rows: &[[BigInt; 4]]) -> Option<[BigInt; 4]> {
        let origin = DVec3::from_array(from_fn(|i| {
            self.origin[i].n.to_f64().unwrap() * 2_f64.powi(self.origin[i].exponent as i32)
        }));
        let local = bounds.relative_to(origin);
        let mut best = (0.0, None);
        for choice in choices(self.guess.len()) {
            let Some(row) = choice.sum(&self.guess, |a, b| a * b, |a, b| a + b) else { continue };
            let [x, y, z, offset] = row;
            let normal = DVec3::new(x, y, z);
            let corner = local.farthest_along(normal);
            let terms = normal * corner;
            let value = terms.element_sum() + offset;
            let relative = value / (terms.abs().element_sum() + offset.abs());
            if relative < best.0 {
                best = (relative, Some(choice));
            }
        }
        best.1?.sum(rows, |a, b| a * b, |a, b| a + b)
    }
}

/// Row with its offset in the units of scaled coordinates.
fn over(row: &[BigInt; 4], scale: u64) -> [BigInt; 4] {
    let [x, y, z, offset] = row.clone();
    [x, y, z, offset << scale]
}

fn farthest(row: &[BigInt; 4], ends: &[[BigInt; 2]; 3]) -> BigInt {
    let mut sum = row[3].clone();
    for (along, [min, max]) in row.iter().zip(ends) {
        sum += along * if along.is_negative() { min } else { max };
    }
    sum
}

fn excludes(row: &[BigInt; 4], ends: &[[BigInt; 2]; 3]) -> bool {
    farthest(row, ends).is_negative()
}

/// Two or three planes and the coordinates that are to drop out.
#[derive(Clone, Copy)]
struct Choice {
    planes: [usize; 3],
    n: usize,
    axis: usize,
}

fn choices(n: usize) -> impl Iterator<Item = Choice> {
    let pairs = (0..n).flat_map(move |i| (i + 1..n).map(move |j| ([i, j, 0], 2)));
    let triples = (0..n)
        .flat_map(move |i| (i + 1..n).flat_map(move |j| (j + 1..n).map(move |k| ([i, j, k], 3))));
    let all = pairs.chain(triples);
    all.flat_map(|(planes, n)| (0..3).map(move |axis| Choice { planes, n, axis }))
}

impl Choice {
    /// The sum of the planes, with weights that are not negative, in which `axis` drops out of
    /// two planes, or all but `axis` of three.
    fn sum<T>(
        &self,
        rows: &[[T; 4]],
        times: impl Fn(&T, &T) -> T,
        plus: impl Fn(&T, &T) -> T,
    ) -> Option<[T; 4]>
    where
        T: Clone + PartialOrd + std::ops::Neg<Output = T> + Default,
    {
        let zero = T::default();
        let rows = self.planes.map(|i| &rows[i]);
        let mut weights: [T; 3] = if self.n == 2 {
            [-rows[1][self.axis].clone(), rows[0][self.axis].clone(), zero.clone()]
        } else {
            let (u, v) = ((self.axis + 1) % 3, (self.axis + 2) % 3);
            from_fn(|i| {
                let (a, b) = (rows[(i + 1) % 3], rows[(i + 2) % 3]);
                plus(&times(&a[u], &b[v]), &-times(&a[v], &b[u]))
            })
        };
        if weights.iter().any(|w| *w < zero) {
            weights = weights.map(|w| -w);
        }
        if weights.iter().any(|w| *w < zero) || weights.iter().all(|w| *w == zero) {
            return None;
        }
        Some(from_fn(|c| {
            (0..self.n).fold(zero.clone(), |sum, i| plus(&sum, &times(&rows[i][c], &weights[i])))
        }))
    }
}

fn sums(rows: &[[BigInt; 4]]) -> impl Iterator<Item = [BigInt; 4]> {
    choices(rows.len()).filter_map(|choice| choice.sum(rows, |a, b| a * b, |a, b| a + b))
}

/// Whether three of all planes, those of the box included, meet in a point that is inside all:
/// the box and all it shares with the frustum are bounded, so if they share a point they
/// share such a corner.
fn some_corner_is_inside(rows: &[[BigInt; 4]], ends: &[[BigInt; 2]; 3]) -> bool {
    let mut planes = rows.to_vec();
    for (axis, [min, max]) in ends.iter().enumerate() {
        let facing = |sign: i32, offset: BigInt| {
            let along = |c| if c == axis { sign.into() } else { BigInt::zero() };
            [along(0), along(1), along(2), offset]
        };
        planes.push(facing(1, -min));
        planes.push(facing(-1, max.clone()));
    }
    let minor =
        |a: &[BigInt; 4], b: &[BigInt; 4], u: usize, v: usize| &a[u] * &b[v] - &a[v] * &b[u];
    let n = planes.len();
    for i in 0..n {
        for j in i + 1..n {
            for k in j + 1..n {
                let (a, b, c) = (&planes[i], &planes[j], &planes[k]);
                let cofactor = |[u, v, w]: [usize; 3]| {
                    &a[u] * minor(b, c, v, w)
                        + &a[v] * minor(b, c, w, u)
                        + &a[w] * minor(b, c, u, v)
                };
                let mut point = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]].map(cofactor);
                if point[3].is_zero() {
                    continue;
                }
                if point[3].is_negative() {
                    point = point.map(|x| -x);
                }
                let inside = |row: &[BigInt; 4]| {
                    let sum: BigInt = (0..4).map(|c| &row[c] * &point[c]).sum();
                    !sum.is_negative()
                };
                if planes.iter().all(inside) {
                    return true;
                }
            }
        }
    }
    false
}

impl Dyadic {
    /// Correctly rounded, or nearly.
    pub fn to_f64(&self) -> f64 {
        let cut = self.n.bits() as i64 - 64;
        let head = if cut > 0 { &self.n >> cut } else { self.n.clone() };
        head.to_f64().unwrap() * 2_f64.powi((self.exponent + cut.max(0)) as i32)
    }
}
