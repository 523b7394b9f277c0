use restpose_formats::geom::Aabb;
use restpose_runtime::build::KdSettings;

/// What cutting a cell costs, Eq. 4.3, in single precision and free of the cell's scale.
///
/// A cell's measure is half its surface area. Of a part from the lower side up to the share t of the cell's length along
/// an axis, it is c + t·(1 − c) of the cell's, where c is what a flat part has. A cell that is a mere line segment is
/// measured by its length: c is zero.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellCost {
    /// c per axis; infinite along an axis without extent, where no cut is possible. The fourth lane is idle.
    pub flat: [f32; 4],
    /// The cell's lower sides.
    pub min: [f32; 4],
    /// One over the cell's lengths; zero along an axis without extent.
    pub inverse: [f32; 4],
    pub traversal: f32,
    pub intersection: f32,
    pub bonus: f32,
}

impl CellCost {
    pub(super) fn new(cell: &Aabb, settings: &KdSettings) -> Self {
        // In double precision the lengths of the largest cells and the areas of the smallest stay numbers.
        let side: [f64; 3] = std::array::from_fn(|k| f64::from(cell.max[k]) - f64::from(cell.min[k]));
        let area = half_area(side);
        let per_area = if area > 0.0 { 1.0 / area } else { 0.0 };
        let [x, y, z] = side;
        let faces = [y * z, z * x, x * y];
        let (mut flat, mut min, mut inverse) = ([f32::INFINITY; 4], [0.0; 4], [0.0; 4]);
        for k in 0..3 {
            min[k] = cell.min[k];
            if side[k] > 0.0 {
                inverse[k] = 1.0 / side[k] as f32;
                flat[k] = (faces[k] * per_area) as f32;
            }
        }
        Self {
            flat,
            min,
            inverse,
            traversal: settings.traversal_cost as f32,
            intersection: settings.intersection_cost as f32,
            bonus: settings.empty_bonus as f32,
        }
    }

    /// C_Part of a cut at a share `t` of the length along `axis`, with `left` and `right` primitives; times the bonus if
    /// one is zero.
    #[inline]
    pub(super) fn cut(&self, axis: usize, t: f32, left: f32, right: f32) -> f32 {
        let flat = self.flat[axis];
        let rim = t * (1.0 - flat);
        self.total(left * (flat + rim) + right * (1.0 - rim), left, right)
    }

    /// C_Part from the tests that a ray in the cell is expected to make.
    #[inline]
    pub(super) fn total(&self, tests: f32, left: f32, right: f32) -> f32 {
        let cost = self.traversal + self.intersection * tests;
        if left == 0.0 || right == 0.0 {
            cost * self.bonus
        } else {
            cost
        }
    }

    /// The cost of a leaf.
    #[inline]
    pub(super) fn leaf(&self, count: usize) -> f32 {
        self.intersection * count as f32
    }

    /// Where a position lies along the cell: 0 at its lower side, 1 at its upper.
    #[inline]
    pub(super) fn share(&self, axis: usize, position: f32) -> f32 {
        (position - self.min[axis]) * self.inverse[axis]
    }
}

/// Half the surface area of a box with the sides `side`.
pub(super) fn half_area(side: [f64; 3]) -> f64 {
    let [x, y, z] = side;
    x * y + y * z + z * x
}
