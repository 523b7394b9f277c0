//! Columns of numbers as they lie in a buffer: encoding, and the bounds that accessors state.

use crate::gltf_json::Number;
use glam::{DMat4, DQuat, DVec3};

/// How one number is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    /// 8-bit signed.
    I8,
    /// 8-bit unsigned.
    U8,
    /// 16-bit signed.
    I16,
    /// 16-bit unsigned.
    U16,
    /// 32-bit unsigned.
    U32,
    /// 32-bit float.
    F32,
}

impl Component {
    /// The code that glTF uses.
    pub fn code(self) -> u32 {
        match self {
            Component::I8 => 5120,
            Component::U8 => 5121,
            Component::I16 => 5122,
            Component::U16 => 5123,
            Component::U32 => 5125,
            Component::F32 => 5126,
        }
    }
}

/// Numbers of one type, in rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// How each number is stored.
    pub component: Component,
    /// glTF element type.
    pub kind: &'static str,
    /// Whether integers stand for fractions.
    pub normalized: bool,
    /// Little-endian rows without padding.
    pub bytes: Vec<u8>,
    /// Number of rows.
    pub count: usize,
    /// Smallest and largest stored value per component.
    pub bounds: Vec<(Number, Number)>,
}

/// A number as f32; negative zero becomes zero so that no sign depends on how a zero came about.
pub fn narrow(value: f64) -> f32 {
    value as f32 + 0.0
}

/// Three numbers as f32.
pub fn narrow3(value: DVec3) -> [f32; 3] {
    value.to_array().map(narrow)
}

/// A rotation as f32, in glTF's order x, y, z, w.
pub fn narrow_rotation(value: DQuat) -> [f32; 4] {
    value.to_array().map(narrow)
}

impl Column {
    /// Bytes per row.
    pub fn row_bytes(&self) -> usize {
        self.bytes.len().checked_div(self.count).unwrap_or(0)
    }

    /// Rows of floats.
    pub fn floats<const N: usize>(rows: &[[f32; N]]) -> Column {
        let bounds = (0..N).map(|component| {
            let values = rows.iter().map(|row| row[component]);
            let low = values.clone().fold(f32::INFINITY, f32::min);
            let high = values.fold(f32::NEG_INFINITY, f32::max);
            (Number::Float(low), Number::Float(high))
        });
        Column {
            component: Component::F32,
            kind: kind_of(N),
            normalized: false,
            bytes: rows.iter().flatten().flat_map(|value| value.to_le_bytes()).collect(),
            count: rows.len(),
            bounds: bounds.collect(),
        }
    }

    /// Rows of integers, which must fit `component`.
    pub fn integers<const N: usize>(component: Component, normalized: bool, rows: &[[i64; N]]) -> Column {
        let bounds = (0..N).map(|index| {
            let values = rows.iter().map(|row| row[index]);
            let low = values.clone().min().unwrap_or(0);
            let high = values.max().unwrap_or(0);
            (Number::Integer(low), Number::Integer(high))
        });
        let mut bytes = Vec::new();
        for &value in rows.iter().flatten() {
            match component {
                Component::I8 => bytes.extend((value as i8).to_le_bytes()),
                Component::U8 => bytes.push(value as u8),
                Component::I16 => bytes.extend((value as i16).to_le_bytes()),
                Component::U16 => bytes.extend((value as u16).to_le_bytes()),
                Component::U32 => bytes.extend((value as u32).to_le_bytes()),
                Component::F32 => bytes.extend((value as f32).to_le_bytes()),
            }
        }
        Column {
            component,
            kind: kind_of(N),
            normalized,
            bytes,
            count: rows.len(),
            bounds: bounds.collect(),
        }
    }

    /// Points or displacements.
    pub fn vectors(values: &[DVec3]) -> Column {
        let rows: Vec<_> = values.iter().copied().map(narrow3).collect();
        Column::floats(&rows)
    }

    /// Unit normals as signed bytes, which `KHR_mesh_quantization` allows.
    pub fn byte_normals(values: &[DVec3]) -> Column {
        let rows: Vec<_> = values
            .iter()
            .map(|normal| normal.to_array().map(|value| libm::round(value * 127.0) as i64))
            .collect();
        Column::integers(Component::I8, true, &rows)
    }

    /// Rotations.
    pub fn rotations(values: &[DQuat]) -> Column {
        let rows: Vec<_> = values.iter().copied().map(narrow_rotation).collect();
        Column::floats(&rows)
    }

    /// Scalars.
    pub fn scalars(values: &[f64]) -> Column {
        let rows: Vec<_> = values.iter().map(|&value| [narrow(value)]).collect();
        Column::floats(&rows)
    }

    /// Matrices, column-major.
    pub fn matrices(values: &[DMat4]) -> Column {
        let rows: Vec<_> = values.iter().map(|matrix| matrix.to_cols_array().map(narrow)).collect();
        Column::floats(&rows)
    }

    /// Vertex numbers in the smallest type that glTF allows for them and that is at least `at_least` wide.
    pub fn indices(values: &[u32], at_least: Component) -> Column {
        let largest = values.iter().copied().max().unwrap_or(0);
        // The largest value of a type marks a restart and may not be a vertex number.
        let component = match at_least {
            Component::U8 if largest < 255 => Component::U8,
            Component::U8 | Component::U16 if largest < 65_535 => Component::U16,
            _ => Component::U32,
        };
        let rows: Vec<_> = values.iter().map(|&value| [i64::from(value)]).collect();
        Column::integers(component, false, &rows)
    }
}

fn kind_of(width: usize) -> &'static str {
    match width {
        1 => "SCALAR",
        3 => "VEC3",
        4 => "VEC4",
        _ => "MAT4",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_those_of_the_stored_values() {
        let column = Column::vectors(&[DVec3::new(0.1, -2.0, 3.0), DVec3::new(-0.1, 5.0, 3.0)]);
        assert_eq!(
            column.bounds,
            [
                (Number::Float(-0.1), Number::Float(0.1)),
                (Number::Float(-2.0), Number::Float(5.0)),
                (Number::Float(3.0), Number::Float(3.0)),
            ]
        );
        assert_eq!(column.row_bytes(), 12);
    }

    #[test]
    fn indices_never_use_the_restart_value() {
        assert_eq!(Column::indices(&[254], Component::U8).component, Component::U8);
        assert_eq!(Column::indices(&[255], Component::U8).component, Component::U16);
        assert_eq!(Column::indices(&[65_535], Component::U16).component, Component::U32);
    }

    #[test]
    fn negative_zero_is_written_as_zero() {
        assert_eq!(narrow(-0.0).to_bits(), 0);
    }
}
