use crate::import::{Fault, fault_list::FaultList};

const MAGIC: &[u8] = b"glTF";
const HEADER_LEN: usize = 12;
const CHUNK_HEADER_LEN: usize = 8;
const CHUNK_JSON: u32 = 0x4E4F_534A;
const CHUNK_BIN: u32 = 0x004E_4942;
const UTF8_BOM: &[u8] = b"\xEF\xBB\xBF";

/// The two things that a glTF file can hold.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Container<'a> {
    /// JSON text, without byte-order mark and padding.
    pub json: &'a [u8],
    /// Contents of the binary chunk.
    pub bin: Option<&'a [u8]>,
}

/// Why bytes are not a glTF container.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum ContainerError {
    /// It is something else, described.
    Foreign(String),
    /// It is a binary glTF file with this fault.
    Broken(Fault),
}

/// Splits a file into JSON and binary chunk, by content: the file's extension is not asked.
///
/// Source: glTF 2.0 §4.4. Differs: chunk lengths need not be multiples of four, padding of the JSON chunk may also be
/// zeros, and bytes behind the declared length are ignored with a warning.
pub(super) fn split<'a>(bytes: &'a [u8], faults: &mut FaultList) -> Result<Container<'a>, ContainerError> {
    if bytes.starts_with(MAGIC) {
        return split_binary(bytes, faults);
    }
    let text = bytes.strip_prefix(UTF8_BOM).unwrap_or(bytes);
    match text.iter().find(|byte| !byte.is_ascii_whitespace()) {
        Some(b'{') => Ok(Container {
            json: trim(text),
            bin: None,
        }),
        None if bytes.is_empty() => Err(ContainerError::Foreign("the file is empty".into())),
        _ => Err(ContainerError::Foreign(
            "the file is neither binary glTF nor a JSON object".into(),
        )),
    }
}

fn split_binary<'a>(bytes: &'a [u8], faults: &mut FaultList) -> Result<Container<'a>, ContainerError> {
    let broken = |message: String| ContainerError::Broken(Fault::error("", message));
    let (Some(version), Some(declared)) = (word(bytes, 4), word(bytes, 8)) else {
        return Err(broken(format!(
            "truncated: the header has {HEADER_LEN} bytes, the file {}",
            bytes.len()
        )));
    };
    if version != 2 {
        return Err(ContainerError::Foreign(format!(
            "the file is binary glTF version {version}"
        )));
    }
    let declared = declared as usize;
    let Some(body) = bytes.get(..declared) else {
        return Err(broken(format!(
            "truncated: the header declares {declared} bytes, the file has {}; copy or export it again",
            bytes.len()
        )));
    };
    if bytes.len() > declared {
        let extra = bytes.len() - declared;
        faults.warn(
            "",
            format!("{extra} bytes behind the declared length of {declared} are ignored"),
        );
    }
    let (mut json, mut bin) = (None, None);
    let mut at = HEADER_LEN;
    for number in 0u32.. {
        if body.len() <= at {
            break;
        }
        let (Some(length), Some(kind)) = (word(body, at), word(body, at + 4)) else {
            return Err(broken(format!(
                "chunk {number} at byte {at}: its header passes the end of the file"
            )));
        };
        let start = at + CHUNK_HEADER_LEN;
        let Some(chunk) = start.checked_add(length as usize).and_then(|end| body.get(start..end)) else {
            return Err(broken(format!(
                "chunk {number} at byte {at}: declares {length} bytes, {} are left",
                body.len() - start
            )));
        };
        match (number, kind) {
            (0, CHUNK_JSON) => json = Some(trim(chunk.strip_prefix(UTF8_BOM).unwrap_or(chunk))),
            (0, _) => {
                return Err(broken(format!(
                    "the first chunk is of kind {kind:#010x}, expected JSON"
                )));
            }
            (1, CHUNK_BIN) => bin = Some(chunk),
            // Later chunks belong to extensions; clients must ignore what they do not know (§4.4.3.1).
            _ => {}
        }
        at = start + chunk.len();
    }
    let json = json.ok_or_else(|| broken("the file has no JSON chunk".into()))?;
    Ok(Container { json, bin })
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    let four = bytes.get(at..at.checked_add(4)?)?;
    Some(u32::from_le_bytes(four.try_into().ok()?))
}

fn trim(text: &[u8]) -> &[u8] {
    let end = text
        .iter()
        .rposition(|byte| !byte.is_ascii_whitespace() && *byte != 0)
        .map_or(0, |last| last + 1);
    text.get(..end).unwrap_or(text)
}
