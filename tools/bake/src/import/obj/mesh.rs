use super::reader::{self, Sink};
use crate::import::fault_list::FaultList;
use std::collections::BTreeMap;

/// An OBJ file as it stands in the file.
///
/// Guarantee of [`read`], where it adds no errors: at least one face has three corners, and all corners are points.
#[derive(Debug, Default)]
pub(in crate::import) struct ObjMesh {
    /// `v`, in file order.
    pub positions: Vec<[f32; 3]>,
    /// `f`, in file order.
    pub faces: Faces,
    /// Names of groups, each once, in order of first appearance.
    pub groups: Vec<String>,
    /// Where the group changes: the next face, and the group.
    group_starts: Vec<(usize, usize)>,
}

/// Polygons of any number of corners.
#[derive(Debug, Default)]
pub(in crate::import) struct Faces {
    corners: Vec<u32>,
    /// Per face, the end of its corners.
    ends: Vec<usize>,
}

impl Faces {
    /// Number of faces.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Corners of one face, counted from 0; none where there is no such face.
    pub fn get(&self, face: usize) -> Option<&[u32]> {
        let end = *self.ends.get(face)?;
        let begin = match face.checked_sub(1) {
            Some(previous) => *self.ends.get(previous)?,
            None => 0,
        };
        self.corners.get(begin..end)
    }

    fn push(&mut self, corners: &[u32]) {
        self.corners.extend_from_slice(corners);
        self.ends.push(self.corners.len());
    }
}

impl ObjMesh {
    /// Triangles of all faces in file order, each with its group: a face with corners `a b c d …` gives `a b c`,
    /// `a c d` and so on.
    pub fn triangles(&self) -> impl Iterator<Item = (usize, [u32; 3])> {
        let mut starts = self.group_starts.iter().peekable();
        let mut group = 0;
        (0..self.faces.len()).flat_map(move |face| {
            while let Some((_, next)) = starts.next_if(|(start, _)| *start <= face) {
                group = *next;
            }
            let (apex, rest) = match self.faces.get(face) {
                Some([apex, rest @ ..]) => (*apex, rest),
                _ => (0, [].as_slice()),
            };
            let group = group;
            rest.array_windows().map(move |[b, c]| (group, [apex, *b, *c]))
        })
    }
}

/// Reads an OBJ file; `stem` names the group of faces before any group. Faults are at `line N`.
pub(in crate::import) fn read(bytes: &[u8], stem: &str, faults: &mut FaultList) -> ObjMesh {
    let mut sink = MeshSink {
        mesh: ObjMesh::default(),
        stem,
        numbers: BTreeMap::new(),
        ahead: Vec::new(),
        has_triangles: false,
    };
    reader::read(bytes, &mut sink, faults);
    let MeshSink {
        mesh,
        ahead,
        has_triangles,
        ..
    } = sink;
    let count = mesh.positions.len();
    for (line, corner) in ahead {
        if corner as usize >= count {
            let message = format!("a corner names point {}; the file has {count}", u64::from(corner) + 1);
            faults.error(format!("line {line}"), message);
        }
    }
    if !has_triangles && !faults.has_errors() {
        faults.error(
            "",
            "the file has no faces; expected at least one `f` statement with three corners",
        );
    }
    mesh
}

struct MeshSink<'a> {
    mesh: ObjMesh,
    stem: &'a str,
    /// Numbers of the groups by name.
    numbers: BTreeMap<String, usize>,
    /// Line and largest corner of the faces that come before one of their points.
    ahead: Vec<(usize, u32)>,
    has_triangles: bool,
}

impl Sink for MeshSink<'_> {
    fn point(&mut self, position: [f32; 3]) {
        self.mesh.positions.push(position);
    }

    fn face(&mut self, corners: &[u32], line: usize, faults: &mut FaultList) {
        if let Some(largest) = corners.iter().copied().max()
            && largest as usize >= self.mesh.positions.len()
        {
            self.ahead.push((line, largest));
        }
        if corners.len() < 3 {
            let message = format!(
                "the face has {} corners, expected three or more; it is skipped",
                corners.len()
            );
            faults.warn(format!("line {line}"), message);
        }
        self.has_triangles |= corners.len() >= 3;
        if self.mesh.group_starts.is_empty() {
            self.group(self.stem);
        }
        self.mesh.faces.push(corners);
    }

    fn group(&mut self, name: &str) {
        let number = match self.numbers.get(name) {
            Some(number) => *number,
            None => {
                let number = self.mesh.groups.len();
                self.mesh.groups.push(name.to_owned());
                self.numbers.insert(name.to_owned(), number);
                number
            }
        };
        self.mesh.group_starts.push((self.mesh.faces.len(), number));
    }
}
