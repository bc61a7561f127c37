//! The parts of a tree.

use alloc::vec::Vec;

use crate::Aabb;
use crate::wide::{Box32, Group, Leaf16, Space};

/// `parent` of the root.
pub(super) const NO_PARENT: u32 = u32::MAX;

/// What a lane of a node leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Child {
    /// A node, or one of the two marks below.
    node: u32,
    /// The first slot below.
    pub first: u32,
    /// How many slots below, side by side and each with an item; 0 when they are not.
    pub len: u32,
}

const LEAF: u32 = u32::MAX;
const ABSENT: u32 = u32::MAX - 1;

impl Child {
    pub const ABSENT: Child = Child { node: ABSENT, first: 0, len: 0 };

    /// A leaf: `len` items, 1 to 8, from slot `first`, a multiple of 8.
    pub fn leaf(first: u32, len: u32) -> Child {
        Child { node: LEAF, first, len }
    }

    /// A node, the first until [`Child::shift`] moves it, over `len` items from slot `first`.
    pub fn inner(first: u32, len: u32) -> Child {
        Child { node: 0, first, len }
    }

    /// A node below which items do not lie side by side.
    pub fn scattered(node: usize) -> Child {
        Child { node: node as u32, first: 0, len: 0 }
    }

    /// The index of its node, if it has one.
    #[inline(always)]
    pub fn node(self) -> Option<usize> {
        (self.node < ABSENT).then_some(self.node as usize)
    }

    /// The index of its leaf group, if it is a leaf.
    #[inline(always)]
    pub fn group(self) -> Option<usize> {
        (self.node == LEAF).then_some(self.first as usize / 8)
    }

    pub fn is_absent(self) -> bool {
        self.node == ABSENT
    }

    /// Its slots, if they are side by side and none is empty.
    #[inline(always)]
    pub fn slots(self) -> core::ops::Range<usize> {
        self.first as usize..(self.first + self.len) as usize
    }

    /// Moves its node by `offset`.
    pub fn shift(&mut self, offset: u32) {
        if self.node < ABSENT {
            self.node += offset;
        }
    }
}

/// Up to eight children.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Node {
    /// The boxes of the children; absent where there is none.
    pub bounds: Group,
    pub children: [Child; 8],
    /// Eight times the node above, plus the lane in it.
    pub parent: u32,
    /// One bit per child there is.
    pub present: u8,
    /// One bit per child that is a leaf.
    pub leaves: u8,
}

impl Node {
    pub const EMPTY: Node = Node {
        bounds: Group::ABSENT,
        children: [Child::ABSENT; 8],
        parent: NO_PARENT,
        present: 0,
        leaves: 0,
    };

    /// One bit per child below which items do not lie side by side.
    #[inline(always)]
    pub fn scattered(&self) -> u8 {
        let lanes = self.children.iter().enumerate();
        lanes.fold(0, |bits, (lane, child)| bits | u8::from(child.len == 0) << lane)
    }

    /// Puts a child in `lane`.
    pub fn set(&mut self, lane: usize, child: Child, bounds: &Box32) {
        self.children[lane] = child;
        self.bounds.set(lane, bounds);
        self.present |= 1 << lane;
        self.leaves &= !(1 << lane);
        self.leaves |= u8::from(child.group().is_some()) << lane;
    }

    /// Takes the child in `lane` away.
    pub fn clear(&mut self, lane: usize) {
        self.children[lane] = Child::ABSENT;
        self.bounds.clear(lane);
        self.present &= !(1 << lane);
        self.leaves &= !(1 << lane);
    }

    /// Moves the nodes of all children by `offset`.
    pub fn shift(&mut self, offset: u32) {
        self.children.iter_mut().for_each(|child| child.shift(offset));
    }
}

/// Where an item is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// There is no such item.
    Nowhere,
    /// Nowhere: its box holds no point.
    Empty,
    /// At this index of the list beside the tree.
    Beside(u32),
    /// In this slot.
    Slot(u32),
}

/// All of it.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    pub space: Space,
    /// Around all stored boxes; may be larger than need be.
    pub bounds: Box32,
    /// The root is the first; nodes taken out of use stay until one is needed.
    pub nodes: Vec<Node>,
    /// The boxes of the items, leaf by leaf.
    pub groups: Vec<Group>,
    /// The same in less memory, with the items they belong to.
    pub packed: Vec<Leaf16>,
    /// The item in each slot: lane `l` of group `g` is slot `8 g + l`.
    pub ids: Vec<u32>,
    /// By group, like [`Node::parent`].
    pub parents: Vec<u32>,
    /// By item.
    pub places: Vec<Place>,
    /// Items that have no stored box, or are too far out for a good one, with the box they have.
    pub beside: Vec<(u32, Aabb)>,
    /// How many of the latter came since it was last asked where to put them.
    pub n_waiting: usize,
    pub free_nodes: Vec<u32>,
    pub free_groups: Vec<u32>,
    pub n_items: usize,
}

impl Tree {
    /// In an empty slot.
    pub const NO_ITEM: u32 = u32::MAX;

    /// What [`Tree::packed`] holds of a group with items.
    pub fn pack(&self, group: usize) -> Leaf16 {
        let (ids, _) = self.ids.as_chunks();
        Leaf16::new(&self.groups[group], &ids[group])
    }

    /// Whether there is any node in use.
    pub fn has_root(&self) -> bool {
        self.nodes.first().is_some_and(|root| root.present != 0)
    }
}
