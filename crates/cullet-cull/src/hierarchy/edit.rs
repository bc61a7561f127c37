//! Changing a tree that stands: moved boxes, new ones, fewer.
//!
//! [`Tree::refit`] keeps the shape and fits the boxes of the nodes to what moved. Insertion goes
//! down where a box grows least (Guttman, "R-Trees: A Dynamic Index Structure for Spatial
//! Searching", 1984) and splits the leaf it finds full. When that has made a path longer than
//! twice what balance asks for, the lowest node on it that is to blame is built anew (Galperin and
//! Rivest, "Scapegoat Trees", 1993), so that no order of insertions makes a tree deep or slow.
//!
//! Stored boxes grow with their distance from the one origin they count from, and f32 does not
//! give back what they were. So an insertion far from it waits beside the tree, as it is, until there
//! are enough of them to ask whether the origin should follow ([`Tree::settle`]); [`Tree::refit`],
//! which is given the boxes again, asks each time.

use alloc::vec::Vec;

use super::build::{Item, Split, build_nodes, in_turn};
use super::tree::{Child, NO_PARENT, Node, Place, Tree};
use crate::Aabb;
use crate::wide::{Box32, Group, Leaf16, Space, Stored, around};

/// The node and the lane that a link names.
fn split(link: u32) -> (usize, usize) {
    (link as usize / 8, link as usize % 8)
}

fn link(node: usize, lane: usize) -> u32 {
    (8 * node + lane) as u32
}

/// Items looked at to find an origin.
const SAMPLES: usize = 1000;

/// No more items than this wait beside a tree.
const MOST_WAITING: usize = 1024;

/// How many levels `n` items may be spread over, as a balanced tree needs at most half of them.
fn levels_for(n: usize) -> usize {
    4 + 2 * (n.max(1).ilog2() as usize).div_ceil(3)
}

impl Tree {
    /// Item `i` takes `boxes[i]`; numbers without an item are passed over.
    pub fn refit(&mut self, boxes: &[Aabb]) {
        if let Some(space) = self.space_around(boxes).filter(|s| s.is_far_from(&self.space)) {
            self.respace(space, boxes.len());
        }
        let mut moved = Vec::new(); // in, out or beside
        for (id, bounds) in boxes.iter().enumerate().take(self.places.len()) {
            match (self.space.store(bounds), self.places[id]) {
                (_, Place::Nowhere) | (Stored::Empty, Place::Empty) => {}
                (Stored::Bounded(stored), Place::Slot(slot)) => {
                    self.groups[slot as usize / 8].set(slot as usize % 8, &stored);
                }
                (Stored::Beside, Place::Beside(index)) => self.beside[index as usize].1 = *bounds,
                (Stored::Bounded(stored), Place::Beside(index)) if stored.is_far() => {
                    self.beside[index as usize].1 = *bounds;
                }
                _ => moved.push(id as u32),
            }
        }
        self.fit_nodes();
        for id in moved {
            self.remove(id);
            self.insert(id, &boxes[id as usize]);
        }
    }

    /// Fits the boxes of all nodes to what lies below them.
    fn fit_nodes(&mut self) {
        let mut order = self.nodes_below(0);
        while let Some(index) = order.pop() {
            for lane in 0..8 {
                let child = self.nodes[index].children[lane];
                if !child.is_absent() {
                    let bounds = self.bounds_below(child);
                    self.nodes[index].bounds.set(lane, &bounds);
                    self.pack_leaf(child);
                }
            }
        }
        self.bounds = around(&self.groups);
    }

