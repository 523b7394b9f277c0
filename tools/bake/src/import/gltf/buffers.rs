use super::{document::Document, uri};
use crate::import::{Fault, fault_list::FaultList};
use base64::{
    Engine,
    alphabet::STANDARD,
    engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig},
};
use std::{borrow::Cow, collections::BTreeMap, io};

/// Exporters disagree about the `=` at the end.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

const NO_DATA: &str = "the buffer has no data (no uri, and it is not the binary chunk of a .glb), but is read from; \
    if a compression extension should fill it, convert the file first, without compression";

/// The contents of all buffers.
#[derive(Debug)]
pub(super) struct Buffers<'a> {
    /// Distinct sources, in order of first use.
    sources: Vec<Cow<'a, [u8]>>,
    /// Per buffer: its source and how many of its bytes count, or why it cannot be read.
    buffers: Vec<Result<(usize, usize), Fault>>,
    /// Bytes of all sources that are not in the file itself.
    external_bytes: usize,
}

impl<'a> Buffers<'a> {
    /// Loads every buffer. `hash` is fed the length and the bytes of each file beside the source, in order of first use.
    pub fn load(
        document: &Document,
        bin: Option<&'a [u8]>,
        load_buffer: &dyn Fn(&str) -> io::Result<Vec<u8>>,
        hash: &mut blake3::Hasher,
        faults: &mut FaultList,
    ) -> Self {
        let mut out = Self {
            sources: Vec::new(),
            buffers: Vec::new(),
            external_bytes: 0,
        };
        let mut files: BTreeMap<String, usize> = BTreeMap::new();
        for (number, buffer) in document.buffers.iter().enumerate() {
            let at = format!("/buffers/{number}");
            let wanted = buffer.byte_length.0;
            let loaded = match (&buffer.uri, bin) {
                (None, Some(bin)) if number == 0 => Ok(out.add(Cow::Borrowed(bin))),
                // A placeholder that an extension fills: a fault only when it is read from.
                (None, _) => {
                    out.buffers.push(Err(Fault::error(at, NO_DATA)));
                    continue;
                }
                (Some(text), _) => match uri::parse(text) {
                    Ok(uri::Uri::Data { base64, payload }) => {
                        decode_data(base64, payload).map(|bytes| out.add(Cow::Owned(bytes)))
                    }
                    Ok(uri::Uri::Relative(path)) => match files.get(&path) {
                        Some(&known) => Ok(known),
                        None => match load_buffer(&path) {
                            Ok(bytes) => {
                                hash.update(&(bytes.len() as u64).to_le_bytes());
                                hash.update(&bytes);
                                out.external_bytes = out.external_bytes.saturating_add(bytes.len());
                                let source = out.add(Cow::Owned(bytes));
                                files.insert(path, source);
                                Ok(source)
                            }
                            Err(error) => Err(format!("cannot read {path:?}: {error}")),
                        },
                    },
                    Err(message) => Err(message),
                },
            };
            let found = |source: usize| out.sources.get(source).map_or(0, |bytes| bytes.len());
            let result = match loaded {
                Ok(source) if found(source) >= wanted => Ok((source, wanted)),
                Ok(source) => Err(Fault::error(
                    format!("{at}/byteLength"),
                    format!(
                        "the buffer should have {wanted} bytes, its data has {}; it is cut short or not this file's",
                        found(source)
                    ),
                )),
                Err(message) => Err(Fault::error(format!("{at}/uri"), message)),
            };
            if let Err(fault) = &result {
                faults.push(fault.clone());
            }
            out.buffers.push(result);
        }
        out
    }

    fn add(&mut self, source: Cow<'a, [u8]>) -> usize {
        self.sources.push(source);
        self.sources.len() - 1
    }

    /// A buffer's bytes, `byteLength` of them.
    ///
    /// # Errors
    /// A fault at the buffer: it has no data, or does not exist.
    pub fn get(&self, number: usize) -> Result<&[u8], Fault> {
        match self.buffers.get(number) {
            Some(Ok((source, length))) => self
                .sources
                .get(*source)
                .and_then(|bytes| bytes.get(..*length))
                .ok_or_else(|| Fault::error(format!("/buffers/{number}"), NO_DATA)),
            Some(Err(fault)) => Err(fault.clone()),
            None => Err(Fault::error(
                format!("/buffers/{number}"),
                format!("does not exist; the file has {} buffers", self.buffers.len()),
            )),
        }
    }

    /// Bytes loaded from files beside the source.
    pub fn external_bytes(&self) -> usize {
        self.external_bytes
    }
}

fn decode_data(base64: bool, payload: &str) -> Result<Vec<u8>, String> {
    if !base64 {
        return Ok(uri::percent_decoded(payload));
    }
    let plain: Cow<[u8]> = if payload.bytes().any(|byte| byte == b'%' || byte.is_ascii_whitespace()) {
        Cow::Owned(
            uri::percent_decoded(payload)
                .into_iter()
                .filter(|byte| !byte.is_ascii_whitespace())
                .collect(),
        )
    } else {
        Cow::Borrowed(payload.as_bytes())
    };
    BASE64
        .decode(plain)
        .map_err(|error| format!("the data URI is not base64: {error}"))
}
