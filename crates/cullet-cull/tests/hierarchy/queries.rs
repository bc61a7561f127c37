//! Queries against asking every box.

use cullet_cull::wide::{Level, levels};
use cullet_cull::{
    Aabb, Cone, Frustum, Hierarchy, Overlap, Ray, Sphere, overlap_box, overlap_cone,
    overlap_sphere, ray_aabb,
};
use glam::DVec3;

use crate::walk::sets;
use crate::worlds::{Random, cameras, random_boxes};

#[test]
fn many_frusta_see_what_each_sees() {
    let mut random = Random(31);
    for (name, boxes) in sets() {
        let tree = Hierarchy::build(&boxes);
        for n in [0, 1, 6, 64] {
            let frusta = cameras(&mut random, &boxes, n);
            let mut expected = vec![0_u64; boxes.len()];
            for (i, frustum) in frusta.iter().enumerate() {
                for (id, _) in tree.visible(frustum, Level::new()) {
                    expected[id as usize] |= 1 << i;
                }
            }
            for (level_name, level) in levels() {
                let mut found = vec![0_u64; boxes.len()];
                let stats = tree.walk_many(&frusta, level, |ids, seen_by| {
                    for id in ids {
                        assert_eq!(found[*id as usize], 0, "{id} was returned twice");
                        found[*id as usize] = seen_by;
                    }
                });
                assert_eq!(found, expected, "{name} {level_name} {n}");
                let n_found = expected.iter().filter(|seen_by| **seen_by != 0).count();
                assert_eq!(stats.n_visible, n_found as u64);
            }
        }
    }
}

#[test]
#[should_panic(expected = "at most 64 frusta")]
fn more_frusta_than_bits_are_refused() {
    let boxes = random_boxes(&mut Random(1), 9, 1.0, 1.0);
    let frusta: Vec<Frustum> = cameras(&mut Random(1), &boxes, 65);
    Hierarchy::build(&boxes).walk_many(&frusta, Level::new(), |_, _| ());
}

/// How many items may be found too much. No origin suits a world of 24 decades in size: the
/// boxes near its zero are blurred by what is far away.
fn excess(name: &str, n: usize) -> usize {
    if name == "growing" { n } else { 2 + n / 50 }
}

/// All that `touches` must be found, and little that is outside by `overlap`.
#[track_caller]
fn check_shape(
    name: &str,
    boxes: &[Aabb],
    tree: &Hierarchy,
    touches: impl Fn(&Aabb) -> bool,
    overlap: impl Fn(&Aabb) -> Overlap,
    query: impl FnOnce(&mut dyn FnMut(&[u32])),
) {
    let mut found = vec![false; boxes.len()];
    query(&mut |ids| {
        for id in ids {
            assert!(!found[*id as usize], "{id} was returned twice");
            found[*id as usize] = true;
        }
    });
    let mut n_more = 0;
    for (i, bounds) in boxes.iter().enumerate() {
        assert!(!touches(bounds) || found[i], "{i} is lost: {bounds:?}");
        n_more += usize::from(found[i] && overlap(bounds) == Overlap::Outside);
    }
    assert!(n_more <= excess(name, boxes.len()), "{name}: {n_more} of {}", tree.len());
}

/// Clearly, in spite of rounding.
fn is_in_cone(cone: &Cone, point: DVec3) -> bool {
    let offset = point - cone.apex;
    let is_near = offset.length() <= cone.range * (1.0 - 1e-9);
    is_near && offset.angle_between(cone.direction) <= cone.half_angle - 1e-6
}

