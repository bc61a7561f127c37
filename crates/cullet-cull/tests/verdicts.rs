//! Every test against exact arithmetic, on frusta and boxes made to be hard.
//!
//! 100 000 pairs, seeded, in the ordinary mode; `CULLET_LONG=1`, best in a release build,
//! asks for ten million pairs in all. Every failure names its seed.

mod truth;

use cullet_cull::{Aabb, DepthRange, Frustum, FrustumError, Sat, Test, Visibility, visible};
use cullet_transform::{Camera, Kind, Projection, Window};
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, DVec4};
use truth::{Planes, tan_of_half_degrees};

/// SplitMix64 (Steele, Lea and Flood 2014).
struct Rng(u64);

impl Rng {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// In 0..1.
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Evenly distributed in the logarithm.
    fn log(&mut self, low: f64, high: f64) -> f64 {
        self.within(low.ln(), high.ln()).exp()
    }

    fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }

    fn vector(&mut self, low: f64, high: f64) -> DVec3 {
        DVec3::new(self.within(low, high), self.within(low, high), self.within(low, high))
    }

    fn rotation(&mut self) -> DMat3 {
        let (axis, angle) = (self.vector(-1.0, 1.0), self.within(-4.0, 4.0));
        DMat3::from_quat(DQuat::from_axis_angle(axis.try_normalize().unwrap_or(DVec3::X), angle))
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    Ordinary,
    AxisAligned,
    Rolled,
    Wide,
    Narrow,
    FarOff,
    Tiny,
    Huge,
    DeepRange,
    InfiniteFar,
    OffCentre,
    Orthographic,
    File,
    Matrix,
    MatrixF32,
    MatrixInfinite,
    MatrixOrthographic,
    Mirrored,
    Oblique,
    MatrixTiny,
    MatrixHuge,
    /// Computed in f32, with a near distance that little or nothing is left of.
    NearLost,
    /// Row z is made of the others, as where it is row w.
    Sky,
    /// Likewise, with parallel sides.
    Flat,
}

use Shape as K;

const KINDS: [K; 24] = [
    K::Ordinary,
    K::AxisAligned,
    K::Rolled,
    K::Wide,
    K::Narrow,
    K::FarOff,
    K::Tiny,
    K::Huge,
    K::DeepRange,
    K::InfiniteFar,
    K::OffCentre,
    K::Orthographic,
    K::File,
    K::Matrix,
    K::MatrixF32,
    K::MatrixInfinite,
    K::MatrixOrthographic,
    K::Mirrored,
    K::Oblique,
    K::MatrixTiny,
    K::MatrixHuge,
    K::NearLost,
    K::Sky,
    K::Flat,
];

struct Case {
    frustum: Frustum,
    sat: Sat,
    truth: Planes,
    /// A matrix at its word, so that the exact test is exact.
    exact: bool,
    /// Sizes of boxes worth trying.
    near: f64,
    reach: f64,
}

fn window(rng: &mut Rng, kind: K) -> Window {
    let (near, far) = match kind {
        K::DeepRange => (1e-6, 1e9),
        K::InfiniteFar | K::MatrixInfinite => (0.1, f64::INFINITY),
        K::NearLost => (rng.log(1e-12, 1e-2), f64::INFINITY),
        K::Sky => (rng.log(0.01, 10.0), f64::INFINITY),
        K::Oblique => (rng.log(0.01, 10.0), if rng.below(2) == 0 { f64::INFINITY } else { 500.0 }),
        _ => (rng.log(0.01, 10.0), rng.log(20.0, 1000.0)),
    };
    let half = match kind {
        K::Wide => tan_of_half_degrees([179.0, 179.9, 179.99][rng.below(3) as usize]),
        K::Narrow => tan_of_half_degrees(0.001),
        _ => rng.log(0.2, 2.0).into(),
    };
    let half = half.times(&1.0.into()).to_f64();
    let aspect = [1.0, 16.0 / 9.0, rng.log(0.3, 3.0)][rng.below(3) as usize];
    let mut window = Window {
        kind: Kind::Perspective,
        left: -half * aspect,
        right: half * aspect,
        bottom: -half,
        top: half,
        near,
        far,
    };
    if kind == K::OffCentre || rng.below(8) == 0 {
        window.left = window.right - rng.log(1e-3, 10.0) * half;
        window.bottom = window.top - rng.log(1e-3, 10.0) * half;
    }
    if matches!(kind, K::Orthographic | K::MatrixOrthographic | K::Flat) {
        let scale = rng.log(1.0, 100.0);
        window = Window { kind: Kind::Orthographic, far: window.far.min(1e3), ..window };
        window.left *= scale;
        window.right *= scale;
        window.bottom *= scale;
        window.top *= scale;
    }
    window
}

