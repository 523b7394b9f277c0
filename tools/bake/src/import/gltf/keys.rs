use crate::import::{Fault, fault_list::FaultList};

/// Keys whose times increase strictly.
#[derive(Debug, PartialEq)]
pub(super) struct Keys {
    pub times: Vec<f32>,
    pub values: Vec<f32>,
}

/// Resolves keys at equal times; `width` values belong to each key.
///
/// Exporters write a jump as two keys at one time. Of such keys the first says where the motion before the jump ends,
/// the last where it goes on; so the first is moved to the next smaller time that `f32` has, the last stays, and those
/// in between go. Where no such time is free, and at the beginning, where nothing comes before, only the last stays.
///
/// # Errors
/// A fault at `at`: times decrease.
pub(super) fn clean(
    times: Vec<f32>,
    values: Vec<f32>,
    width: usize,
    at: &str,
    faults: &mut FaultList,
) -> Result<Keys, Fault> {
    if let Some((key, pair)) = times.windows(2).enumerate().find(|(_, pair)| pair[1] < pair[0]) {
        let message = format!(
            "key {} is at {} s, after key {key} at {} s; expected increasing times, export the animation again",
            key + 1,
            pair[1],
            pair[0]
        );
        return Err(Fault::error(at, message));
    }
    if let Some(first) = times.first().filter(|first| **first < 0.0) {
        faults.warn(at, format!("the first key is at {first} s; expected none before zero"));
    }
    if times.windows(2).all(|pair| pair[0] < pair[1]) {
        return Ok(Keys { times, values });
    }
    let mut out = Keys {
        times: Vec::new(),
        values: Vec::new(),
    };
    let mut first = 0;
    for run in times.chunk_by(|a, b| a == b) {
        let (time, last) = (run[0], first + run.len() - 1);
        let before = time.next_down();
        if run.len() > 1 && out.times.last().is_some_and(|previous| *previous < before) {
            out.push(before, values.get(first * width..(first + 1) * width));
        }
        out.push(time, values.get(last * width..(last + 1) * width));
        first += run.len();
    }
    let gone = times.len() - out.times.len();
    faults.warn(
        at,
        format!("several keys are at one time; they are taken as jumps, and {gone} keys are dropped"),
    );
    Ok(out)
}

impl Keys {
    fn push(&mut self, time: f32, values: Option<&[f32]>) {
        if let Some(values) = values {
            self.times.push(time);
            self.values.extend_from_slice(values);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cleaned(times: &[f32]) -> (Keys, usize) {
        let mut faults = FaultList::default();
        let values = (0..2 * times.len()).map(|value| value as f32).collect();
        let keys = clean(times.to_vec(), values, 2, "", &mut faults).unwrap();
        (keys, faults.into_faults().len())
    }

    #[test]
    fn increasing_times_stay() {
        let (keys, warnings) = cleaned(&[0.0, 1.0, 2.0]);
        assert_eq!(
            (keys.times, keys.values, warnings),
            (vec![0.0, 1.0, 2.0], vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0], 0)
        );
    }

    #[test]
    fn a_jump_keeps_both_sides() {
        let (keys, warnings) = cleaned(&[0.0, 1.0, 1.0, 1.0, 2.0]);
        assert_eq!(keys.times, [0.0, 1.0f32.next_down(), 1.0, 2.0]);
        assert_eq!(keys.values, [0.0, 1.0, 2.0, 3.0, 6.0, 7.0, 8.0, 9.0]);
        assert_eq!(warnings, 1);
    }

    #[test]
    fn at_the_beginning_and_without_room_only_the_last_stays() {
        assert_eq!(cleaned(&[0.0, 0.0, 1.0]).0.times, [0.0, 1.0]);
        assert_eq!(cleaned(&[0.0, 0.0, 1.0]).0.values[0], 2.0);
        let tight = [1.0f32.next_down(), 1.0, 1.0];
        assert_eq!(cleaned(&tight).0.times, tight[..2]);
    }

    #[test]
    fn decreasing_times_are_refused() {
        assert!(clean(vec![0.0, 2.0, 1.0], vec![0.0; 3], 1, "", &mut FaultList::default()).is_err());
    }
}
