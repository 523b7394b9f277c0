use std::fmt::{Display, LowerExp};

/// No number of a source may be larger in magnitude.
///
/// The runtime computes in `f32`, which ends at 3.4e38. Differences, box extents and sums of a few products of a
/// number of this size with one near one stay below that end; the tree builders promise to work up to here.
pub const MAX_MAGNITUDE: f32 = 1e30;

/// Why a number cannot be used, if so; it is shown with the digits that its type has.
pub(super) fn flaw<T: Into<f64> + Display + LowerExp + Copy>(value: T) -> Option<String> {
    let wide: f64 = value.into();
    if wide.is_finite() && wide.abs() <= f64::from(MAX_MAGNITUDE) {
        None
    } else if wide.is_finite() {
        Some(format!(
            "is {value:e}; magnitudes above {MAX_MAGNITUDE:e} overflow the runtime's arithmetic, rescale the scene"
        ))
    } else {
        Some(format!("is {value}; expected a finite number"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_itself_is_accepted() {
        let limit = f64::from(MAX_MAGNITUDE);
        assert_eq!([0.0, -limit, limit].map(flaw), [None, None, None]);
        assert!(
            [f64::NAN, f64::INFINITY, limit * 1.000_001]
                .into_iter()
                .all(|value| flaw(value).is_some())
        );
    }
}