fn case(rng: &mut Rng, kind: K) -> Case {
    let mut window = window(rng, kind);
    let axes = match kind {
        K::AxisAligned | K::DeepRange if rng.below(2) == 0 => DMat3::IDENTITY,
        K::AxisAligned => DMat3::from_cols(DVec3::Z, DVec3::X, DVec3::Y),
        K::Rolled => DMat3::from_rotation_z(rng.within(-4.0, 4.0)),
        _ if rng.below(4) == 0 => DMat3::from_rotation_y(rng.within(-4.0, 4.0)),
        _ if rng.below(16) == 0 => DMat3::from_rotation_y(std::f64::consts::FRAC_PI_4),
        _ => rng.rotation(),
    };
    let eye = match kind {
        K::FarOff => rng.vector(-1e7, 1e7),
        _ if rng.below(4) == 0 => DVec3::ZERO,
        _ => rng.vector(-50.0, 50.0),
    };
    let scale = match kind {
        K::Tiny | K::MatrixTiny => 1e-30,
        K::Huge | K::MatrixHuge => 1e30,
        _ => 1.0,
    };
    let eye = eye * scale;
    window.near *= scale;
    window.far *= scale;
    if window.kind == Kind::Orthographic {
        window.left *= scale;
        window.right *= scale;
        window.bottom *= scale;
        window.top *= scale;
    }
    let reach = if window.far.is_finite() { window.far } else { 1e3 * window.near };
    let (near, reach) = if kind == K::NearLost { (0.1, 100.0) } else { (window.near, reach) };
    let (frustum, truth, exact) = match kind {
        K::File => {
            let degrees = [rng.within(0.5, 179.5), 60.0, 90.0, 179.0, 179.99];
            let degrees = degrees[rng.below(5) as usize];
            let (target, up) = (eye + rng.vector(-9.0, 9.0), rng.vector(-1.0, 1.0));
            let up = match rng.below(4) {
                0 => up,
                // Almost along the view, where little is left of the products of the two.
                1 => eye - target + up * [1e-2, 1e-4, 1e-6, 1e-8][rng.below(4) as usize],
                _ => DVec3::Y,
            };
            let lens = Projection::Perspective {
                yfov: degrees.to_radians(),
                near: window.near,
                far: window.far,
            };
            let camera = Camera::look_at(eye, target, up, lens).expect("a camera");
            let aspect = [1.0, 2.0, 1.5][rng.below(3) as usize];
            let half = tan_of_half_degrees(degrees);
            let wide = half.times(&aspect.into());
            let edges = [wide.negated(), wide, half.negated(), half];
            let truth = Planes::of_camera(eye, target, up, edges, &camera.window(aspect));
            (Frustum::from_camera(&camera, aspect), truth, false)
        }
        K::Matrix
        | K::MatrixF32
        | K::MatrixInfinite
        | K::MatrixOrthographic
        | K::Mirrored
        | K::Oblique
        | K::MatrixTiny
        | K::MatrixHuge
        | K::NearLost
        | K::Sky
        | K::Flat => {
            let (matrix, depth) = matrix(rng, kind, eye, &axes, &window);
            let truth = Planes::of_matrix(&matrix, depth);
            match Frustum::from_matrix(&matrix, depth) {
                Ok(frustum) => (frustum, truth, true),
                // An oblique near plane may cut everything away.
                Err(error) => {
                    assert_eq!((kind, error), (K::Oblique, FrustumError::Empty));
                    assert!(!truth.visible(&Aabb::INFINITE));
                    return case(rng, kind);
                }
            }
        }
        _ => {
            let frustum = Frustum::from_window(eye, &axes, &window);
            (frustum, Planes::of_window(eye, &axes, &window), false)
        }
    };
    Case { sat: Sat::new(&frustum), frustum, truth, exact, near, reach }
}

