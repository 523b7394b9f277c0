//! Values of options, checked when the command line is read.

use restpose_formats::rows::MotionClass;
use std::{num::NonZeroUsize, str::FromStr};

/// Three finite numbers, written `x,y,z`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vector(pub [f64; 3]);

impl Vector {
    /// Direction towards the light in pictures: from the right, above, in front.
    pub const DEFAULT_LIGHT: Self = Self([0.85, 1.1, 0.55]);
}

impl std::fmt::Display for Vector {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y, z] = self.0;
        write!(f, "{x},{y},{z}")
    }
}

impl FromStr for Vector {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Vec<f64> = text
            .split(',')
            .map(|word| word.trim().parse())
            .collect::<Result<_, _>>()
            .map_err(|_| "expected three numbers written x,y,z".to_owned())?;
        let vector: [f64; 3] = numbers
            .try_into()
            .map_err(|found: Vec<f64>| format!("expected three numbers written x,y,z, found {}", found.len()))?;
        if vector.iter().all(|x| x.is_finite() && x.abs() <= f64::from(f32::MAX)) {
            Ok(Self(vector))
        } else {
            Err("every number must be finite and fit into 32 bits".to_owned())
        }
    }
}

/// A direction: three finite numbers that are not all zero.
pub fn direction(text: &str) -> Result<Vector, String> {
    let vector: Vector = text.parse()?;
    if vector.0.iter().all(|x| *x == 0.0) {
        Err("a direction cannot be 0,0,0".to_owned())
    } else {
        Ok(vector)
    }
}

/// Width and height of a picture, written `WxH`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    pub width: u32,
    pub height: u32,
}

impl Size {
    /// Smallest and largest side in pixels.
    pub const SIDE: std::ops::RangeInclusive<u32> = 16..=8192;
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form = || "expected WIDTHxHEIGHT, such as 512x512".to_owned();
        let (width, height) = text.split_once('x').ok_or_else(form)?;
        let (width, height) = (width.parse().map_err(|_| form())?, height.parse().map_err(|_| form())?);
        if Self::SIDE.contains(&width) && Self::SIDE.contains(&height) {
            Ok(Self { width, height })
        } else {
            Err(format!(
                "each side must be {} to {} pixels",
                Self::SIDE.start(),
                Self::SIDE.end()
            ))
        }
    }
}

impl std::fmt::Display for Size {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

/// A motion class forced on a part, written `PART=CLASS`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ClassOverride {
    pub part: String,
    pub class: MotionClass,
}

impl FromStr for ClassOverride {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        // A part's name may itself hold '='; a class's name never does.
        let (part, class) = text
            .rsplit_once('=')
            .ok_or("expected PART=CLASS, such as body=skinned")?;
        let class = MotionClass::ALL
            .into_iter()
            .find(|known| known.name() == class)
            .ok_or_else(|| {
                let known = MotionClass::ALL.map(MotionClass::name).join(", ");
                format!("no motion class {class:?}; known: {known}")
            })?;
        if part.is_empty() {
            Err("the part's name is empty".to_owned())
        } else {
            Ok(Self {
                part: part.to_owned(),
                class,
            })
        }
    }
}

/// Threads: 1 to 1024.
pub fn threads(text: &str) -> Result<NonZeroUsize, String> {
    match text.parse::<usize>().ok().and_then(NonZeroUsize::new) {
        Some(count) if count.get() <= 1024 => Ok(count),
        _ => Err("expected a whole number from 1 to 1024".to_owned()),
    }
}

/// A finite number in a range that is open below and closed above.
pub fn number_in(text: &str, above: f64, to: f64) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > above && x <= to => Ok(x),
        _ => Err(format!("expected a number above {above}, at most {to}")),
    }
}

/// A finite number in a closed range; `f64::MAX` stands for no upper limit.
pub fn number_from(text: &str, from: f64, to: f64) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x >= from && x <= to => Ok(x),
        _ if to == f64::MAX => Err(format!("expected a finite number, {from} or more")),
        _ => Err(format!("expected a number from {from} to {to}")),
    }
}

/// A whole number from 1.
pub fn count(text: &str, most: usize) -> Result<usize, String> {
    match text.parse::<usize>() {
        Ok(count) if (1..=most).contains(&count) => Ok(count),
        _ => Err(format!("expected a whole number from 1 to {most}")),
    }
}

/// `on` or `off`.
pub fn switch(text: &str) -> Result<bool, String> {
    match text {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err("expected on or off".to_owned()),
    }
}

/// A time in seconds: finite, not negative.
pub fn seconds(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(x) if x.is_finite() && x >= 0.0 => Ok(x),
        _ => Err("expected seconds, 0 or more".to_owned()),
    }
}

/// An angle in degrees: finite.
pub fn degrees(text: &str, from: f64, to: f64) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x >= from && x <= to => Ok(x),
        _ => Err(format!("expected degrees, {from} to {to}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vector_needs_three_finite_numbers() {
        assert_eq!("1, -2,3e2".parse(), Ok(Vector([1.0, -2.0, 300.0])));
        for wrong in ["", "1,2", "1,2,3,4", "1,2,x", "1,2,nan", "1,2,inf", "1,2,1e39"] {
            assert!(wrong.parse::<Vector>().is_err(), "{wrong:?}");
        }
        assert!(direction("0,0,0").is_err());
        assert!(direction("0,-1,0").is_ok());
    }

    #[test]
    fn a_size_needs_two_sides_in_range() {
        assert_eq!(
            "640x480".parse(),
            Ok(Size {
                width: 640,
                height: 480
            })
        );
        for wrong in [
            "",
            "640",
            "640x",
            "x480",
            "15x480",
            "640x8193",
            "-640x480",
            "640X480",
            "640x480x3",
        ] {
            assert!(wrong.parse::<Size>().is_err(), "{wrong:?}");
        }
    }

    #[test]
    fn a_class_override_splits_at_the_last_equals_sign() {
        let parsed = "a=b=rigid".parse();
        assert_eq!(
            parsed,
            Ok(ClassOverride {
                part: "a=b".to_owned(),
                class: MotionClass::Rigid
            })
        );
        for wrong in ["", "body", "body=", "=rigid", "body=liquid"] {
            assert!(wrong.parse::<ClassOverride>().is_err(), "{wrong:?}");
        }
    }

    #[test]
    fn numbers_out_of_range_are_refused() {
        assert_eq!(number_in("0.5", 0.0, 1.0), Ok(0.5));
        for wrong in ["0", "-1", "1.5", "nan", "inf", "x"] {
            assert!(number_in(wrong, 0.0, 1.0).is_err(), "{wrong:?}");
        }
        assert_eq!(number_from("0", 0.0, 1.0), Ok(0.0));
        assert_eq!(number_from("1e300", 0.0, f64::MAX), Ok(1e300));
        for wrong in ["-0.1", "1.1", "nan", "inf"] {
            assert!(number_from(wrong, 0.0, 1.0).is_err(), "{wrong:?}");
        }
        assert!(number_from("inf", 0.0, f64::MAX).is_err());
        assert!(count("1", 9).is_ok() && count("9", 9).is_ok());
        assert!(count("0", 9).is_err() && count("10", 9).is_err() && count("2.5", 9).is_err());
        assert!(switch("on") == Ok(true) && switch("off") == Ok(false) && switch("true").is_err());
        assert!(seconds("0").is_ok() && seconds("-0.1").is_err() && seconds("inf").is_err());
        assert!(threads("1").is_ok() && threads("0").is_err() && threads("1025").is_err());
    }
}