    /// A space around some of the items, those in `moved` as they are there; `None` without a
    /// finite box.
    fn space_around(&self, moved: &[Aabb]) -> Option<Space> {
        let step = self.places.len().div_ceil(SAMPLES).max(1);
        let places = self.places.iter().enumerate().step_by(step);
        let mut sample: Vec<Aabb> = places
            .filter_map(|(id, place)| match (place, moved.get(id)) {
                (Place::Nowhere, _) | (Place::Empty, None) => None,
                (_, Some(bounds)) => Some(*bounds),
                (Place::Beside(index), None) => Some(self.beside[*index as usize].1),
                (Place::Slot(slot), None) => {
                    let (group, lane) = split(*slot);
                    Some(self.space.restore(&self.groups[group].get(lane)))
                }
            })
            .collect();
        sample.retain(|b| b.min.is_finite() && b.max.is_finite() && !b.is_empty());
        (!sample.is_empty()).then(|| Space::around(&sample))
    }

    /// Stored boxes count from another origin from now on, those of items below `n_moved` as soon as
    /// the caller has stored them. The others are stored as far as they are known: grown twice.
    fn respace(&mut self, space: Space, n_moved: usize) {
        let old = core::mem::replace(&mut self.space, space);
        let mut too_far = Vec::new();
        for slot in 0..self.ids.len() {
            let id = self.ids[slot];
            if id == Tree::NO_ITEM || (id as usize) < n_moved {
                continue;
            }
            let bounds = old.restore(&self.groups[slot / 8].get(slot % 8));
            match space.store(&bounds) {
                Stored::Bounded(stored) => self.groups[slot / 8].set(slot % 8, &stored),
                _ => too_far.push((id, bounds)),
            }
        }
        self.fit_nodes();
        for (id, bounds) in too_far {
            self.remove(id);
            self.n_items += 1;
            self.put_beside(id, &bounds);
        }
    }

    /// Adds item `id`, which is nowhere yet.
    pub fn insert(&mut self, id: u32, bounds: &Aabb) {
        let place = id as usize;
        if self.places.len() <= place {
            self.places.resize(place + 1, Place::Nowhere);
        }
        self.n_items += 1;
        if !self.has_root() {
            self.space = Space::around(&[*bounds]);
            self.bounds = Box32::EMPTY;
        }
        match self.space.store(bounds) {
            Stored::Bounded(stored) if stored.is_far() => {
                self.put_beside(id, bounds);
                self.n_waiting += 1;
                let n_slots = self.ids.len() - 8 * self.free_groups.len();
                if self.n_waiting > (8 + n_slots / 8).min(MOST_WAITING) {
                    self.settle();
                }
            }
            Stored::Bounded(bounds) => self.insert_stored(Item { bounds, id }),
            Stored::Empty => self.places[place] = Place::Empty,
            Stored::Beside => self.put_beside(id, bounds),
        }
    }

    /// Takes what waits beside the tree into it: with an origin around all items, if that suits at
    /// least half of those who wait, and as they are, grown by their distance, otherwise.
    ///
    /// An origin follows when most items have gone elsewhere, so a tree that is grown by insertion
    /// pays for this but a few times: each time as much as for all insertions since the last.
    fn settle(&mut self) {
        self.n_waiting = 0;
        if let Some(space) = self.space_around(&[]) {
            let stored = |space: &Space| {
                let store = |(_, bounds): &(u32, Aabb)| match space.store(bounds) {
                    Stored::Bounded(stored) => Some(stored),
                    _ => None,
                };
                self.beside.iter().filter_map(store).collect::<Vec<Box32>>()
            };
            let n_waiting = stored(&self.space).len();
            let n_suited = stored(&space).iter().filter(|stored| !stored.is_far()).count();
            if 2 * n_suited >= n_waiting {
                self.respace(space, 0);
            }
        }
        for (id, bounds) in self.beside.clone() {
            if let Stored::Bounded(bounds) = self.space.store(&bounds) {
                self.remove(id);
                self.n_items += 1;
                self.insert_stored(Item { bounds, id });
            }
        }
    }

    fn put_beside(&mut self, id: u32, bounds: &Aabb) {
        self.places[id as usize] = Place::Beside(self.beside.len() as u32);
        self.beside.push((id, *bounds));
    }

