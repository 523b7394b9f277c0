use crate::{
    meta::TreeKind,
    meta_codec::MetaFault,
    row_fault::RowFault,
    section::{SECTION_ALIGN, SectionCode, SectionKind},
    version::FormatVersion,
};

/// Why bytes are not a readable file, or a model not a writable one.
///
/// Opening stops at the first fault. The order of checks is: header, section table, section bytes, metadata, rows.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FormatError {
    /// Another kind of file.
    #[error(
        "not a .rpose file: it begins with \"{}\", expected \"{}\"; check the path, or bake the source first",
        found.escape_ascii(),
        crate::header::MAGIC.escape_ascii()
    )]
    NotRestpose {
        /// First bytes, padded with zeros.
        found: [u8; 10],
    },
    /// A `.rpose` file that was sent as text.
    #[error(
        "a .rpose file damaged by a transfer in text mode: it begins with \"{}\", expected \"{}\"; copy it again in \
         binary mode",
        found.escape_ascii(),
        crate::header::MAGIC.escape_ascii()
    )]
    TextModeTransfer {
        /// First bytes, padded with zeros.
        found: [u8; 10],
    },
    /// The end is missing.
    #[error("the {what} is cut short: expected {expected} bytes, found {found}; copy the file again or re-bake it")]
    Truncated {
        /// What ends too early.
        what: &'static str,
        /// Bytes that it should have.
        expected: u64,
        /// Bytes that there are.
        found: u64,
    },
    /// More bytes than the header says.
    #[error(
        "{} bytes follow the end of the file: the header says {expected} bytes, found {found}; copy the file again \
         or re-bake it",
        found.saturating_sub(*expected)
    )]
    TrailingBytes {
        /// Bytes that the header says.
        expected: u64,
        /// Bytes that there are.
        found: u64,
    },
    /// An older or newer format.
    #[error(
        "format version {major}.{minor} cannot be read; this library reads {}; re-bake the source with a matching \
         version of restpose",
        version_list(supported)
    )]
    Version {
        /// Major version of the file.
        major: u16,
        /// Minor version of the file.
        minor: u16,
        /// What can be read.
        supported: &'static [FormatVersion],
    },
    /// A header length that this version does not have.
    #[error("the header says that it is {found} bytes long, expected {expected}; copy the file again or re-bake it")]
    HeaderLength {
        /// Bytes in this version.
        expected: u32,
        /// Bytes that the header says.
        found: u32,
    },
    /// The section table does not fit the file.
    #[error(
        "a section table of {section_count} lines does not fit a file of {file_len} bytes; copy the file again or \
         re-bake it"
    )]
    SectionTableOutOfBounds {
        /// Lines that the header says.
        section_count: u32,
        /// Bytes of the file.
        file_len: u64,
    },
    /// Header or section table were changed.
    #[error(
        "header or section table are damaged: expected checksum {expected:08x}, found {found:08x}; copy the file \
         again or re-bake it"
    )]
    HeaderChecksum {
        /// Checksum that the header says.
        expected: u32,
        /// Checksum of the bytes.
        found: u32,
    },
    /// A reserved header field is in use.
    #[error("header field `{field}` is {found}, expected zero; re-bake the source with a matching version of restpose")]
    HeaderReserved {
        /// Field.
        field: &'static str,
        /// Its value.
        found: u64,
    },
    /// The file needs features that this library lacks.
    #[error(
        "the file needs features that this library does not know (bits {unknown:#x}); update the library or re-bake \
         the source"
    )]
    RequiredFeatures {
        /// Unknown bits of the required features.
        unknown: u64,
    },
    /// An optional-feature bit contradicts the metadata.
    #[error("optional feature bit {bit:#x} is {found}, but the metadata says {expected}; re-bake the source")]
    FeatureMismatch {
        /// The bit.
        bit: u64,
        /// As the metadata has it.
        expected: bool,
        /// As the header has it.
        found: bool,
    },
    /// The buffer does not begin where rows can be read in place.
    #[error(
        "the bytes begin {remainder} bytes past a multiple of {SECTION_ALIGN}; map the file, or copy it into memory \
         aligned to {SECTION_ALIGN} bytes (AlignedBytes)"
    )]
    Misaligned {
        /// Address modulo 64.
        remainder: usize,
    },
    /// A section is absent.
    #[error("section {section} is missing; copy the file again or re-bake it")]
    SectionMissing {
        /// Section.
        section: SectionKind,
    },
    /// A section stands twice or in the wrong place of the order.
    #[error("line {line} of the section table is {section}, which is repeated or out of order; re-bake the source")]
    SectionOrder {
        /// Section.
        section: SectionKind,
        /// Line of the section table, from 0.
        line: usize,
    },
    /// A section that this library does not know and may not skip.
    #[error("section {code} is not known and not marked optional; update the library or re-bake the source")]
    SectionUnknown {
        /// Its code.
        code: SectionCode,
    },
    /// A section's rows have another layout.
    #[error(
        "section {section} has row layout {found}, expected {expected}; re-bake the source with a matching version \
         of restpose"
    )]
    SectionVersion {
        /// Section.
        section: SectionKind,
        /// Layout of this library.
        expected: u16,
        /// Layout of the file.
        found: u16,
    },
    /// A section's flags are unknown, or it is marked optional and is not.
    #[error("section {code} has flags {found:#06x}, which are not allowed for it; re-bake the source")]
    SectionFlags {
        /// Its code.
        code: SectionCode,
        /// Flags of the file.
        found: u16,
    },
    /// A section's rows have another size.
    #[error("section {section} has rows of {found} bytes, expected {expected}; re-bake the source")]
    RowSize {
        /// Section.
        section: SectionKind,
        /// Bytes of a row in this library.
        expected: u32,
        /// Bytes of a row in the file.
        found: u32,
    },
    /// A section's length is not its row size times its row count.
    #[error(
        "section {code} says {byte_len} bytes for {row_count} rows of {row_size} bytes; copy the file again or \
         re-bake it"
    )]
    SectionLength {
        /// Its code.
        code: SectionCode,
        /// Bytes of a row.
        row_size: u32,
        /// Rows.
        row_count: u64,
        /// Bytes that the section says.
        byte_len: u64,
    },
    /// A section does not begin on the first boundary after what precedes it.
    #[error("section {code} begins at byte {found}, expected {expected}; copy the file again or re-bake it")]
    SectionOffset {
        /// Its code.
        code: SectionCode,
        /// Where it must begin.
        expected: u64,
        /// Where the table says that it begins.
        found: u64,
    },
    /// A section reaches past the end of the file.
    #[error(
        "section {code} of {byte_len} bytes at byte {offset} does not fit a file of {file_len} bytes; copy the file \
         again or re-bake it"
    )]
    SectionOutOfBounds {
        /// Its code.
        code: SectionCode,
        /// First byte.
        offset: u64,
        /// Bytes.
        byte_len: u64,
        /// Bytes of the file.
        file_len: u64,
    },
    /// The file goes on after the last section.
    #[error("the sections end at byte {expected}, but the file has {found} bytes; copy the file again or re-bake it")]
    BytesAfterSections {
        /// End of the last section.
        expected: u64,
        /// Bytes of the file.
        found: u64,
    },
    /// A byte between sections is in use.
    #[error(
        "byte {offset} lies between sections and is {found:#04x}, expected zero; copy the file again or re-bake it"
    )]
    GapNotZero {
        /// Byte, from the start of the file.
        offset: u64,
        /// Its value.
        found: u8,
    },
    /// A section's bytes were changed.
    #[error(
        "section {code} is damaged: expected checksum {expected:08x}, found {found:08x}; copy the file again or \
         re-bake it"
    )]
    SectionChecksum {
        /// Its code.
        code: SectionCode,
        /// Checksum that the table says.
        expected: u32,
        /// Checksum of the bytes.
        found: u32,
    },
    /// The metadata cannot be decoded or encoded.
    #[error("section META: {fault}; re-bake the source with a matching version of restpose")]
    Meta {
        /// Why.
        fault: MetaFault,
    },
    /// A list in the metadata does not have one entry per row.
    #[error("metadata list `{list}` has {found} entries, expected one per row of {section}, {expected}; {RE_BAKE}")]
    MetaListLength {
        /// List.
        list: &'static str,
        /// Section whose rows it names.
        section: SectionKind,
        /// Rows.
        expected: usize,
        /// Entries.
        found: usize,
    },
    /// The metadata miscounts the degenerate triangles.
    #[error("the metadata counts {found} degenerate triangles, expected {expected} as in TRIS; {RE_BAKE}")]
    DegenerateTriangleCount {
        /// Triangles with three equal corners.
        expected: u64,
        /// Count in the metadata.
        found: u64,
    },
    /// Nothing to trace.
    #[error("section TRIS is empty, expected at least one triangle; bake a source that has triangles")]
    NoTriangles,
    /// A section has not as many rows as the sections that refer to it account for.
    #[error("section {section} has {found} rows, expected {expected} as the sections that refer to it say; {RE_BAKE}")]
    RowCount {
        /// Section.
        section: SectionKind,
        /// Rows accounted for.
        expected: u64,
        /// Rows.
        found: u64,
    },
    /// A section that describes envelopes has rows, and the boxes bound samples only.
    #[error(
        "section {section} has {found} rows, expected none, for the metadata says that bounds are sampled; {RE_BAKE}"
    )]
    RowsOfSampledBounds {
        /// Section.
        section: SectionKind,
        /// Rows.
        found: u64,
    },
    /// Rows of one kind of trees in a file of another.
    #[error(
        "section {section} has {found} rows, expected none, for the metadata says that trees are {}; {RE_BAKE}",
        tree.name()
    )]
    RowsOfOtherTrees {
        /// Section.
        section: SectionKind,
        /// Rows.
        found: u64,
        /// The file's kind of trees.
        tree: TreeKind,
    },
    /// A row breaks a rule.
    #[error("section {section}, row {row}: {fault}; {RE_BAKE}")]
    Row {
        /// Section.
        section: SectionKind,
        /// Row, from 0.
        row: u64,
        /// Rule that is broken.
        fault: RowFault,
    },
}

/// The checksums hold, so the writer is at fault and not the transport.
const RE_BAKE: &str = "the program that wrote it is at fault: re-bake the source";

fn version_list(versions: &[FormatVersion]) -> String {
    versions.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

impl From<MetaFault> for FormatError {
    fn from(fault: MetaFault) -> Self {
        Self::Meta { fault }
    }
}
