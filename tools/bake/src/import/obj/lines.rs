use std::borrow::Cow;

/// Lines of an OBJ file with their numbers, counted from 1: without comments and white space around them, those that a
/// `\` continues joined under the first one's number.
///
/// A comment reaches from a `#` at the beginning or behind white space to the end of its line. A `\` at the end of a
/// comment continues nothing: exporters write Windows paths there.
#[derive(Debug)]
pub(super) struct Lines<'a> {
    rest: Option<&'a [u8]>,
    number: usize,
}

impl<'a> Lines<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self {
            rest: Some(bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes)),
            number: 0,
        }
    }

    fn physical(&mut self) -> Option<&'a [u8]> {
        let rest = self.rest?;
        self.number += 1;
        let mut split = rest.splitn(2, |byte| *byte == b'\n');
        let line = split.next().unwrap_or_default();
        self.rest = split.next();
        Some(without_comment(line).trim_ascii())
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (usize, Cow<'a, [u8]>);

    fn next(&mut self) -> Option<Self::Item> {
        let mut line = self.physical()?;
        let number = self.number;
        if !line.ends_with(b"\\") {
            return Some((number, Cow::Borrowed(line)));
        }
        let mut joined = Vec::new();
        while let Some(start) = line.strip_suffix(b"\\") {
            joined.extend_from_slice(start);
            joined.push(b' ');
            line = self.physical().unwrap_or_default();
        }
        joined.extend_from_slice(line);
        Some((number, Cow::Owned(joined)))
    }
}

fn without_comment(line: &[u8]) -> &[u8] {
    let mut previous = b' ';
    let is_start = |byte: &u8| {
        let before = std::mem::replace(&mut previous, *byte);
        *byte == b'#' && before.is_ascii_whitespace()
    };
    let end = line.iter().position(is_start).unwrap_or(line.len());
    line.get(..end).unwrap_or(line)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str) -> Vec<(usize, String)> {
        Lines::new(text.as_bytes())
            .map(|(number, line)| (number, String::from_utf8(line.into_owned()).unwrap()))
            .filter(|(_, line)| !line.is_empty())
            .collect()
    }

    fn expected(list: &[(usize, &str)]) -> Vec<(usize, String)> {
        list.iter()
            .map(|(number, line)| (*number, (*line).to_owned()))
            .collect()
    }

    #[test]
    fn any_line_end_and_none_at_the_end() {
        assert_eq!(
            lines("a\r\nb\n\n \t c \nd"),
            expected(&[(1, "a"), (2, "b"), (4, "c"), (5, "d")])
        );
        assert_eq!(lines(""), []);
        assert_eq!(lines("\u{FEFF}a"), expected(&[(1, "a")]));
    }

    #[test]
    fn comments_go_but_not_inside_words() {
        assert_eq!(lines("# x\na #b\nc#d\n\t#\n"), expected(&[(2, "a"), (3, "c#d")]));
    }

    #[test]
    fn continued_lines_are_joined_under_the_first_number() {
        assert_eq!(lines("a \\\r\nb\\ \nc\nd"), expected(&[(1, "a  b c"), (4, "d")]));
        assert_eq!(lines("a\\"), expected(&[(1, "a ")]));
        assert_eq!(lines("a \\ # why\nb"), expected(&[(1, "a  b")]));
    }

    #[test]
    fn a_comment_continues_nothing() {
        assert_eq!(lines("# C:\\models\\\nv"), expected(&[(2, "v")]));
        assert_eq!(lines("a # C:\\\nv"), expected(&[(1, "a"), (2, "v")]));
    }
}