fn matrix(
    rng: &mut Rng,
    kind: K,
    eye: DVec3,
    axes: &DMat3,
    window: &Window,
) -> (DMat4, DepthRange) {
    let depth = [DepthRange::ZeroToOne, DepthRange::MinusOneToOne, DepthRange::Reversed];
    let depth = depth[rng.below(3) as usize];
    let mut clip_from_view = window.clip_from_view(); // reversed
    let (z, w) = (clip_from_view.row(2), clip_from_view.row(3));
    let z = match depth {
        DepthRange::ZeroToOne => w - z,
        DepthRange::MinusOneToOne => w - 2.0 * z,
        DepthRange::Reversed => z,
    };
    let set_z = |matrix: &mut DMat4, z: DVec4| {
        let mut rows = matrix.transpose();
        rows.z_axis = z;
        *matrix = rows.transpose();
    };
    set_z(&mut clip_from_view, z);
    if kind == K::Oblique {
        // The near plane moved onto another (Lengyel 2005), reversed as need be.
        let plane = (DVec3::new(0.0, 0.0, -1.0) + rng.vector(-0.6, 0.6)).normalize();
        let plane = plane.extend(-window.near * rng.log(1.0, 10.0));
        let size = rng.log(1e-3, 1.0);
        let z = match depth {
            DepthRange::ZeroToOne => plane * size,
            DepthRange::MinusOneToOne => plane * size - w,
            DepthRange::Reversed => w - plane * size,
        };
        set_z(&mut clip_from_view, z);
    }
    let view_from_world = DAffine3::from_mat3(axes.transpose()) * DAffine3::from_translation(-eye);
    let mut matrix = clip_from_view * DMat4::from(view_from_world);
    if kind == K::Mirrored {
        matrix *= DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    }
    match kind {
        K::MatrixF32 => matrix = matrix.as_mat4().as_dmat4(),
        K::NearLost => {
            let view_from_world = DMat4::from(view_from_world).as_mat4();
            matrix = (clip_from_view.as_mat4() * view_from_world).as_dmat4();
        }
        K::Sky | K::Flat => {
            // Mostly the same for all points, sometimes cutting through the view.
            let share = [0.0, 0.5, 1.0][rng.below(3) as usize];
            let tilt = [0.0, 0.0, 0.0, rng.within(-1.0, 1.0)][rng.below(4) as usize];
            let z = share * matrix.row(3) + tilt * matrix.row(0);
            set_z(&mut matrix, z);
        }
        _ => {}
    }
    (matrix, depth)
}

fn ulps(x: f64, n: i64) -> f64 {
    (0..n.abs()).fold(x, |x, _| if n > 0 { x.next_up() } else { x.next_down() })
}

