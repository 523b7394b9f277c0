use restpose_bake::import::FrameRange;

/// A range of frames, written `FIRST-[LAST][/STEP]`. Whether the source has these frames is seen when it is read.
pub fn frame_range(text: &str) -> Result<FrameRange, String> {
    parse(text).ok_or_else(|| {
        "expected FIRST-[LAST][/STEP], such as 10-50, 10-50/2 or 10-, with FIRST at most LAST and STEP at least 1"
            .to_owned()
    })
}

fn parse(text: &str) -> Option<FrameRange> {
    let (range, step) = text.split_once('/').unwrap_or((text, "1"));
    let (first, last) = range.split_once('-')?;
    let last = if last.is_empty() { None } else { Some(number(last)?) };
    let range = FrameRange {
        first: number(first)?,
        last,
        step: number(step)?,
    };
    (range.step > 0 && last.is_none_or(|last| range.first <= last)).then_some(range)
}

/// Digits only: `parse` alone takes a sign, too.
fn number(text: &str) -> Option<usize> {
    text.bytes()
        .all(|byte| byte.is_ascii_digit())
        .then(|| text.parse().ok())?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_have_a_first_frame_and_may_have_a_last_one_and_a_step() {
        let range = |first, last, step| Ok(FrameRange { first, last, step });
        assert_eq!(frame_range("10-50"), range(10, Some(50), 1));
        assert_eq!(frame_range("0-0/3"), range(0, Some(0), 3));
        assert_eq!(frame_range("7-"), range(7, None, 1));
        assert_eq!(frame_range("7-/2"), range(7, None, 2));
    }

    #[test]
    fn anything_else_is_refused() {
        for wrong in [
            "",
            "-",
            "7",
            "-7",
            "7/2",
            "50-10",
            "1-5/0",
            "1-5/",
            "1-5/x",
            "1-5-9",
            "1-5/2/2",
            "+1-5",
            "1-+5",
            "1.0-5",
            "1 - 5",
            "99999999999999999999-",
        ] {
            assert!(frame_range(wrong).is_err(), "{wrong:?}");
        }
    }
}
