use super::WideNode;
use crate::Aabb;
use restpose_formats::rows::WideChild;

/// Gives every place its box anew, from the leaves up; `leaf_box` says those of the leaves, none of whose sides is NaN.
/// An empty one keeps its leaf from being entered.
///
/// Linear in the nodes. Complexity of more than one tree in `nodes`: the same, all are refitted.
pub(crate) fn refit(nodes: &mut [WideNode], leaf_box: impl Fn(u32) -> Aabb) {
    // Children stand behind their parents.
    for at in (0..nodes.len()).rev() {
        let mut node = nodes[at];
        for place in 0..8 {
            let bounds = match WideChild::unpack(node.children[place]) {
                WideChild::Empty => Aabb::EMPTY,
                WideChild::Node(child) => nodes[child as usize].around(),
                WideChild::Leaf(leaf) => leaf_box(leaf),
            };
            node.set_bounds(place, &bounds);
        }
        nodes[at] = node;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wide::append_rows;
    use restpose_formats::rows::WideNodeRow;

    fn row(children: &[WideChild]) -> WideNodeRow {
        let mut row = WideNodeRow::EMPTY;
        for (word, child) in row.children.iter_mut().zip(children) {
            *word = child.pack();
        }
        row
    }

    fn point(leaf: u32) -> Aabb {
        match leaf {
            13 => Aabb::EMPTY,
            leaf => Aabb::around([[leaf as f32, -(leaf as f32), 0.0]]),
        }
    }

    #[test]
    fn joined_trees_are_refitted_as_one() {
        use WideChild::{Leaf, Node};
        let top = [row(&[Leaf(0), Leaf(1)])];
        let first = [
            row(&[Node(1), Leaf(10), Node(2)]),
            row(&[Leaf(11)]),
            row(&[Leaf(12), Leaf(13)]),
        ];
        let second = [row(&[Leaf(13)])];
        let mut nodes = vec![WideNode::EMPTY];
        assert_eq!(append_rows(&mut nodes, &top, |leaf| Node([2, 5][leaf as usize])), 1);
        assert_eq!(append_rows(&mut nodes, &first, Leaf), 2);
        assert_eq!(append_rows(&mut nodes, &second, Leaf), 5);
        let stale = Aabb::around([[1e9; 3], [-1e9; 3]]);
        for node in &mut nodes {
            (0..8).for_each(|place| node.set_bounds(place, &stale));
        }
        refit(&mut nodes, point);

        let over = |leaves: &[u32]| leaves.iter().fold(Aabb::EMPTY, |union, leaf| union.union(point(*leaf)));
        assert_eq!(nodes[0], WideNode::EMPTY);
        assert_eq!(nodes[1].children[..2], [Node(2).pack(), Node(5).pack()]);
        assert_eq!(nodes[1].bounds(0), over(&[10, 11, 12]));
        assert!(nodes[1].bounds(1).is_empty() && nodes[5].around().is_empty());
        assert_eq!(
            nodes[2].children[..3],
            [Node(3).pack(), Leaf(10).pack(), Node(4).pack()]
        );
        assert_eq!(
            [0, 1, 2].map(|place| nodes[2].bounds(place)),
            [over(&[11]), over(&[10]), over(&[12])]
        );
        assert_eq!(nodes[4].bounds(0), point(12));
        assert!((1..8).all(|place| nodes[4].bounds(place).is_empty()));
        assert_eq!(nodes[1].around(), over(&[10, 11, 12]));
    }
}