    /// Takes item `id` away, if there is one.
    pub fn remove(&mut self, id: u32) -> bool {
        let Some(place) = self.places.get_mut(id as usize) else { return false };
        match core::mem::replace(place, Place::Nowhere) {
            Place::Nowhere => return false,
            Place::Empty => {}
            Place::Slot(slot) => self.vacate(slot as usize),
            Place::Beside(index) => {
                self.beside.swap_remove(index as usize);
                if let Some((moved, _)) = self.beside.get(index as usize) {
                    self.places[*moved as usize] = Place::Beside(index);
                }
            }
        }
        self.n_items -= 1;
        true
    }

    fn insert_stored(&mut self, item: Item) {
        self.bounds = self.bounds.union(&item.bounds);
        if self.nodes.is_empty() {
            self.nodes.push(Node::EMPTY);
        }
        if !self.has_root() {
            let group = self.new_leaf(&[item]);
            return self.attach(link(0, 0), Child::leaf(8 * group as u32, 1));
        }
        let (place, level) = self.roomiest(&item.bounds);
        let (node, lane) = split(place);
        let child = self.nodes[node].children[lane];
        let len = child.len as usize;
        self.scatter(self.nodes[node].parent);
        if len < 8 {
            let slot = child.first as usize + len;
            self.put(slot, &item);
            self.nodes[node].children[lane].len += 1;
            return self.refresh(place);
        }
        // Nine items make two leaves.
        let mut items = self.items_of(child);
        items.push(item);
        let (a, b) = halves(&mut items);
        self.free_leaf(child);
        let [a, b] =
            [a, b].map(|items| Child::leaf(8 * self.new_leaf(items) as u32, items.len() as u32));
        let free = (0..8).find(|lane| self.nodes[node].children[*lane].is_absent());
        if let Some(free) = free {
            self.attach(link(node, free), b);
            return self.attach(place, a);
        }
        let below = self.new_node();
        self.attach(place, Child::scattered(below));
        self.attach(link(below, 0), a);
        self.attach(link(below, 1), b);
        if level + 1 >= levels_for(self.ids.len() - 8 * self.free_groups.len()) {
            self.rebalance(place, level);
        }
    }

    /// The leaf, and its level, that grows least by taking in `bounds`.
    fn roomiest(&self, bounds: &Box32) -> (u32, usize) {
        let (mut index, mut level) = (0, 0);
        loop {
            let node = &self.nodes[index];
            let growth = |lane: usize| {
                let own = node.bounds.get(lane);
                let area = own.half_area();
                (own.union(bounds).half_area() - area, area)
            };
            let by_growth = |a: &usize, b: &usize| {
                let ((grows_a, area_a), (grows_b, area_b)) = (growth(*a), growth(*b));
                grows_a.total_cmp(&grows_b).then(area_a.total_cmp(&area_b))
            };
            let lanes = (0..8).filter(|lane| !node.children[*lane].is_absent());
            let lane = lanes.min_by(by_growth).expect("every node has a child");
            let Some(below) = node.children[lane].node() else { return (link(index, lane), level) };
            index = below;
            level += 1;
        }
    }

    /// Takes the item in `slot` out of its leaf, and what that leaves empty out of the tree.
    fn vacate(&mut self, slot: usize) {
        let group = slot / 8;
        let mut place = self.parents[group];
        let (node, lane) = split(place);
        self.scatter(self.nodes[node].parent);
        let child = &mut self.nodes[node].children[lane];
        child.len -= 1;
        let last = (child.first + child.len) as usize;
        let leaf = *child;
        let moved = Item { bounds: self.groups[group].get(last % 8), id: self.ids[last] };
        self.groups[group].clear(last % 8);
        self.ids[last] = Tree::NO_ITEM;
        if last != slot {
            self.put(slot, &moved);
        }
        if leaf.len > 0 {
            return self.refresh(place);
        }
        self.free_leaf(leaf);
        loop {
            let (node, lane) = split(place);
            self.nodes[node].clear(lane);
            place = self.nodes[node].parent;
            if self.nodes[node].present != 0 || place == NO_PARENT {
                return self.refresh(place);
            }
            self.free_nodes.push(node as u32);
        }
    }

