/// A URI, as far as glTF files use them.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Uri<'a> {
    /// Data in the URI itself.
    Data {
        /// The payload is base64, else percent-encoded.
        base64: bool,
        /// What stands behind the comma.
        payload: &'a str,
    },
    /// A path from the file's folder, percent-decoded.
    Relative(String),
}

/// Takes a URI apart.
///
/// # Errors
/// A sentence: the URI has a scheme, is absolute, or does not decode.
pub(super) fn parse(text: &str) -> Result<Uri<'_>, String> {
    if let Some((scheme, rest)) = text.split_once(':').filter(|(scheme, _)| is_scheme(scheme)) {
        if !scheme.eq_ignore_ascii_case("data") {
            return Err(format!(
                "the URI has the scheme {scheme:?}; only data URIs and paths relative to the file are read"
            ));
        }
        let (head, payload) = rest
            .split_once(',')
            .ok_or("the data URI has no comma, behind which its data would stand")?;
        let base64 = head
            .rsplit(';')
            .next()
            .is_some_and(|last| last.trim().eq_ignore_ascii_case("base64"));
        return Ok(Uri::Data { base64, payload });
    }
    let path = String::from_utf8(percent_decoded(text)).map_err(|_| "the URI does not decode to UTF-8".to_owned())?;
    if path.is_empty() {
        return Err("the URI is empty".into());
    }
    if path.contains('\0') {
        return Err("the URI contains a zero byte".into());
    }
    let has_drive = path.split_once(':').is_some_and(|(drive, _)| drive.len() == 1);
    if path.starts_with(['/', '\\']) || has_drive {
        return Err(format!(
            "the URI is absolute ({path:?}); only paths relative to the file are read"
        ));
    }
    Ok(Uri::Relative(path))
}

/// Replaces `%XX` by the byte it stands for. A `%` without two hexadecimal digits stands for itself: exporters forget
/// to encode it.
pub(super) fn percent_decoded(text: &str) -> Vec<u8> {
    let bytes = text.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut rest = bytes;
    while let Some((&first, tail)) = rest.split_first() {
        match (first, tail) {
            (b'%', [high, low, behind @ ..]) if high.is_ascii_hexdigit() && low.is_ascii_hexdigit() => {
                out.push(nibble(*high) << 4 | nibble(*low));
                rest = behind;
            }
            _ => {
                out.push(first);
                rest = tail;
            }
        }
    }
    out
}

fn nibble(digit: u8) -> u8 {
    match digit {
        b'0'..=b'9' => digit - b'0',
        _ => (digit | 0x20) - b'a' + 10,
    }
}

/// RFC 3986 §3.1.
fn is_scheme(text: &str) -> bool {
    text.starts_with(|first: char| first.is_ascii_alphabetic())
        && text
            .bytes()
            .all(|byte| byte.is_ascii_alphanumeric() || b"+-.".contains(&byte))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relative_paths_are_percent_decoded() {
        assert_eq!(parse("a%20b/c%C3%A4.bin"), Ok(Uri::Relative("a b/cä.bin".into())));
        assert_eq!(parse("../100%.bin"), Ok(Uri::Relative("../100%.bin".into())));
    }

    #[test]
    fn absolute_paths_and_schemes_are_refused() {
        for text in [
            "/etc/x",
            "\\\\server\\x",
            "C:\\x",
            "%2Fetc/x",
            "%43:/x",
            "file:///x",
            "https://x/y",
            "",
            "a%00b",
            "%FF",
        ] {
            assert!(parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn data_uris_are_split() {
        assert_eq!(
            parse("data:a/b;base64,QUI="),
            Ok(Uri::Data {
                base64: true,
                payload: "QUI="
            })
        );
        assert_eq!(
            parse("DATA:,x%41"),
            Ok(Uri::Data {
                base64: false,
                payload: "x%41"
            })
        );
        assert!(parse("data:a/b;base64").is_err());
    }
}
