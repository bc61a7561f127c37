//! Boxes against frusta: flat loops, our tree, and walks over the trees of others.
//!
//! `cull [N...]`: the numbers of boxes, 1000 100000 1000000 by default; 8000000 wants 4 GB.
//! Every time is the least of interleaved rounds, for one view, its planes made ready included;
//! `ratio` columns are medians of per-round ratios to our tree, above 1 where ours is faster.

use std::hint::black_box;

use cullet_benches::boxes::{Sees, World, seen};
use cullet_benches::memory::Memory;
use cullet_benches::peers::{Flat, Obvhs, Planes, SphereThenBox, SvenstaroBvh};
use cullet_cull::Hierarchy;
use cullet_cull::wide::{Boxes8, Coarse8, Level};
use cullet_measure::{Align, Comparison, Rounds, Table};

fn main() {
    let numbers: Vec<usize> =
        std::env::args().skip(1).map(|n| n.parse().expect("a number of boxes")).collect();
    let numbers = if numbers.is_empty() { vec![1_000, 100_000, 1_000_000] } else { numbers };
    let left = Align::Left;
    let right = Align::Right;
    let mut table = Table::new(&[
        ("world", left),
        ("boxes", right),
        ("sees", right),
        ("seen", right),
        ("tree us", right),
        ("near-far us", right),
        ("flat8 ns/box", right),
        ("coarse8 ns/box", right),
        ("flat8/coarse8", right),
        ("scalar ns/box", right),
        ("scalar/flat8", right),
        ("sphere+box", right),
        ("obvhs", right),
        ("bvh", right),
        ("(tree = 1) flat8", right),
        ("scalar", right),
    ]);
    let mut memory = Memory::default();
    for n in numbers {
        (0..5).for_each(|_| memory.read());
        for world in [World::Random, World::City] {
            measure(world, n, &mut table);
        }
    }
    print!("{table}");
    // What a flat test of boxes of 24 bytes cannot beat from memory.
    let speed = memory.gb_per_s();
    println!("one core reads {speed:.1} GB/s: {:.2} ns per box", 24.0 / speed);
}

fn measure(world: World, n: usize, table: &mut Table) {
    let level = Level::new();
    let boxes = world.boxes(n);
    let wide = Boxes8::new(&boxes);
    let coarse = Coarse8::new(wide.clone());
    let start = std::time::Instant::now();
    let tree = Hierarchy::build(&boxes);
    eprintln!("{} {n}: our tree in {:.0?}", world.name(), start.elapsed());
    let start = std::time::Instant::now();
    let obvhs = Obvhs::new(&boxes);
    eprintln!("{} {n}: obvhs in {:.0?}", world.name(), start.elapsed());
    let start = std::time::Instant::now();
    let bvh = SvenstaroBvh::new(&boxes);
    eprintln!("{} {n}: bvh in {:.0?}", world.name(), start.elapsed());
    let (flat, sphere) = (Flat::new(&boxes), SphereThenBox::new(&boxes));

    for sees in [Sees::Part(0.01), Sees::Part(0.1), Sees::All, Sees::Nothing] {
        // Enough decisions in a round that no branch predictor learns them, and enough walks that see
        // nothing that a clock can tell how long they took.
        let at_least = if sees == Sees::Nothing { 64 } else { 4 };
        let n_views = (1_000_000 / n).clamp(at_least, 200);
        let views = sees.views(&boxes, n_views);
        let mut bits = vec![0; wide.n_groups()];
        let mut coarse_bits = bits.clone();
        let (mut bools, mut more_bools) = (vec![false; n], vec![false; n]);
        let [mut ours, mut sorted, mut theirs, mut others] =
            [(); 4].map(|()| Vec::with_capacity(n));
        let (mut stack, mut other_stack) = (Vec::new(), Vec::new());
        let rounds = Rounds {
            at_least: 9,
            at_most: 41,
            budget: std::time::Duration::from_secs(3),
            ..Rounds::default()
        };
        // So that none finds the frusta fetched by the one before.
        let fetch = || views.iter().for_each(|view| _ = black_box(*view));
        let seconds = rounds.time(&mut [
            &mut &fetch,
            &mut || {
                for view in &views {
                    ours.clear();
                    black_box(&tree.walk(view, level, |ids, _| ours.extend_from_slice(ids)));
                    black_box(&mut ours);
                }
            },
            &mut &fetch,
            &mut || {
                for view in &views {
                    sorted.clear();
                    let visit = |ids: &[u32], _| sorted.extend_from_slice(ids);
                    black_box(&tree.walk_near_to_far(view, level, visit));
                    black_box(&mut sorted);
                }
            },
            &mut &fetch,
            &mut || {
                for view in &views {
                    wide.visible_into(view, level, &mut bits);
                    black_box(&mut bits);
                }
            },
            &mut &fetch,
            &mut || {
                for view in &views {
                    flat.visible(&Planes::new(view), &mut bools);
                    black_box(&mut bools);
                }
            },
            &mut &fetch,
            &mut || {
                for view in &views {
                    sphere.visible(&Planes::new(view), &mut more_bools);
                    black_box(&mut more_bools);
                }
            },
            &mut &fetch,
            &mut || {
                for view in &views {
                    theirs.clear();
                    obvhs.walk(&Planes::new(view), &mut stack, &mut theirs);
                    black_box(&mut theirs);
                }
            },
            &mut &fetch,
            &mut || {
                for view in &views {
                    others.clear();
                    bvh.walk(&Planes::new(view), &mut other_stack, &mut others);
                    black_box(&mut others);
                }
            },
            &mut &fetch,
            &mut || {
                for view in &views {
                    coarse.visible_into(view, level, &mut coarse_bits);
                    black_box(&mut coarse_bits);
                }
            },
        ]);
        let seconds: Vec<_> = seconds.into_iter().skip(1).step_by(2).collect();
        let least =
            |i: usize| seconds[i].iter().copied().fold(f64::INFINITY, f64::min) / n_views as f64;
        let ratio = |a: usize, b: usize| {
            let ratios = Comparison::of(&seconds[a], &seconds[b]).expect("rounds").ratios;
            format!("{:.1}", ratios.median)
        };
        let mean_seen = views.iter().map(|view| seen(&wide, view)).sum::<f64>() / n_views as f64;
        table.push([
            world.name().to_string(),
            n.to_string(),
            sees.name(),
            format!("{:.1}%", 100.0 * mean_seen),
            format!("{:.3}", 1e6 * least(0)),
            format!("{:.3}", 1e6 * least(1)),
            format!("{:.2}", 1e9 * least(2) / n as f64),
            format!("{:.2}", 1e9 * least(7) / n as f64),
            ratio(7, 2),
            format!("{:.2}", 1e9 * least(3) / n as f64),
            ratio(2, 3),
            ratio(0, 4),
            ratio(0, 5),
            ratio(0, 6),
            ratio(0, 2),
            ratio(0, 3),
        ]);
    }
}
