use super::lines::Lines;
use crate::import::{Fault, fault_list::FaultList, magnitude};

/// Takes the statements of an OBJ file, in order.
pub(in crate::import) trait Sink {
    /// `v`: one more point. One that cannot be read is given as zeros, after a fault, so that the others keep their
    /// numbers.
    fn point(&mut self, position: [f32; 3]);

    /// `f`: the points of its corners, counted from 0, of any number; those that come later in the file may not exist.
    fn face(&mut self, corners: &[u32], line: usize, faults: &mut FaultList);

    /// `o` or `g`: the faces that follow belong to this group.
    fn group(&mut self, name: &str);
}

/// The group of a `g` without a name, says the format.
const DEFAULT_GROUP: &str = "default";

/// Statements that make or fetch geometry which is not read.
const UNREAD_GEOMETRY: [&[u8]; 4] = [b"curv", b"curv2", b"surf", b"call"];

/// Reads an OBJ file. What cannot be read is a fault at `line N`, and the reading goes on.
pub(in crate::import) fn read(bytes: &[u8], sink: &mut impl Sink, faults: &mut FaultList) {
    let mut point_count = 0;
    let mut corners = Vec::new();
    let mut has_warned = false;
    for (number, line) in Lines::new(bytes) {
        let mut words = words(&line);
        let at = || format!("line {number}");
        match words.next() {
            Some(b"v") => {
                let position = position(words);
                sink.point(position.as_ref().copied().unwrap_or_default());
                point_count += 1;
                if let Err(message) = position {
                    faults.error(at(), message);
                }
            }
            Some(b"f") => {
                corners.clear();
                let mut broken = None;
                for word in words {
                    match corner(word, point_count) {
                        Ok(corner) => corners.push(corner),
                        Err(message) => broken = broken.or(Some(message)),
                    }
                }
                match broken {
                    Some(message) => faults.push(Fault::error(at(), message)),
                    None => sink.face(&corners, number, faults),
                }
            }
            Some(keyword @ (b"o" | b"g")) => {
                let name = line.get(keyword.len()..).unwrap_or_default().trim_ascii();
                let name = String::from_utf8_lossy(name);
                sink.group(if name.is_empty() { DEFAULT_GROUP } else { &name });
            }
            Some(keyword) if !has_warned && UNREAD_GEOMETRY.contains(&keyword) => {
                has_warned = true;
                let message = format!(
                    "{:?} is not read, nor are others of its kind: only points and faces are; export polygons",
                    shown(keyword)
                );
                faults.warn(at(), message);
            }
            _ => {}
        }
    }
}

fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// The first three numbers; a weight or a colour may follow.
fn position<'a>(mut words: impl Iterator<Item = &'a [u8]>) -> Result<[f32; 3], String> {
    let mut out = [0f32; 3];
    for (axis, value) in ["x", "y", "z"].into_iter().zip(&mut out) {
        let word = words
            .next()
            .ok_or_else(|| format!("{axis} of a point is missing; expected three numbers"))?;
        let text = std::str::from_utf8(word).unwrap_or_default();
        *value = text
            .parse()
            .map_err(|_| format!("{axis} is {:?}; expected a number", shown(word)))?;
        if magnitude::flaw(*value).is_some() {
            // Beyond its range f32 has only infinity; f64 shows the number as it stands in the file.
            let flaw = magnitude::flaw(text.parse::<f64>().unwrap_or(f64::NAN));
            return Err(format!("{axis} {}", flaw.unwrap_or_default()));
        }
    }
    Ok(out)
}

/// The point of a corner such as `7`, `-1`, `7/2`, `7//3` or `7/2/3`; the rest of it is not looked at.
fn corner(word: &[u8], point_count: usize) -> Result<u32, String> {
    let index = word.split(|byte| *byte == b'/').next().unwrap_or_default();
    let number: Option<i64> = std::str::from_utf8(index).ok().and_then(|text| text.parse().ok());
    let number = number.ok_or_else(|| format!("corner {:?} names no point; expected a whole number", shown(word)))?;
    let count = i64::try_from(point_count).unwrap_or(i64::MAX);
    let from_zero = if number > 0 {
        number - 1
    } else {
        count.saturating_add(number)
    };
    if number == 0 {
        return Err("a corner names point 0; points count from 1, or back from -1".to_owned());
    }
    if from_zero < 0 {
        return Err(format!(
            "a corner counts back to point {number}, but only {count} points come before"
        ));
    }
    u32::try_from(from_zero).map_err(|_| format!("a corner names point {number}; the limit is {}", u32::MAX))
}

/// A word of the file for a message, cut where it is long.
fn shown(word: &[u8]) -> String {
    const LONGEST: usize = 40;
    match word.get(..LONGEST) {
        Some(start) => String::from_utf8_lossy(start).into_owned() + "…",
        None => String::from_utf8_lossy(word).into_owned(),
    }
}