    /// Builds the lowest node anew that is too deep for its size, on the way up from `place`, at
    /// `level`, below which a node has just been added.
    fn rebalance(&mut self, mut place: u32, mut level: usize) {
        let mut n_items = self.count(place);
        let mut height = 1;
        while height <= levels_for(n_items) - 2 {
            let (node, lane) = split(place);
            let siblings = (0..8).filter(|other| *other != lane);
            n_items += siblings.map(|other| self.count(link(node, other))).sum::<usize>();
            height += 1;
            if self.nodes[node].parent == NO_PARENT {
                return self.rebuild_root();
            }
            place = self.nodes[node].parent;
            level -= 1;
        }
        let (node, lane) = split(place);
        let Some(top) = self.nodes[node].children[lane].node() else { return };
        let items = self.dissolve(top);
        let top = self.plant(items, level + 1, None);
        self.attach(place, Child::scattered(top));
    }

    fn rebuild_root(&mut self) {
        let items = self.dissolve(0);
        self.free_nodes.retain(|node| *node != 0);
        self.plant(items, 0, Some(0));
    }

    /// Builds nodes over `items`, in places that are free or new, and returns the topmost.
    fn plant(&mut self, mut items: Vec<Item>, level: usize, top: Option<usize>) -> usize {
        let nodes = build_nodes(&mut items, level, Split::Halves, &in_turn);
        let mut homes: Vec<usize> = Vec::with_capacity(nodes.len());
        homes.extend(top);
        while homes.len() < nodes.len() {
            homes.push(self.new_node());
        }
        for (node, home) in nodes.iter().zip(&homes) {
            for (lane, child) in node.children.iter().enumerate() {
                let bounds = node.bounds.get(lane);
                let child = if let Some(below) = child.node() {
                    Child::scattered(homes[below])
                } else if child.group().is_some() {
                    let group = self.new_leaf(&items[child.slots()]);
                    Child::leaf(8 * group as u32, child.len)
                } else {
                    continue;
                };
                self.nodes[*home].set(lane, child, &bounds);
                self.point_up(child, link(*home, lane));
            }
        }
        homes[0]
    }

    /// Frees a node and all below it, and returns the items.
    fn dissolve(&mut self, top: usize) -> Vec<Item> {
        let mut items = Vec::new();
        for index in self.nodes_below(top) {
            for child in self.nodes[index].children {
                if child.group().is_some() {
                    items.append(&mut self.items_of(child));
                    self.free_leaf(child);
                }
            }
            self.nodes[index] = Node { parent: self.nodes[index].parent, ..Node::EMPTY };
            self.free_nodes.push(index as u32);
        }
        items
    }

    /// A node and all below it, parents first.
    pub fn nodes_below(&self, top: usize) -> Vec<usize> {
        let mut order = Vec::new();
        if top < self.nodes.len() {
            order.push(top);
        }
        let mut next = 0;
        while next < order.len() {
            order.extend(self.nodes[order[next]].children.iter().filter_map(|c| c.node()));
            next += 1;
        }
        order
    }

    /// How many items lie below a link.
    fn count(&self, place: u32) -> usize {
        let (node, lane) = split(place);
        let child = self.nodes[node].children[lane];
        let Some(below) = child.node() else { return child.len as usize };
        let leaves = self.nodes_below(below).into_iter().flat_map(|i| self.nodes[i].children);
        leaves.filter(|c| c.group().is_some()).map(|c| c.len as usize).sum()
    }

    fn items_of(&self, leaf: Child) -> Vec<Item> {
        let item =
            |slot: usize| Item { bounds: self.groups[slot / 8].get(slot % 8), id: self.ids[slot] };
        leaf.slots().map(item).collect()
    }

