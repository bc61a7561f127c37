//! Draws every golden picture anew: `cargo bless [NAME…]`. Look at each one that changed
//! before you commit it.

use cullet_tests::golden::{all, save};

fn main() {
    let names: Vec<String> = std::env::args().skip(1).collect();
    for golden in all() {
        if names.is_empty() || names.contains(&golden.name) {
            save(&golden.render(), &golden.path());
            println!("blessed {}", golden.name);
        }
    }
}