#[test]
fn shapes_find_what_they_touch() {
    let mut random = Random(32);
    for (name, boxes) in sets() {
        let tree = Hierarchy::build(&boxes);
        for i in 0..20 {
            let center = boxes.get(random.below(boxes.len().max(1))).map_or(DVec3::ZERO, |b| {
                let center = b.center();
                if center.is_finite() { center } else { DVec3::ONE }
            });
            let apex = center + random.point(30.0);
            let radius = [0.0, 1.0, 40.0, 300.0, f64::INFINITY][i % 5];
            let sphere = Sphere { center: apex, radius };
            let overlap = |b: &Aabb| overlap_sphere(&sphere, b);
            let touches = |b: &Aabb| overlap(b) != Overlap::Outside;
            check_shape(&name, &boxes, &tree, touches, overlap, |visit| {
                tree.in_sphere(&sphere, visit)
            });

            let direction = random.point(1.0).normalize();
            let half_angle = random.within(0.0, std::f64::consts::PI);
            let cone = Cone { apex, direction, half_angle, range: radius };
            let overlap = |b: &Aabb| overlap_cone(&cone, b);
            // The ball around a box may touch where the box does not: ask points of the box.
            let touches = |b: &Aabb| {
                let points = b.corners().into_iter().chain([b.center()]);
                points.into_iter().any(|p| !b.is_empty() && is_in_cone(&cone, p))
            };
            check_shape(&name, &boxes, &tree, touches, overlap, |visit| tree.in_cone(&cone, visit));

            let range = Aabb::from_sphere(&sphere);
            let overlap = |b: &Aabb| overlap_box(&range, b);
            let touches = |b: &Aabb| overlap(b) != Overlap::Outside;
            check_shape(&name, &boxes, &tree, touches, overlap, |visit| tree.in_box(&range, visit));
        }
    }
}

/// Points of a box that are in a shape mean that the box is not outside of it, and points that
/// are not mean that it is not inside.
#[test]
fn overlaps_agree_with_points() {
    let mut random = Random(33);
    for _ in 0..20_000 {
        let bounds = random_boxes(&mut random, 1, 10.0, 12.0)[0];
        let sphere = Sphere { center: random.point(10.0), radius: random.within(0.0, 12.0) };
        let direction = random.point(1.0).normalize();
        let half_angle = random.within(0.0, std::f64::consts::PI);
        let cone = Cone { apex: sphere.center, direction, half_angle, range: sphere.radius };
        let size = bounds.max - bounds.min;
        let weights = DVec3::new(random.unit(), random.unit(), random.unit());
        let point = bounds.min + size * weights;
        let offset = point - sphere.center;
        let in_sphere = offset.length() <= sphere.radius;
        let angle = offset.angle_between(direction);
        let in_cone = in_sphere && angle <= half_angle;
        for (overlap, is_in) in
            [(overlap_sphere(&sphere, &bounds), in_sphere), (overlap_cone(&cone, &bounds), in_cone)]
        {
            match overlap {
                Overlap::Outside => assert!(!is_in, "{bounds:?} {cone:?} {point}"),
                Overlap::Inside => assert!(is_in, "{bounds:?} {cone:?} {point}"),
                Overlap::Partly => {}
            }
        }
    }
}

/// Boxes a few ulps wide have their rounded centre on, or beside, their faces; a cone that is next
/// to nothing but its axis touches them at a corner.
#[test]
fn thin_cones_touch_the_corners_of_thin_boxes() {
    let mut random = Random(36);
    for round in 0..4000 {
        let size = 10_f64.powi(random.below(20) as i32 - 4);
        let min = random.point(size);
        let step = |x: f64, n: usize| (0..n).fold(x, |x, _| x.next_up());
        let max = DVec3::from_array(min.to_array().map(|x| step(x, random.below(4))));
        let bounds = Aabb { min, max };
        let corner = bounds.corners()[random.below(8)];
        let axis = random.below(3);
        let direction = if round % 2 == 0 { DVec3::AXES[axis] } else { -DVec3::AXES[axis] };
        // Along an axis from where the other coordinates are those of the corner, exactly.
        let mut apex = corner;
        apex[axis] -= direction[axis] * size.max(1.0);
        let cone = Cone { apex, direction, half_angle: 1e-9, range: 100.0 * size.max(1.0) };
        assert_ne!(overlap_cone(&cone, &bounds), Overlap::Outside, "{cone:?} {bounds:?}");
    }
    let max = DVec3::new(1e8_f64.next_up(), 0.0, 0.0);
    let bounds = Aabb { min: DVec3::X * 1e8, max };
    let apex = max - DVec3::Y;
    let cone = Cone { apex, direction: DVec3::Y, half_angle: 1e-9, range: 10.0 };
    assert_eq!(overlap_cone(&cone, &bounds), Overlap::Partly);
}