/// A box that touches the frustum, or very nearly does or does not.
fn knife_edge(rng: &mut Rng, case: &Case) -> Aabb {
    let frustum = &case.frustum;
    let at = |i: usize| {
        let corner = frustum.corners()[i];
        match corner.w {
            0.0 => frustum.corners()[i & 3].truncate() + corner.truncate() * (case.reach * 0.7),
            _ => corner.truncate(),
        }
    };
    // A corner, a point of an edge or of a face.
    let (i, axis, turn) = (rng.below(8) as usize, rng.below(3) as usize, rng.below(3));
    let mut point = at(i);
    let (t, s) = (rng.unit(), rng.unit());
    if turn > 0 {
        point = point.lerp(at(i ^ 1 << axis), t);
    }
    if frustum.corners()[i].w < 0.0 {
        // No corner: somewhere on two planes of it, or nearly.
        point = rng.vector(-case.reach, case.reach);
        for plane in [i & 1, 2 + (i >> 1 & 1), i & 1].map(|p| &frustum.planes()[p]) {
            point -= plane.normal * plane.distance(point);
        }
    }
    if turn > 1 && frustum.corners()[i].w >= 0.0 {
        let other = i ^ 1 << ((axis + 1) % 3);
        point = point.lerp(at(other).lerp(at(other ^ 1 << axis), t), s);
    }
    point += frustum.origin();
    // A box with this point on its outside: on a corner, an edge or a face.
    let away = {
        let planes = [i & 1, 2 + (i >> 1 & 1), 4 + (i >> 2)].map(|p| frustum.planes()[p].normal);
        let weights = rng.vector(0.0, 1.0);
        match rng.below(4) {
            0 => -(planes[0] * weights.x + planes[1] * weights.y + planes[2] * weights.z),
            1 => -planes[(axis + 1) % 3],
            2 => -(planes[(axis + 1) % 3] * weights.x + planes[(axis + 2) % 3] * weights.y),
            _ => rng.vector(-1.0, 1.0),
        }
    };
    let free = [rng.below(8), 0][rng.below(2) as usize];
    let size = box_size(rng, case);
    let (mut min, mut max) = (point, point);
    // Touching in zero, from the side where it is negative, or by less than any normal number.
    if case.frustum.origin() == DVec3::ZERO && rng.below(16) == 0 {
        point = [DVec3::ZERO, -DVec3::ZERO, DVec3::splat(1e-310), point * 1e-290][i & 3];
        (min, max) = (point, point);
    }
    for c in 0..3 {
        if free & 1 << c != 0 {
            min[c] -= size[c] * rng.unit();
            max[c] += size[c] * rng.unit();
        } else if away[c] > 0.0 {
            max[c] += size[c];
        } else {
            min[c] -= size[c];
        }
        if rng.below(3) > 0 {
            min[c] = ulps(min[c], rng.below(7) as i64 - 3);
            max[c] = ulps(max[c], rng.below(7) as i64 - 3).max(min[c]);
        }
    }
    Aabb { min, max }
}

fn box_size(rng: &mut Rng, case: &Case) -> DVec3 {
    let size = rng.log(case.near * 1e-2, case.reach * 4.0);
    let shape = if rng.below(2) == 0 {
        DVec3::ONE
    } else {
        DVec3::new(rng.log(1e-3, 1.0), rng.log(1e-3, 1.0), rng.log(1e-3, 1.0))
    };
    if rng.below(32) == 0 { DVec3::ZERO } else { size * shape }
}

fn random_box(rng: &mut Rng, case: &Case) -> Aabb {
    let weights: [f64; 8] = std::array::from_fn(|_| rng.log(1e-4, 1.0));
    let sum: f64 = weights.iter().sum();
    let mut center = DVec3::ZERO;
    for (corner, weight) in case.frustum.corners().iter().zip(weights) {
        let reach = if corner.w == 0.0 { case.reach * 0.7 } else { 1.0 };
        center += corner.truncate() * (reach * weight / sum);
    }
    let half = 0.5 * box_size(rng, case);
    let far_off = half + DVec3::splat(case.reach * rng.unit() * rng.unit());
    center += case.frustum.origin() + far_off * rng.vector(-1.5, 1.5);
    let mut bounds = Aabb { min: center - half, max: center + half };
    if rng.below(24) == 0 {
        let axis = rng.below(3) as usize;
        match rng.below(3) {
            0 => bounds.min[axis] = f64::NEG_INFINITY,
            1 => bounds.max[axis] = f64::INFINITY,
            _ => {
                bounds.min[axis] = f64::NEG_INFINITY;
                bounds.max[axis] = f64::INFINITY;
            }
        }
    }
    bounds
}

