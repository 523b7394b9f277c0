use super::WideNode;
#[cfg(target_arch = "x86_64")]
use crate::simd::Avx2;
use crate::{
    Aabb,
    box_tree::triangle_box,
    simd::{Lanes, Portable, SimdLevel},
};
use restpose_formats::rows::{TriangleRow, WideChild};

/// Gives every place its box anew, from the leaves up; `leaf_box` says those of the leaves, none of whose sides is NaN.
/// An empty one keeps its leaf from being entered.
///
/// Linear in the nodes. Where several trees are in `nodes`, all are refitted.
pub(crate) fn refit(nodes: &mut [WideNode], leaf_box: impl Fn(u32) -> Aabb) {
    // Children stand behind their parents.
    for at in (0..nodes.len()).rev() {
        refit_node(nodes, at, &leaf_box);
    }
}

fn refit_node(nodes: &mut [WideNode], at: usize, leaf_box: &impl Fn(u32) -> Aabb) {
    let (before, behind) = nodes.split_at_mut(at + 1);
    let node = &mut before[at];
    for place in 0..8 {
        let bounds = match WideChild::unpack(node.children[place]) {
            WideChild::Empty => Aabb::EMPTY,
            WideChild::Node(child) => behind[child as usize - at - 1].around(),
            WideChild::Leaf(leaf) => leaf_box(leaf),
        };
        node.set_bounds(place, &bounds);
    }
}

/// [`refit`] for leaves that are triangle rows, whose corners are in `positions`, by vertex row. A triangle of which a
/// corner overflowed has no place.
pub(crate) fn refit_triangles(
    level: SimdLevel,
    nodes: &mut [WideNode],
    triangles: &[TriangleRow],
    positions: &[[f32; 3]],
) {
    #[cfg(target_arch = "x86_64")]
    if let (SimdLevel::Avx2, Some(simd)) = (level, Avx2::new()) {
        #[target_feature(enable = "avx2,popcnt")]
        fn compiled(simd: Avx2, nodes: &mut [WideNode], triangles: &[TriangleRow], positions: &[[f32; 3]]) {
            refit_triangles_with(simd, nodes, triangles, positions);
        }
        #[expect(unsafe_code, reason = "calls what is compiled for AVX2")]
        // SAFETY: an `Avx2` exists only on machines that have both features.
        return unsafe { compiled(simd, nodes, triangles, positions) };
    }
    refit_triangles_with(Portable, nodes, triangles, positions);
}

#[inline(always)]
fn refit_triangles_with<S: Lanes>(simd: S, nodes: &mut [WideNode], triangles: &[TriangleRow], positions: &[[f32; 3]]) {
    let empty = simd.join(simd.splat4(f32::INFINITY), simd.splat4(f32::NEG_INFINITY));
    // Memory takes the time, and most of that the nodes: to ask for rows and corners a few nodes ahead took 2 % more for 1.35 million
    // triangles, 40 % more for 9,000.
    for at in (0..nodes.len()).rev() {
        // Lanes of a box: its least corner, nothing, its greatest corner, nothing.
        let mut boxes = [empty; 8];
        let mut sum = simd.splat4(0.0);
        for place in 0..8 {
            match WideChild::unpack(nodes[at].children[place]) {
                WideChild::Empty => {}
                WideChild::Node(child) => boxes[place] = around(simd, &nodes[child as usize]),
                WideChild::Leaf(triangle) => {
                    let [a, b, c] = triangles[triangle as usize].corners;
                    let a = load_corner(simd, positions, a);
                    let b = load_corner(simd, positions, b);
                    let c = load_corner(simd, positions, c);
                    sum = simd.add4(sum, simd.add4(simd.add4(a, b), c));
                    let (min, max) = (simd.min4(simd.min4(a, b), c), simd.max4(simd.max4(a, b), c));
                    boxes[place] = simd.join(min, max);
                }
            }
        }
        let [x, y, z, _] = simd.store4(sum);
        if !((x + y) + z).is_finite() {
            // Some corner may be no place.
            let corners = |triangle: u32| {
                let [a, b, c] = triangles[triangle as usize].corners;
                [positions[a as usize], positions[b as usize], positions[c as usize]]
            };
            refit_node(nodes, at, &|triangle| triangle_box(corners(triangle)));
            continue;
        }
        let planes = simd.transpose8(boxes);
        let node = &mut nodes[at];
        for k in 0..3 {
            simd.store8(planes[k], &mut node.planes[0][k]);
            simd.store8(planes[4 + k], &mut node.planes[1][k]);
        }
    }
}

/// The three coordinates of a vertex, and one that means nothing.
#[inline(always)]
fn load_corner<S: Lanes>(simd: S, positions: &[[f32; 3]], vertex: u32) -> S::F4 {
    let numbers = positions.as_flattened();
    match numbers
        .get(3 * vertex as usize..)
        .and_then(|from| from.first_chunk::<4>())
    {
        Some(four) => simd.load4(four),
        // The last vertex.
        None => {
            let [x, y, z] = positions[vertex as usize];
            simd.load4(&[x, y, z, 0.0])
        }
    }
}

/// The box around all places of a node, as lanes.
#[inline(always)]
fn around<S: Lanes>(simd: S, node: &WideNode) -> S::F8 {
    let mut planes = [simd.splat8(0.0); 8];
    for k in 0..3 {
        planes[k] = simd.load8(&node.planes[0][k]);
        planes[4 + k] = simd.load8(&node.planes[1][k]);
    }
    let boxes = simd.transpose8(planes);
    let (mut least, mut greatest) = (boxes[0], boxes[0]);
    for place in 1..8 {
        least = simd.min8(least, boxes[place]);
        greatest = simd.max8(greatest, boxes[place]);
    }
    simd.join(simd.halves(least)[0], simd.halves(greatest)[1])
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

    #[test]
    fn triangles_are_refitted_as_their_boxes() {
        let mut random = fastrand::Rng::with_seed(41);
        for round in 0..400 {
            let count = random.usize(1..50);
            let mut positions: Vec<[f32; 3]> = (0..count)
                .map(|_| std::array::from_fn(|_| random.f32() * 2.0 - 1.0))
                .collect();
            for _ in 0..round % 3 {
                let place = random.usize(..count);
                positions[place][random.usize(..3)] = [f32::NAN, f32::INFINITY, f32::MAX, -0.0][random.usize(..4)];
            }
            let mut corners = |_| std::array::from_fn(|_| random.u32(..count as u32));
            let triangles: Vec<TriangleRow> = (0..20).map(|at| TriangleRow { corners: corners(at) }).collect();
            let node = |children: &[WideChild]| WideNode {
                children: row(children).children,
                ..WideNode::EMPTY
            };
            let leaves = |range: std::ops::Range<u32>| range.map(WideChild::Leaf).collect::<Vec<_>>();
            let mut expected = vec![
                node(&[WideChild::Node(1), WideChild::Leaf(19), WideChild::Node(2)]),
                node(&leaves(0..8)),
                node(&leaves(8..11)),
            ];
            let mut levels = [expected.clone(), expected.clone()];
            refit(&mut expected, |triangle| {
                triangle_box(
                    triangles[triangle as usize]
                        .corners
                        .map(|corner| positions[corner as usize]),
                )
            });
            refit_triangles(SimdLevel::Portable, &mut levels[0], &triangles, &positions);
            refit_triangles(SimdLevel::detect(), &mut levels[1], &triangles, &positions);
            assert_eq!(levels[0], expected, "round {round}");
            assert_eq!(levels[1], expected, "round {round}");
        }
    }
}
