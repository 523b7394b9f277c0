use super::{buffers::Buffers, document::Document, schema};
use crate::import::{Fault, magnitude::flaw};
use std::cell::Cell;

/// Decoding may take this many bytes for each byte of the source files. Primitives often share one long vertex list,
/// of which each keeps a copy; a hostile file could do so without end.
const DECODED_BYTES_PER_SOURCE_BYTE: u64 = 1024;

/// Decoding may always take this many bytes: an accessor without data stands for zeros, which the file does not hold.
const DECODED_BYTES_ALWAYS: u64 = 64 << 20;

/// How an accessor's components are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn from_number(number: usize) -> Option<Self> {
        Some(match number {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn byte_len(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::I8 => "BYTE",
            Self::U8 => "UNSIGNED_BYTE",
            Self::I16 => "SHORT",
            Self::U16 => "UNSIGNED_SHORT",
            Self::U32 => "UNSIGNED_INT",
            Self::F32 => "FLOAT",
        }
    }

    /// Source: glTF 2.0 §3.11 for normalised integers.
    fn float(self, normalized: bool, bytes: &[u8]) -> f32 {
        match (self, bytes) {
            (Self::I8, &[a]) if normalized => (f32::from(a as i8) / 127.0).max(-1.0),
            (Self::I8, &[a]) => f32::from(a as i8),
            (Self::U8, &[a]) if normalized => f32::from(a) / 255.0,
            (Self::U8, &[a]) => f32::from(a),
            (Self::I16, &[a, b]) if normalized => (f32::from(i16::from_le_bytes([a, b])) / 32767.0).max(-1.0),
            (Self::I16, &[a, b]) => f32::from(i16::from_le_bytes([a, b])),
            (Self::U16, &[a, b]) if normalized => f32::from(u16::from_le_bytes([a, b])) / 65535.0,
            (Self::U16, &[a, b]) => f32::from(u16::from_le_bytes([a, b])),
            (Self::F32, &[a, b, c, d]) => f32::from_le_bytes([a, b, c, d]),
            _ => f32::NAN,
        }
    }

    fn whole(self, bytes: &[u8]) -> u32 {
        match (self, bytes) {
            (Self::U8, &[a]) => u32::from(a),
            (Self::U16, &[a, b]) => u32::from(u16::from_le_bytes([a, b])),
            (Self::U32, &[a, b, c, d]) => u32::from_le_bytes([a, b, c, d]),
            _ => u32::MAX,
        }
    }
}

/// What a property takes from an accessor of numbers.
#[derive(Clone, Copy, Debug)]
pub(super) enum Numbers {
    /// FLOAT only.
    Float,
    /// FLOAT, or 8- and 16-bit integers, which are normalised whether or not they say so.
    Normalized,
    /// FLOAT, or 8- and 16-bit integers, normalised or not (KHR_mesh_quantization).
    Quantized,
}

/// Decodes accessors. Every length is checked before memory is taken.
#[derive(Debug)]
pub(super) struct Accessors<'a> {
    accessors: &'a [schema::Accessor],
    views: &'a [schema::BufferView],
    buffers: &'a Buffers<'a>,
    /// Bytes that decoding may still take.
    budget: Cell<u64>,
}

impl<'a> Accessors<'a> {
    /// For the accessors of one file of `source_bytes` bytes, buffers included.
    pub fn new(document: &'a Document, buffers: &'a Buffers<'a>, source_bytes: usize) -> Self {
        let budget = (source_bytes as u64).saturating_mul(DECODED_BYTES_PER_SOURCE_BYTE);
        Self {
            accessors: &document.accessors,
            views: &document.buffer_views,
            buffers,
            budget: Cell::new(budget.saturating_add(DECODED_BYTES_ALWAYS)),
        }
    }