fn ray(random: &mut Random, boxes: &[Aabb]) -> Ray {
    let pick = |random: &mut Random| {
        let center = boxes.get(random.below(boxes.len().max(1))).map_or(DVec3::ZERO, Aabb::center);
        if center.is_finite() { center } else { DVec3::ONE }
    };
    let (a, b) = (pick(random) + random.point(20.0), pick(random));
    let direction = match random.below(5) {
        0 => DVec3::X,
        1 => -DVec3::Y,
        _ => (b - a) * 1e-3,
    };
    Ray { origin: a, direction }
}

#[test]
fn rays_hit_what_they_hit() {
    let mut random = Random(34);
    for (name, boxes) in sets() {
        let tree = Hierarchy::build(&boxes);
        for _ in 0..40 {
            let ray = ray(&mut random, &boxes);
            let mut found = vec![None; boxes.len()];
            tree.hits(&ray, |id, interval| {
                assert_eq!(found[id as usize], None, "{name}: {id} was returned twice");
                found[id as usize] = Some(interval);
            });
            let mut n_more = 0;
            let mut first: Option<(u32, f64)> = None;
            for (i, bounds) in boxes.iter().enumerate() {
                match (ray_aabb(&ray, bounds), found[i]) {
                    (Some((enter, exit)), Some((found_enter, found_exit))) => {
                        assert!(found_enter <= enter && exit <= found_exit, "{name}: {i}");
                        if first.is_none_or(|(_, nearest)| enter < nearest) {
                            first = Some((i as u32, enter));
                        }
                    }
                    (Some(_), None) => panic!("{name}: {i} is lost"),
                    (None, Some(_)) => n_more += 1,
                    (None, None) => {}
                }
            }
            assert!(n_more <= excess(&name, boxes.len()), "{name}: {n_more}");
            let mut n_asked = 0;
            let nearest = tree.nearest(&ray, |id| {
                n_asked += 1;
                ray_aabb(&ray, &boxes[id as usize]).map(|(enter, _)| enter)
            });
            assert_eq!(nearest, first, "{name}");
        }
    }
}

#[test]
fn the_nearest_hit_does_not_ask_everybody() {
    let mut random = Random(35);
    let boxes = random_boxes(&mut random, 20_000, 100.0, 4.0);
    let tree = Hierarchy::build(&boxes);
    let mut n_asked = 0;
    for _ in 0..100 {
        let ray = ray(&mut random, &boxes);
        tree.nearest(&ray, |id| {
            n_asked += 1;
            ray_aabb(&ray, &boxes[id as usize]).map(|(enter, _)| enter)
        });
    }
    assert!(n_asked < 100 * 60, "{n_asked}");
}

#[test]
fn nan_is_no_hit() {
    let cube = |at: f64| Aabb { min: DVec3::splat(at), max: DVec3::splat(at + 1.0) };
    let mut boxes: Vec<Aabb> = (0..50).map(|i| cube(f64::from(i))).collect();
    boxes.push(Aabb::INFINITE); // kept beside the tree
    let tree = Hierarchy::build(&boxes);
    let ray = Ray { origin: DVec3::splat(-1.0), direction: DVec3::ONE };
    for nan in [0, 3, 49, 50] {
        let enter = |id: u32| ray_aabb(&ray, &boxes[id as usize]).map(|(enter, _)| enter);
        let hit = |id| if id == nan { Some(f64::NAN) } else { enter(id).map(|t| t.max(0.0)) };
        let first = (0..51).filter_map(|id| hit(id).map(|t| (id, t))).filter(|(_, t)| !t.is_nan());
        let first = first.min_by(|a, b| a.1.total_cmp(&b.1));
        assert_eq!(tree.nearest(&ray, hit), first, "{nan}");
    }
    assert_eq!(tree.nearest(&ray, |_| Some(f64::NAN)), None);
}