    /// The box around everything in a child.
    pub fn bounds_below(&self, child: Child) -> Box32 {
        match (child.node(), child.group()) {
            (Some(node), _) => self.nodes[node].bounds.union(),
            (_, Some(group)) => self.groups[group].union(),
            _ => Box32::EMPTY,
        }
    }

    /// Makes `child` what `place` leads to.
    fn attach(&mut self, place: u32, child: Child) {
        let (node, lane) = split(place);
        let bounds = self.bounds_below(child);
        self.nodes[node].set(lane, child, &bounds);
        self.point_up(child, place);
        self.refresh(self.nodes[node].parent);
    }

    fn point_up(&mut self, child: Child, place: u32) {
        if let Some(node) = child.node() {
            self.nodes[node].parent = place;
        } else if let Some(group) = child.group() {
            self.parents[group] = place;
            self.pack_leaf(child);
        }
    }

    /// What a walk asks first follows the boxes and items of `child`, if it is a leaf.
    fn pack_leaf(&mut self, child: Child) {
        if let Some(group) = child.group() {
            self.packed[group] = self.pack(group);
        }
    }

    /// Fits the boxes from `place` up to the root to what lies below them.
    fn refresh(&mut self, mut place: u32) {
        while place != NO_PARENT {
            let (node, lane) = split(place);
            let child = self.nodes[node].children[lane];
            let bounds = self.bounds_below(child);
            self.nodes[node].bounds.set(lane, &bounds);
            self.pack_leaf(child);
            place = self.nodes[node].parent;
        }
    }

    /// From `place` up, items no longer lie side by side.
    fn scatter(&mut self, mut place: u32) {
        while place != NO_PARENT {
            let (node, lane) = split(place);
            self.nodes[node].children[lane].len = 0;
            place = self.nodes[node].parent;
        }
    }

    fn put(&mut self, slot: usize, item: &Item) {
        self.groups[slot / 8].set(slot % 8, &item.bounds);
        self.ids[slot] = item.id;
        self.places[item.id as usize] = Place::Slot(slot as u32);
    }

    /// A group with these items, at most eight.
    fn new_leaf(&mut self, items: &[Item]) -> usize {
        let group = match self.free_groups.pop() {
            Some(group) => group as usize,
            None => {
                self.groups.push(Group::ABSENT);
                self.packed.push(Leaf16::EMPTY);
                self.ids.extend([Tree::NO_ITEM; 8]);
                self.parents.push(NO_PARENT);
                self.groups.len() - 1
            }
        };
        for (lane, item) in items.iter().enumerate() {
            self.put(8 * group + lane, item);
        }
        group
    }

    fn free_leaf(&mut self, leaf: Child) {
        if let Some(group) = leaf.group() {
            self.groups[group] = Group::ABSENT;
            self.ids[8 * group..8 * group + 8].fill(Tree::NO_ITEM);
            self.parents[group] = NO_PARENT;
            self.free_groups.push(group as u32);
        }
    }

    fn new_node(&mut self) -> usize {
        match self.free_nodes.pop() {
            Some(node) => {
                self.nodes[node as usize] = Node::EMPTY;
                node as usize
            }
            None => {
                self.nodes.push(Node::EMPTY);
                self.nodes.len() - 1
            }
        }
    }
}

/// Nine items in two halves along the axis on which their centres differ most.
fn halves(items: &mut [Item]) -> (&[Item], &[Item]) {
    let extent = |axis: usize| {
        let centers = items.iter().map(|item| item.bounds.center2(axis));
        let (low, high) = centers
            .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), c| (low.min(c), high.max(c)));
        high - low
    };
    let axis = (0..3).max_by(|&a, &b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
    items.sort_unstable_by(|a, b| {
        a.bounds.center2(axis).total_cmp(&b.bounds.center2(axis)).then(a.id.cmp(&b.id))
    });
    items.split_at(items.len() / 2)
}