    /// The accessor that the property at `at` refers to.
    ///
    /// # Errors
    /// A fault at `at`: there is none.
    pub fn get(&self, number: schema::Whole, at: &str) -> Result<&'a schema::Accessor, Fault> {
        self.accessors.get(number.0).ok_or_else(|| {
            let message = format!(
                "accessor {} does not exist; the file has {}",
                number.0,
                self.accessors.len()
            );
            Fault::error(at, message)
        })
    }

    /// Component type of the accessor that the property at `at` refers to.
    ///
    /// # Errors
    /// A fault: no such accessor, or no such type.
    pub fn component(&self, number: schema::Whole, at: &str) -> Result<Component, Fault> {
        component(
            self.get(number, at)?.component_type,
            &format!("/accessors/{}", number.0),
        )
    }

    /// Numbers, `N` per element, finite and at most [`MAX_MAGNITUDE`](crate::import::MAX_MAGNITUDE).
    ///
    /// # Errors
    /// A fault at `at` where the accessor or its contents do not suit the property, at the accessor where it is itself
    /// broken.
    pub fn floats<const N: usize>(
        &self,
        number: schema::Whole,
        numbers: Numbers,
        at: &str,
    ) -> Result<Vec<[f32; N]>, Fault> {
        use Component::{F32, I8, I16, U8, U16};
        let accessor = self.get(number, at)?;
        let allowed: &[Component] = match numbers {
            Numbers::Float => &[F32],
            Numbers::Normalized | Numbers::Quantized => &[F32, I8, U8, I16, U16],
        };
        let normalized = accessor.normalized || matches!(numbers, Numbers::Normalized);
        let out: Vec<[f32; N]> = self.elements(number, allowed, at, |component, bytes| {
            component.float(normalized, bytes)
        })?;
        for (index, element) in out.iter().enumerate() {
            if let Some(flaw) = element.iter().find_map(|value| flaw(f64::from(*value))) {
                return Err(Fault::error(
                    at,
                    format!("element {index} of accessor {} {flaw}", number.0),
                ));
            }
        }
        Ok(out)
    }

    /// Unsigned integers, `N` per element.
    ///
    /// # Errors
    /// As [`Accessors::floats`].
    pub fn wholes<const N: usize>(&self, number: schema::Whole, at: &str) -> Result<Vec<[u32; N]>, Fault> {
        use Component::{U8, U16, U32};
        self.elements(number, &[U8, U16, U32], at, Component::whole)
    }

    /// Takes `count · size` bytes from what decoding may still take, before they are allocated.
    ///
    /// # Errors
    /// A fault at `at`: so much is not left.
    pub fn charge(&self, count: usize, size: usize, at: &str) -> Result<(), Fault> {
        let bytes = (count as u64).saturating_mul(size as u64);
        let left = self.budget.get().checked_sub(bytes).ok_or_else(|| {
            Fault::error(
                at,
                format!(
                    "{count} elements more would exceed the memory limit of {} MiB plus {DECODED_BYTES_PER_SOURCE_BYTE} \
                     bytes per byte of source; give each primitive its own, shorter vertex list",
                    DECODED_BYTES_ALWAYS >> 20
                ),
            )
        })?;
        self.budget.set(left);
        Ok(())
    }

    fn elements<T: Copy + Default, const N: usize>(
        &self,
        number: schema::Whole,
        allowed: &[Component],
        at: &str,
        decode: impl Fn(Component, &[u8]) -> T,
    ) -> Result<Vec<[T; N]>, Fault> {
        let accessor = self.get(number, at)?;
        let path = format!("/accessors/{}", number.0);
        let component = component(accessor.component_type, &path)?;
        if !allowed.contains(&component) {
            let names: Vec<_> = allowed.iter().map(|component| component.name()).collect();
            let (found, expected) = (component.name(), names.join(", "));
            return Err(Fault::error(
                at,
                format!("accessor {} has {found} components; expected {expected}", number.0),
            ));
        }
        if accessor.shape != shape_name(N) {
            let (found, expected) = (&accessor.shape, shape_name(N));
            return Err(Fault::error(
                at,
                format!("accessor {} is a {found}; expected {expected}", number.0),
            ));
        }
        let width = component.byte_len();
        let count = accessor.count.0;
        let size = N.saturating_mul(width);
        let base = match accessor.buffer_view {
            Some(view) => {
                let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
                Some(self.strided(view, offset, count, size, true, &path)?)
            }
            None => None,
        };
        self.charge(count, N.saturating_mul(4), &path)?;
        let mut out = vec![[T::default(); N]; count];
        let read = |bytes: &[u8], out: &mut [T; N]| {
            for (value, bytes) in out.iter_mut().zip(bytes.chunks_exact(width)) {
                *value = decode(component, bytes);
            }
        };
        if let Some(base) = base {
            for (bytes, out) in base.zip(&mut out) {
                read(bytes, out);
            }
        }
        if let Some(sparse) = &accessor.sparse {
            self.overlay(sparse, &path, size, &mut out, read)?;
        }
        Ok(out)
    }

    /// Replaces the elements that a sparse accessor lists. Source: glTF 2.0 §3.6.2.3.
    fn overlay<E>(
        &self,
        sparse: &schema::Sparse,
        accessor: &str,
        size: usize,
        out: &mut [E],
        read: impl Fn(&[u8], &mut E),
    ) -> Result<(), Fault> {
        let (count, length) = (sparse.count.0, out.len());
        let path = format!("{accessor}/sparse/indices");
        let kind = component(sparse.indices.component_type, &path)?;
        if !matches!(kind, Component::U8 | Component::U16 | Component::U32) {
            return Err(Fault::error(
                format!("{path}/componentType"),
                format!("is {}; expected an unsigned integer", kind.name()),
            ));
        }
        let offset = sparse.indices.byte_offset.map_or(0, |offset| offset.0);
        let indices = self.strided(sparse.indices.buffer_view, offset, count, kind.byte_len(), false, &path)?;
        let values_path = format!("{accessor}/sparse/values");
        let offset = sparse.values.byte_offset.map_or(0, |offset| offset.0);
        let values = self.strided(sparse.values.buffer_view, offset, count, size, false, &values_path)?;
        for (place, (index, value)) in indices.zip(values).enumerate() {
            let index = kind.whole(index);
            let Some(element) = out.get_mut(index as usize) else {
                return Err(Fault::error(
                    path.as_str(),
                    format!("index {place} is {index}; the accessor has {length} elements"),
                ));
            };
            read(value, element);
        }
        Ok(())
    }

    /// `count` elements of `size` bytes, each as a slice.
    fn strided(
        &self,
        view: schema::Whole,
        offset: usize,
        count: usize,
        size: usize,
        may_stride: bool,
        at: &str,
    ) -> Result<impl Iterator<Item = &[u8]>, Fault> {
        let path = format!("/bufferViews/{}", view.0);
        let Some(row) = self.views.get(view.0) else {
            let message = format!(
                "buffer view {} does not exist; the file has {}",
                view.0,
                self.views.len()
            );
            return Err(Fault::error(format!("{at}/bufferView"), message));
        };
        let buffer = self.buffers.get(row.buffer.0).map_err(|mut fault| {
            if let Some(name) = row
                .extensions
                .keys()
                .find(|name| name.ends_with("_meshopt_compression"))
            {
                fault.message = format!("{} ({path} is compressed with {name})", fault.message);
            }
            fault
        })?;
        let start = row.byte_offset.map_or(0, |offset| offset.0);
        let Some(bytes) = start
            .checked_add(row.byte_length.0)
            .and_then(|end| buffer.get(start..end))
        else {
            return Err(Fault::error(
                path,
                format!(
                    "{} bytes from byte {start} pass the end of buffer {}, which has {}",
                    row.byte_length.0,
                    row.buffer.0,
                    buffer.len()
                ),
            ));
        };
        // Zero is how glTF 1.0 wrote "tightly packed", and some exporters still do.
        let stride = match row.byte_stride {
            Some(stride) if may_stride && stride.0 != 0 => stride.0,
            _ => size,
        };
        if stride < size {
            let message = format!("the stride of {stride} bytes is less than the element size of {size} ({at})");
            return Err(Fault::error(format!("{path}/byteStride"), message));
        }
        let end = count
            .saturating_sub(1)
            .checked_mul(stride)
            .and_then(|skip| skip.checked_add(size));
        let used = match (count, end) {
            (0, _) => Some(0),
            (_, end) => end,
        };
        let elements = used.and_then(|used| bytes.get(offset..offset.checked_add(used)?)).ok_or_else(|| {
            Fault::error(
                at,
                format!(
                    "{count} elements of {size} bytes, {stride} apart, from byte {offset} pass the end of buffer view \
                     {}, which has {} bytes",
                    view.0,
                    bytes.len()
                ),
            )
        })?;
        Ok(elements
            .chunks(stride.max(1))
            .filter_map(move |chunk| chunk.get(..size)))
    }
}

fn component(number: schema::Whole, at: &str) -> Result<Component, Fault> {
    Component::from_number(number.0).ok_or_else(|| {
        let message = format!(
            "{} is no component type; expected 5120, 5121, 5122, 5123, 5125 or 5126",
            number.0
        );
        Fault::error(format!("{at}/componentType"), message)
    })
}

fn shape_name(width: usize) -> &'static str {
    match width {
        1 => "SCALAR",
        2 => "VEC2",
        3 => "VEC3",
        4 => "VEC4",
        _ => "MAT4",
    }
}