#[derive(Default, Debug)]
struct Tally {
    pairs: u64,
    visible: u64,
    inside: u64,
    knife_edge: u64,
    doubtful: u64,
}

/// Whether all coordinates lie where products of them with a matrix are exact, as `Sat` says.
fn exactly_known(bounds: &Aabb) -> bool {
    let least = 2_f64.powi(-216);
    let known = |x: f64| x == 0.0 || x.is_infinite() || (least..=1.0 / least).contains(&x.abs());
    bounds.min.to_array().into_iter().chain(bounds.max.to_array()).all(known)
}

fn judge(case: &Case, bounds: &Aabb, name: &dyn Fn() -> String, tally: &mut Tally) {
    let truth = case.truth.visible(bounds);
    for test in Test::ALL {
        let kept = if test == Test::Sat {
            case.sat.visible(bounds)
        } else {
            visible(test, &case.frustum, bounds)
        };
        assert!(kept || !truth, "false cull by {}: {}", test.name(), name());
        if kept && !truth && test == Test::Sat {
            assert!(!case.exact || !exactly_known(bounds), "false keep: {}", name());
            // Any other false keep is a near miss: grown by a little the box is visible.
            let size = (bounds.min - case.frustum.origin())
                .abs()
                .max((bounds.max - case.frustum.origin()).abs());
            let infinite = !size.is_finite();
            let grown = bounds.grown(size.max_element().max(case.near) * 2_f64.powi(-40));
            assert!(infinite || case.truth.visible(&grown), "keeps too much: {}", name());
            tally.doubtful += 1;
        }
    }
    let class = case.sat.classify(bounds);
    if class == Visibility::Inside {
        assert!(case.truth.contains(bounds), "false inside: {}", name());
        tally.inside += 1;
    }
    tally.pairs += 1;
    tally.visible += u64::from(truth);
}

fn run(kind: K, pairs: u64, seed: u64) -> Tally {
    const PER_FRUSTUM: u64 = 100;
    let mut tally = Tally::default();
    for n in 0..pairs / PER_FRUSTUM {
        let seed = seed ^ n << 8 ^ kind as u64;
        let mut rng = Rng(seed);
        let case = case(&mut rng, kind);
        for i in 0..PER_FRUSTUM {
            let sharp = rng.below(2) == 0;
            let bounds =
                if sharp { knife_edge(&mut rng, &case) } else { random_box(&mut rng, &case) };
            tally.knife_edge += u64::from(sharp);
            judge(
                &case,
                &bounds,
                &|| format!("{kind:?} seed {seed} box {i} {bounds:?}"),
                &mut tally,
            );
        }
    }
    tally
}

#[test]
fn no_test_loses_a_box_and_the_exact_one_is_exact() {
    let long = std::env::var_os("CULLET_LONG").is_some();
    let pairs = if long { 500_000 } else { 5_000 };
    let next = std::sync::atomic::AtomicUsize::new(0);
    let work = || {
        while let Some(&kind) = KINDS.get(next.fetch_add(1, std::sync::atomic::Ordering::Relaxed)) {
            let started = std::time::Instant::now();
            let tally = run(kind, pairs, 1);
            println!(
                "{:>18} {:7.1} s {tally:?}",
                format!("{kind:?}"),
                started.elapsed().as_secs_f64()
            );
            assert!(tally.visible * 20 > tally.pairs && tally.visible * 20 < tally.pairs * 19);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(work);
        }
    });
}
