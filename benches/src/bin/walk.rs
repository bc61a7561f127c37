//! The walk through the tree alone: a million boxes (or as many as the argument says), with cold and
//! warm caches, each view by itself; and how fast one core reads memory meanwhile.

use std::hint::black_box;
use std::time::Instant;

use cullet_benches::boxes::{Sees, World};
use cullet_benches::memory::Memory;
use cullet_cull::Hierarchy;
use cullet_cull::wide::Level;
use cullet_measure::{Align, Table};

const ROUNDS: usize = 15;

fn main() {
    let n: usize = std::env::args().nth(1).map_or(1_000_000, |n| n.parse().expect("a number"));
    let level = Level::new();
    let mut memory = Memory::default();
    let right = Align::Right;
    let mut table = Table::new(&[
        ("world", Align::Left),
        ("sees", right),
        ("cold us", right),
        ("warm us", right),
        ("groups tested", right),
        ("items", right),
        ("untested", right),
    ]);
    for world in [World::Random, World::City] {
        let boxes = world.boxes(n);
        let tree = Hierarchy::build(&boxes);
        let mut out: Vec<u32> = Vec::with_capacity(n);
        for sees in [Sees::Part(0.01), Sees::Part(0.1), Sees::All] {
            let views = sees.views(&boxes, 4);
            let mut times = [0.0; 2];
            let mut stats = Default::default();
            for view in &views {
                let mut least = [f64::INFINITY; 2];
                for _ in 0..ROUNDS {
                    memory.read();
                    // Where the answer goes is warm either way.
                    out.clear();
                    out.resize(n, 0);
                    black_box(&mut out);
                    for least in &mut least {
                        out.clear();
                        let start = Instant::now();
                        stats = black_box(tree.walk(view, level, |ids, _| {
                            out.extend_from_slice(ids);
                        }));
                        *least = least.min(start.elapsed().as_secs_f64());
                    }
                }
                (0..2).for_each(|i| times[i] += 1e6 * least[i] / views.len() as f64);
            }
            table.push([
                world.name().to_string(),
                sees.name(),
                format!("{:.1}", times[0]),
                format!("{:.1}", times[1]),
                stats.n_groups.to_string(),
                stats.n_visible.to_string(),
                stats.n_untested.to_string(),
            ]);
        }
    }
    print!("{table}");
    println!("one core reads {:.1} GB/s", memory.gb_per_s());
}
