//! Depth study: how close two planes may be, for every depth format and mapping, and what one
//! combined f32 matrix does to the order of close points. Writes a table to standard output and,
//! with a file name as argument, a plot (SVG).

use cullet_benches::depth::plot::{Panel, svg};
use cullet_benches::depth::transform::{Depth, swapped};
use cullet_benches::depth::{Format, Mapping, measure};
use cullet_measure::{Align, Table};

const MAPPINGS: [Mapping; 3] = [
    Mapping { near: 0.1, far: 1e4 },
    Mapping { near: 0.1, far: 1e9 },
    Mapping { near: 0.1, far: f64::INFINITY },
];

fn main() {
    let panels = MAPPINGS.map(panel);
    for panel in &panels {
        println!("{}: smallest separation / distance, measured (one code)\n", panel.title);
        println!("{}", table(panel));
    }
    println!(
        "Order of close points through one combined f32 matrix, near .1, distances 1 to 1e4\n"
    );
    println!("{}", orders());
    if let Some(path) = std::env::args_os().nth(1)
        && let Err(error) = std::fs::write(&path, svg(&panels))
    {
        eprintln!("{}: {error}", path.display());
        std::process::exit(1);
    }
}

fn panel(mapping: Mapping) -> Panel {
    let distances = (-1..=24).map(|half| 10_f64.powf(0.5 * f64::from(half)));
    let distances: Vec<f64> = distances.filter(|d| *d < 0.9 * mapping.far).collect();
    let curves = Format::ALL.map(|format| {
        let points = distances.iter().map(|&distance| measure(format, mapping, distance));
        (format.name(), points.collect())
    });
    Panel { title: format!("near {}, far {}", mapping.near, mapping.far), curves: curves.to_vec() }
}

fn table(panel: &Panel) -> Table {
    let mut columns = vec![("distance", Align::Right)];
    columns.extend(panel.curves.iter().map(|(name, _)| (*name, Align::Right)));
    let mut table = Table::new(&columns);
    for (i, point) in panel.curves[0].1.iter().enumerate().filter(|(i, _)| i % 2 == 1) {
        let mut row = vec![format!("{:.0e}", point.distance)];
        for (_, points) in &panel.curves {
            let number = |x: f64| if x.is_finite() { format!("{x:.1e}") } else { "none".into() };
            row.push(format!("{} ({})", number(points[i].measured), number(points[i].predicted)));
        }
        table.push(row);
    }
    table
}

fn orders() -> Table {
    let right = Align::Right;
    let mut table = Table::new(&[
        ("mapping", Align::Left),
        ("apart, codes of standard f32", right),
        ("swapped", right),
        ("equal", right),
    ]);
    for (name, reversed, far) in [
        ("standard, far 1e4", false, 1.0001e4),
        ("standard, far infinite", false, f64::INFINITY),
        ("reversed, far 1e4", true, 1.0001e4),
        ("reversed, far infinite", true, f64::INFINITY),
    ] {
        for codes in [0.5, 1.0, 2.0, 4.0] {
            let [swapped, equal] = swapped(Depth { reversed, far }, codes, 200_000);
            let percent = |share: f64| format!("{:.2}%", 100.0 * share);
            table.push([name.into(), format!("{codes}"), percent(swapped), percent(equal)]);
        }
    }
    table
}
